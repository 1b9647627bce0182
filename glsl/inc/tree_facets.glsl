// Facets of the tree that captures in compute walk (inc/outlines.glsl). Wants `corners`, and `across` as src/passes/cluster_tree.rs
// makes them.
Facet facet(uint number) {
    int at = 3 * int(number - 1);
    return Facet(texelFetch(corners, at), texelFetch(corners, at + 1), texelFetch(corners, at + 2).xyz);
}

uvec3 across_of(uint number) { return floatBitsToUint(texelFetch(across, int(number - 1)).xyz); }

// Alpha masks of triangles as bits. Wants `masks`, 128 bits a texel, and inc/subdivision.glsl.

// Whether the surface is there at the point (1−u−v)·a + u·b + v·c. The mask: cells along a side, 0 without one; first texel.
bool is_present(uvec2 mask, vec2 uv) {
    uint cell = cell_at(max(mask.x, 1), uv);
    uvec4 bits = floatBitsToUint(texelFetch(masks, int(mask.y + cell / 128)));
    return mask.x == 0 || (bits[cell / 32 % 4] >> cell % 32 & 1) != 0;
}

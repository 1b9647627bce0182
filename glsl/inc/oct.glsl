// Unit vectors in 32 bits: octahedral map (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent
// Unit Vectors"), 16 bits an axis.

vec2 sign_not_zero(vec2 v) { return vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0); }

uint oct_encode(vec3 v) {
    vec2 p = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    if (v.z < 0.0) p = (1.0 - abs(p.yx)) * sign_not_zero(p);
    return packSnorm2x16(p);
}

vec3 oct_decode(uint code) {
    vec2 p = unpackSnorm2x16(code);
    vec3 v = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (v.z < 0.0) v.xy = (1.0 - abs(v.yx)) * sign_not_zero(v.xy);
    return normalize(v);
}

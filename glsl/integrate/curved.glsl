// A projection that bends straight sides is drawn with chords in their place: a texel near a side may show the triangle
// beside the one that it sees, or none at all where a chord cuts a corner off. Which one it sees is found among those
// around it, by the direction itself. Wants `identities`, `push` and `cells.glsl`.

struct Meeting { uvec2 seen; bool exact; };  // identity and 1/distance as bits, at the direction's point on the triangle or the nearest one

Meeting meet(uint identity, vec3 origin, vec3 direction) {
    uint triangle = (identity & 0x7fffffffu) - 1;
    uvec3 c = corners_of(triangle);
    // Möller and Trumbore 1997.
    vec3 p0 = position_of(c.x), e1 = position_of(c.y) - p0, e2 = position_of(c.z) - p0, s = origin - p0;
    vec3 h = cross(direction, e2), q = cross(s, e1);
    float volume = dot(e1, h);
    vec3 uvt = vec3(dot(s, h), dot(direction, q), dot(e2, q)) * (volume == 0.0 ? 0.0 : 1.0 / volume);
    // A grain wider, so that a direction along a shared side meets one of the two.
    bool exact = volume != 0.0 && uvt.z > 0.0 && min(uvt.x, uvt.y) >= -1e-5 && uvt.x + uvt.y <= 1.00001;
    vec2 uv = clamp(uvt.xy, 0.0, 1.0);
    uv /= max(1.0, uv.x + uv.y);
    bool front = dot(cross(e1, e2), s) > 0.0;
    float inverse_distance = 1.0 / length(uv.x * e1 + uv.y * e2 - s);
    return Meeting(uvec2((triangle + 1) | (front ? 0x80000000u : 0), floatBitsToUint(inverse_distance)), exact);
}

uint identity_at(uvec2 tile, ivec2 at) {
    bool outside = any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(push.tile_size)));
    return outside ? 0 : texelFetch(identities, ivec3(ivec2(tile) + at, 0), 0).x;
}

// What the texel `at` of a tile sees: the triangle that it shows, the nearest of its neighbours', or further in, where a
// chord has cut off more, the first that the direction meets. The nearest point of the one it shows, if it meets none.
uvec2 look_closely(uvec2 tile, ivec2 at, vec3 origin, vec3 direction) {
    uint own = identity_at(tile, at);
    uvec2 best = uvec2(0);
    if (own != 0) {
        Meeting m = meet(own, origin, direction);
        if (m.exact) return m.seen;
        best = m.seen;
    }
    uvec2 found = uvec2(0);
    for (int i = 0; i < 9; ++i) {
        uint identity = identity_at(tile, at + ivec2(i % 3, i / 3) - 1);
        if (identity == 0 || identity == own) continue;
        Meeting m = meet(identity, origin, direction);
        if (m.exact && uintBitsToFloat(m.seen.y) > uintBitsToFloat(found.y)) found = m.seen;
    }
    vec2 inwards = 0.5 * float(push.tile_size) - (vec2(at) + 0.5);
    uint last = own, tries = 0;
    // Ever wider steps: llvmpipe ends a shader's loops after 2¹⁶ rounds in all.
    for (float steps = 2.0; found.x == 0 && steps < length(inwards) && tries < 6; steps = ceil(1.4 * steps)) {
        uint identity = identity_at(tile, at + ivec2(round(normalize(inwards) * steps)));
        if (identity == 0 || identity == last) continue;
        Meeting m = meet(identity, origin, direction);
        if (m.exact) found = m.seen;
        last = identity;
        ++tries;
    }
    return found.x != 0 ? found : best;
}

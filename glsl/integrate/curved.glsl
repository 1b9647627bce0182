// A projection that bends straight sides is drawn with chords in their place: a texel near a side may show the triangle
// beside the one that it sees, or none at all where a chord cuts a corner off. Which one it sees is found among those
// around it, by the direction itself. Wants `identities`, `push` and `cells.glsl`.

// 1/distance of a triangle (its number plus 1) in a unit direction; 0 where the direction passes beside it.
float inverse_distance_of(uint number, vec3 origin, vec3 direction) {
    uvec3 c = corners_of(number - 1);
    vec3 p0 = position_of(c.x), a = p0 - origin, e1 = position_of(c.y) - p0, e2 = position_of(c.z) - p0;
    vec2 uv = barycentrics(a, e1, e2, direction);
    // A grain wider, so that a direction along a shared side hits one of the two.
    bool hits = min(uv.x, uv.y) >= -1e-5 && uv.x + uv.y <= 1.00001;
    return hits ? max(dot(inverse_plane(a, e1, e2), direction), 0.0) : 0.0;
}

uint identity_at(uvec2 tile, ivec2 at) {
    bool outside = any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(push.tile_size)));
    return outside ? 0 : texelFetch(identities, ivec3(ivec2(tile) + at, 0), 0).x;
}

// Number plus 1 of the triangle that the texel `at` of a tile sees: the one that it shows, the nearest of its neighbours', or
// further in, where a chord has cut off more, the first that the direction hits. If it hits none, the one that it shows.
uint look_closely(uvec2 tile, ivec2 at, vec3 origin, vec3 direction) {
    uint own = identity_at(tile, at);
    if (own != 0 && inverse_distance_of(own, origin, direction) > 0.0) return own;
    uint found = 0;
    float nearest = 0.0;
    for (int i = 0; i < 9; ++i) {
        uint number = identity_at(tile, at + ivec2(i % 3, i / 3) - 1);
        if (number == 0 || number == own) continue;
        float inverse_distance = inverse_distance_of(number, origin, direction);
        if (inverse_distance > nearest) found = number;
        nearest = max(nearest, inverse_distance);
    }
    vec2 inwards = 0.5 * float(push.tile_size) - (vec2(at) + 0.5);
    uint last = own, tries = 0;
    // Ever wider steps: llvmpipe ends a shader's loops after 2¹⁶ rounds in all.
    for (float steps = 2.0; found == 0 && steps < length(inwards) && tries < 6; steps = ceil(1.4 * steps)) {
        uint number = identity_at(tile, at + ivec2(round(normalize(inwards) * steps)));
        if (number == 0 || number == last) continue;
        if (inverse_distance_of(number, origin, direction) > 0.0) found = number;
        last = number;
        ++tries;
    }
    return found != 0 ? found : own;
}

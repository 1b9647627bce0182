// What a view's pyramid leaves of a triangle, drawn as a fan of FAN triangles: for devices that set triangles up whole.
// SwiftShader takes winding and depth from corners that are not clipped yet, rounded to 1/16 of a texel: the ends of a
// wall, one before and one behind the eye, meet in its vanishing point, and then nothing of it is drawn.

// Three corners, one more for each side of the pyramid; what three of them leave of a fan.
const uint OUTLINE = 7, FAN = OUTLINE - 2;

// The fan's corner `corner` of the triangle a, b, c in clip space, as the weights of these; zero if it has none (Sutherland
// & Hodgman 1974, a side of the pyramid at a time).
vec3 fan_corner(vec4 a, vec4 b, vec4 c, uint corner) {
    vec3 outline[OUTLINE] = vec3[](vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0), vec3(0), vec3(0), vec3(0));
    uint count = 3;
    for (uint side = 0; side < 4; ++side) {
        vec3 x = side < 2 ? vec3(a.x, b.x, c.x) : vec3(a.y, b.y, c.y);
        vec3 heights = vec3(a.w, b.w, c.w) + (side % 2 == 0 ? x : -x);
        vec3 cut[OUTLINE];
        uint kept = 0;
        for (uint i = 0; i < count; ++i) {
            vec3 from = outline[i], to = outline[i + 1 < count ? i + 1 : 0];
            float h = dot(heights, from), k = dot(heights, to);
            if (h >= 0.0 && kept < OUTLINE) cut[kept++] = from;
            // From inside out, so that triangles that share the edge agree.
            if (h >= 0.0 != k >= 0.0 && kept < OUTLINE)
                cut[kept++] = h >= 0.0 ? (from * k - to * h) / (k - h) : (to * h - from * k) / (h - k);
        }
        outline = cut;
        count = kept;
    }
    uint last = corner / 3 + 2;
    if (last >= count) return vec3(0.0);
    return outline[corner % 3 == 0 ? 0 : last - 2 + corner % 3];
}

// Its clip-space position; that of a corner that there is not is the same for all three of a triangle.
vec4 fan_position(vec4 a, vec4 b, vec4 c, vec3 weights) {
    if (weights == vec3(0.0)) return vec4(0.0, 0.0, 0.0, 1.0);
    return weights.x * a + weights.y * b + weights.z * c;
}

// Is a surface point lit by a light sample? Looks the sample's depth tile up at the nearest texel and compares it there
// with the depth of the surface's *tangent plane* through the texel's centre, which is what the rasteriser stored if the
// plane itself is what the light sees: a flat surface shadows itself nowhere, whatever the slope, and nothing is pushed
// off its place. Wants `frames`, `shadow_depth`, and the constants SHADOW_VIEWS, SHADOW_SIZE, SHADOW_COLUMNS.

// Relative slack: depth rounding, and neighbours of a curved surface that stand over its tangent plane.
const float SHADOW_SLACK = 2e-3;

bool is_lit(uint tile, vec3 p, vec3 n) {
    Frame frame = frames[tile];
    vec3 l = to_local(frame, p - frame.origin.xyz);
    vec3 nl = to_local(frame, n);
    uint view = SHADOW_VIEWS == VIEWS_HEMICUBE || SHADOW_VIEWS == VIEWS_CUBE ? face_of(l) : 0;
    bool parallel = SHADOW_VIEWS == VIEWS_ORTHOGRAPHIC;
    vec3 f = face_coordinates(view, l);
    vec2 scale = SHADOW_VIEWS >= VIEWS_PLANE ? vec2(frame.tangent.w, frame.bitangent.w) : vec2(1.0);
    vec2 ndc = f.xy * scale / (parallel ? 1.0 : f.z);
    if (any(greaterThan(abs(ndc), vec2(1.0))) || (!parallel && f.z <= 0.0)) return true;

    vec2 texel = clamp((vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * float(SHADOW_SIZE), vec2(0.0), vec2(float(SHADOW_SIZE) - 1.0));
    ivec2 at = ivec2(texel);
    vec2 centre = ((vec2(at) + 0.5) / float(SHADOW_SIZE) * 2.0 - 1.0) * vec2(1.0, -1.0) / scale;
    ivec2 tile_origin = ivec2(tile % SHADOW_COLUMNS, tile / SHADOW_COLUMNS) * int(SHADOW_SIZE);
    float stored = texelFetch(shadow_depth, ivec3(tile_origin + at, int(view)), 0).x;

    vec3 nf = face_coordinates(view, nl);
    if (parallel) {
        // n·(q − p) = 0 with q = (centre, z).
        float z = abs(nf.z) > 1e-4 ? f.z - dot(nf.xy, centre - f.xy) / nf.z : f.z;
        z = clamp(z, f.z - 16.0 / (frame.tangent.w * SHADOW_SIZE), f.z);
        float slack = SHADOW_SLACK / frame.tangent.w * 0.25;
        return 1.0 - (z - slack) * frame.normal.w >= stored;
    }
    // n·(t·(centre, 1) − p) = 0.
    float towards = dot(nf, vec3(centre, 1.0));
    float z = dot(nf, f) / (abs(towards) > 1e-6 ? towards : 1e-6);
    // A grazing plane may meet the texel's ray far off: never further than half the distance, nor behind the point.
    z = clamp(z, 0.5 * f.z, f.z);
    return frame.origin.w / (z * (1.0 - SHADOW_SLACK)) >= stored;
}

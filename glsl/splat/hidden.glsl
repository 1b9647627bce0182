// Whether something stands between a record and a point, by the distances that the record's hemicube has seen: light
// must not pass a thin wall, nor reach around an edge, from a record on the other side. CPU twin: math::visibility.
// Wants `frames`, `seen`, SEEN_SIZE and SEEN_STRIDE.

const float HIDDEN_TOLERANCE = 0.1;  // of the distance

// 1/forward distance of what a texel of a side face sees: linear in the column along a plane.
float inverse_forward(uint record, uint view, ivec2 texel) {
    int n = int(SEEN_SIZE);
    texel.y = clamp(texel.y, 0, n / 2 - 1);
    uint at = 3 * uint(n * n) * record + uint(n * n) + (view - 1) * uint(n * n / 2) + uint(texel.y * n + texel.x);
    vec2 p = (vec2(texel) + 0.5) * (2.0 / float(n)) * vec2(1.0, -1.0) + vec2(-1.0, 1.0);
    return seen[SEEN_STRIDE * at + min(SEEN_STRIDE, 4) - 1] * sqrt(1.0 + dot(p, p));
}

bool hidden(uint record, vec3 offset) {
    Frame frame = frames[record];
    vec3 l = to_local(frame, offset);
    float reach = max(abs(l.x), abs(l.y));
    if (l.z >= reach) return false;  // above the sides: no thin wall stands so
    uint view = face_of(vec3(l.xy, 0.0));
    vec3 f = face_coordinates(view, l);
    // What lies below the lowest row's centres is taken for seen along it.
    vec2 at = vec2(f.x, -max(f.y, 0.0)) / f.z;
    at = (at * 0.5 + 0.5) * float(SEEN_SIZE) - 0.5;
    // Before a face's first centre and past its last the line goes on.
    ivec2 texel = ivec2(clamp(int(floor(at.x)), 0, int(SEEN_SIZE) - 2), int(floor(at.y)));
    float x = at.x - float(texel.x);
    // The further of two rows: on a concave surface the lower one sees the surface before the point.
    float upper = mix(inverse_forward(record, view, texel), inverse_forward(record, view, texel + ivec2(1, 0)), x);
    float lower = mix(inverse_forward(record, view, texel + ivec2(0, 1)), inverse_forward(record, view, texel + 1), x);
    return f.z * min(upper, lower) > 1.0 + HIDDEN_TOLERANCE;
}

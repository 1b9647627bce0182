// A triangle cut into r² equal ones ("cells"): row i, from vertex 0 towards vertex 1, has 2(r − i) − 1 of them.

// Cell that holds the point (1−u−v)·p0 + u·p1 + v·p2.
uint cell_at(uint r, vec2 uv) {
    vec2 s = clamp(uv, 0.0, 1.0) * float(r);
    uint i = min(uint(s.x), r - 1);
    uint j = min(uint(s.y), r - 1 - i);
    vec2 f = s - vec2(i, j);
    uint upper = f.x + f.y > 1.0 && i + j + 2 <= r ? 1 : 0;
    return i * (2 * r - i) + 2 * j + upper;
}

// Barycentric (u, v) of the point (s, t), s + t ≤ 1, of a cell; the inverse of `cell_at`.
vec2 cell_point(uint r, uint cell, vec2 st) {
    float rest = float(r * r - cell);
    uint i = r - uint(ceil(sqrt(rest) - 1e-4));
    uint along = cell - i * (2 * r - i);
    uint j = along / 2;
    vec2 corner = vec2(i, j);
    return ((along & 1) == 0 ? corner + st : corner + 1.0 - st) / float(r);
}

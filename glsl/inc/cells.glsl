// The lit surface: each triangle is cut into r² equal triangles ("cells"), each holding the radiance that leaves it to
// its front and to its back. Cells of a triangle start at first_cell[triangle]; row i (from vertex 0 towards vertex 1)
// has 2(r − i) − 1 cells. Wants `first_cell`, `cell_radiance`, `positions` and `indices`.

#include "inc/triangles.glsl"

uint cell_resolution(uint cells) { return uint(sqrt(float(cells)) + 0.5); }

// Cell that holds the point (1−u−v)·p0 + u·p1 + v·p2, from the first of its triangle.
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

// Radiance that leaves a triangle's surface towards `origin`, seen along `direction` (any length).
vec3 surface_radiance(uint triangle, bool front, vec3 origin, vec3 direction) {
    uint first = first_cell[triangle];
    uint cells = first_cell[triangle + 1] - first;
    if (cells > 1) {
        uvec3 c = corners_of(triangle);
        vec3 p0 = position_of(c.x);
        // Möller and Trumbore 1997.
        vec3 e1 = position_of(c.y) - p0, e2 = position_of(c.z) - p0, s = origin - p0;
        vec3 h = cross(direction, e2), q = cross(s, e1);
        float inverse = 1.0 / dot(e1, h);
        first += cell_at(cell_resolution(cells), vec2(dot(s, h), dot(direction, q)) * inverse);
    }
    uint at = 6 * first + (front ? 0 : 3);
    return vec3(cell_radiance[at], cell_radiance[at + 1], cell_radiance[at + 2]);
}

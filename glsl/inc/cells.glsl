// The lit surface: each triangle is cut into r² cells, each holding the radiance that leaves it to its front and to its
// back. Cells of a triangle start at first_cell[triangle]. Wants `first_cell` and `cell_radiance`.

#include "inc/subdivision.glsl"

uint cell_resolution(uint cells) { return uint(sqrt(float(cells)) + 0.5); }

// The cell of a triangle at the point (1−u−v)·p0 + u·p1 + v·p2.
uint cell_of(uint triangle, vec2 uv) {
    uint first = first_cell[triangle], cells = first_cell[triangle + 1] - first;
    return first + cell_at(cell_resolution(cells), uv);
}

// Radiance that leaves a cell.
vec3 cell_light(uint cell, bool front) {
    uint at = 6 * cell + (front ? 0 : 3);
    return vec3(cell_radiance[at], cell_radiance[at + 1], cell_radiance[at + 2]);
}

// (u, v) of the point of a triangle that a direction (any length) from the origin meets: its first corner is `a`, e1 and
// e2 lead from there to the others (Möller and Trumbore 1997).
vec2 barycentrics(vec3 a, vec3 e1, vec3 e2, vec3 direction) {
    vec3 h = cross(direction, e2), q = cross(a, e1);
    return -vec2(dot(a, h), dot(direction, q)) / dot(e1, h);
}

// Its plane: along any unit direction the dot product is 1/distance from the origin.
vec3 inverse_plane(vec3 a, vec3 e1, vec3 e2) {
    vec3 n = cross(e1, e2);
    float height = dot(n, a);
    return height != 0.0 ? n / height : vec3(0.0);
}

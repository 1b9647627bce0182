// The lit surface: each triangle is cut into r² cells, each holding the radiance that leaves it to its front and to its
// back. Cells of a triangle start at first_cell[triangle]. Wants `first_cell`, `cell_radiance`, `positions` and `indices`.

#include "inc/subdivision.glsl"
#include "inc/triangles.glsl"

uint cell_resolution(uint cells) { return uint(sqrt(float(cells)) + 0.5); }

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

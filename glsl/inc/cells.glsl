// The lit surface: each triangle is cut into r² cells, each holding the radiance that leaves it to its front and to its
// back. Cells of a triangle follow each other.

#include "inc/subdivision.glsl"

uint cell_resolution(uint cells) { return uint(sqrt(float(cells)) + 0.5); }

// (u, v) of the point of a triangle that a direction (any length) from the origin meets: its first corner is `a`, e1 and
// e2 lead from there to the others (Möller and Trumbore 1997).
vec2 barycentrics(vec3 a, vec3 e1, vec3 e2, vec3 direction) {
    vec3 h = cross(direction, e2), q = cross(a, e1);
    return -vec2(dot(a, h), dot(direction, q)) / dot(e1, h);
}

// (u, v) of a point of the triangle: that of a direction which passes beside it, as the rounding of a rasteriser lets it, is
// moved onto it; where the triangle is seen edge-on it may be any of its points.
vec2 within(vec2 uv) {
    uv = min(mix(vec2(0.0), uv, greaterThan(uv, vec2(0.0))), 1.0);
    return uv / max(1.0, uv.x + uv.y);
}

// Its plane: along any unit direction the dot product is 1/distance from the origin.
vec3 inverse_plane(vec3 a, vec3 e1, vec3 e2) {
    vec3 n = cross(e1, e2);
    float height = dot(n, a);
    return height != 0.0 ? n / height : vec3(0.0);
}

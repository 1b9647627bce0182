// Draws the scene's slices along one axis by parallel projection, from both sides at once (Fournier and Péroche 2005, 5.3):
// of each slice and sample the surface that is outermost to either side. An invocation a triangle and band of rows. Two
// dispatches: keys of distances first, then the cells that have them; of equal ones the first, so that the order of invocations
// does not tell.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint HAS_MASKS = 0;
layout(set = 0, binding = 0) uniform textureBuffer corners;  // as in glsl/capture_compute/body.glsl
layout(set = 0, binding = 1) uniform textureBuffer masks;
// Four a sample, all the greater the sooner they are taken: complement of the distance from below, distance, complements of
// what is seen from below and from above, a cell twice plus 1 for its back; 0: nothing.
layout(set = 0, binding = 2, std430) buffer Samples { uint samples[]; };

#include "slices/grid.glsl"
#include "inc/invocation.glsl"
#include "inc/subdivision.glsl"
#include "inc/mask.glsl"

const int BAND = 32;  // rows; BAND in src/passes/slices.rs

float perp_dot(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

void draw(uint at, float height, uint below, uint above) {
    uint bits = floatBitsToUint(height);
    if (push.phase == 0) {
        atomicMax(samples[4 * at], ~bits);
        atomicMax(samples[4 * at + 1], bits);
    } else {
        if (samples[4 * at] == ~bits) atomicMax(samples[4 * at + 2], ~below);
        if (samples[4 * at + 1] == bits) atomicMax(samples[4 * at + 3], ~above);
    }
}

void main() {
    uint triangle = invocation();
    if (triangle >= push.triangles) return;
    vec4 corner[3];
    vec3 p[3];
    uvec3 size = turned(dims()) * uvec3(SAMPLES, SAMPLES, 1);
    for (int i = 0; i < 3; ++i) {
        corner[i] = texelFetch(corners, int(3 * triangle) + i);
        vec3 low = vec3(push.low[0], push.low[1], push.low[2]);
        vec3 per_length = vec3(push.per_length[0], push.per_length[1], push.per_length[2]);
        p[i] = turned((corner[i].xyz - low) * per_length) * vec3(SAMPLES, SAMPLES, 1.0);
    }
    uint cell = floatBitsToUint(corner[0].w), sides = floatBitsToUint(corner[1].w);
    uvec2 mask = uvec2(sides & 0xffffu, floatBitsToUint(corner[2].w));
    vec2 e1 = p[1].xy - p[0].xy, e2 = p[2].xy - p[0].xy;
    float area = perp_dot(e1, e2);
    // Samples lie at halves.
    int band = BAND * int(gl_WorkGroupID.z);
    ivec2 low = ivec2(ceil(min(p[0].xy, min(p[1].xy, p[2].xy)) - 0.5));
    ivec2 high = ivec2(floor(max(p[0].xy, max(p[1].xy, p[2].xy)) - 0.5));
    low = max(low, ivec2(0, band));
    high = min(high, ivec2(int(size.x) - 1, min(band + BAND, int(size.y)) - 1));
    // Coarse triangles stand for fine ones, which are drawn.
    if (area == 0.0 || cell >= push.first_coarse_cell || low.x > high.x) high.y = low.y - 1;
    ivec2 at = low;
    while (at.y <= high.y) {
        vec2 s = vec2(at) + 0.5 - p[0].xy;
        precise float u = perp_dot(s, e2) / area, v = perp_dot(e1, s) / area;
        precise float height = p[0].z + u * (p[1].z - p[0].z) + v * (p[2].z - p[0].z);
        height = clamp(height, 0.0, float(size.z) - 0.5);
        bool drawn = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        if (HAS_MASKS != 0) drawn = drawn && is_present(mask, vec2(u, v));
        if (drawn) {
            uint seen = 2 * (cell + cell_at(sides >> 16, vec2(u, v)));
            // The front is where the normal leads.
            uint is_up = area > 0.0 ? 1 : 0;
            draw(sample_at(uvec3(at, uint(height))), height, seen + is_up, seen + 1 - is_up);
        }
        bool ends = at.x == high.x;
        at = ends ? ivec2(low.x, at.y + 1) : ivec2(at.x + 1, at.y);
    }
}

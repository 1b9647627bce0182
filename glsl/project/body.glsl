// Projects captures onto a basis: each coefficient ∫ L·B dω, its gradient as the point moves, and the harmonic mean distance. L is
// what surfaces and the sky send together. One workgroup a (record, tile of four coefficients); every sum has a fixed order. The
// tables come from math::capture::Weights, whose `integrate` is the CPU twin.
#extension GL_GOOGLE_include_directive : require
const uint THREADS = 64;
layout(local_size_x = THREADS) in;

layout(constant_id = 0) const uint HAS_SKY = 0;
layout(constant_id = 1) const uint HAS_TRANSLATION = 1;  // planes are kept
layout(constant_id = 2) const uint HAS_GRADIENTS = 1;

#ifdef FROM_COMPUTE
layout(set = 0, binding = 0) uniform textureBuffer gathered;  // laid out as inc/gathered.glsl says
vec4 gathered_value(uint at) { return texelFetch(gathered, int(at)); }
#else
layout(set = 0, binding = 0, std430) readonly buffer Gathered { vec4 gathered[]; };
vec4 gathered_value(uint at) { return gathered[at]; }
#endif
// Tile by tile, of each texel its four weights; then of each texel its share in the harmonic mean distance.
layout(set = 0, binding = 1, std430) readonly buffer Weights { vec4 weights[]; };
layout(set = 0, binding = 2, std430) readonly buffer Places { uvec2 places[]; };     // of each edge its two texels
layout(set = 0, binding = 3, std430) readonly buffer Middles { vec4 middles[]; };  // of each edge the direction between them
layout(set = 0, binding = 4, std430) readonly buffer Steps { vec4 steps[]; };      // tile by tile, of each edge ∫ B m dl: x, y, z
layout(set = 0, binding = 5, std430) writeonly buffer Results { float results[]; };
layout(push_constant) uniform Push {
    uint texel_count;
    uint edge_count;
    uint tiles;
} push;

#include "inc/gathered.glsl"
#include "inc/sums.glsl"

// Sums of a tile, each of four coefficients: values of the three channels; gradients along x, y, z, channel by channel; 1/R.
const uint GRADIENTS = 3, DISTANCE = 12, SUMS_OF_TILE = 13, COEFFICIENTS = 4;
const uint FLOATS = SUMS_OF_TILE * COEFFICIENTS, ROW = THREADS + 1;
shared float parts[FLOATS * ROW];

void put(uint which, vec4 v) {
    for (uint c = 0; c < COEFFICIENTS; ++c) parts[(which * COEFFICIENTS + c) * ROW + gl_LocalInvocationID.x] = v[c];
}

vec3 light_at(uint at) {
    vec3 light = gathered_value(at).rgb;
    return HAS_SKY != 0 ? light + gathered_value(at + 1).rgb : light;
}

void sum_texels(uint base, uint tile) {
    vec4 r = vec4(0.0), g = vec4(0.0), b = vec4(0.0);
    float nearness = 0.0;
    uint first = tile * push.texel_count, shares = push.tiles * push.texel_count;
    for (uint i = gl_LocalInvocationID.x; i < push.texel_count; i += THREADS) {
        uint at = STRIDE * (base + i);
        vec4 weight = weights[first + i];
        vec3 light = light_at(at);
        r += light.r * weight;
        g += light.g * weight;
        b += light.b * weight;
        if (tile == 0) nearness += weights[shares + i].x * gathered_value(at).w;
    }
    put(0, r);
    put(1, g);
    put(2, b);
    put(DISTANCE, vec4(nearness, 0.0, 0.0, 0.0));
}

void sum_edges(uint base, uint tile) {
    mat3x4 red = mat3x4(0.0), green = red, blue = red;  // columns: x, y, z
    uint first = 3 * tile * push.edge_count;
    for (uint e = gl_LocalInvocationID.x; e < push.edge_count; e += THREADS) {
        uvec2 at = STRIDE * (base + places[e]);
        vec4 a = gathered_value(at.x), b = gathered_value(at.y);
        vec3 plane = gathered_value((a.w < b.w ? at.y : at.x) + STRIDE - 1).xyz;
        vec3 change = (light_at(at.y) - light_at(at.x)) * bounded(dot(plane, middles[e].xyz), max(a.w, b.w));
        mat3x4 step_ = mat3x4(steps[first + 3 * e], steps[first + 3 * e + 1], steps[first + 3 * e + 2]);
        red += change.r * step_;
        green += change.g * step_;
        blue += change.b * step_;
    }
    for (uint axis = 0; axis < 3; ++axis) {
        put(GRADIENTS + 3 * axis, red[axis]);
        put(GRADIENTS + 3 * axis + 1, green[axis]);
        put(GRADIENTS + 3 * axis + 2, blue[axis]);
    }
}

void main() {
    uint record = gl_WorkGroupID.x, tile = gl_WorkGroupID.y, base = record * push.texel_count;
    sum_texels(base, tile);
    if (HAS_GRADIENTS != 0) sum_edges(base, tile);
    else for (uint which = GRADIENTS; which < DISTANCE; ++which) put(which, vec4(0.0));
    barrier();
    uint to = (record * push.tiles + tile) * FLOATS;
    for (uint which = gl_LocalInvocationID.x; which < FLOATS; which += THREADS) {
        float all = 0.0;
        for (uint i = 0; i < THREADS; ++i) all += parts[which * ROW + i];
        results[to + which] = all;
    }
}

// Pixels of a lattice that no record covers yet, or whose records disagree, in scan order. Three dispatches share this shader: count
// by workgroup, sum the counts (one workgroup), write the pixels. Prefix sums instead of atomics: the same order every time. A fourth
// one marks the pixels that earlier views' records cover: these views decided how many records are enough there.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "inc/invocation.glsl"
const uint GROUP = 128;  // every device runs as many (maxComputeWorkGroupInvocations)
layout(local_size_x = GROUP) in;
layout(constant_id = 0) const uint PHASE = 0;  // 0 count, 1 sum, 2 write, 3 mark
layout(constant_id = 1) const uint HAS_CONTRAST = 0;

layout(set = 0, binding = 0) uniform texture2D gbuffer_position;
layout(set = 0, binding = 1) uniform texture2D accumulated;
layout(set = 0, binding = 2, std430) buffer Groups { uint groups[]; };
layout(set = 0, binding = 3, std430) buffer Found { uint found_count; uint pixels[]; };
layout(set = 0, binding = 4) uniform texture2D tally;  // of the splats
layout(set = 0, binding = 5, std430) buffer Settled { uint settled[]; };  // a bit a pixel: earlier views' records cover it
layout(push_constant) uniform Push { uvec2 size; uvec2 offset; uvec2 lattice; uint stride; float covered; float contrast; } push;

shared uint sums[GROUP];

// Inclusive prefix sum over the workgroup (Hillis and Steele 1986).
uint prefix_sum(uint value) {
    uint me = gl_LocalInvocationID.x;
    sums[me] = value;
    barrier();
    for (uint step = 1; step < GROUP; step *= 2) {
        uint add = me >= step ? sums[me - step] : 0;
        barrier();
        sums[me] += add;
        barrier();
    }
    return sums[me];
}

void sum_groups() {
    uint total = (push.lattice.x * push.lattice.y + GROUP - 1) / GROUP;
    uint base = 0;
    for (uint start = 0; start < total; start += GROUP) {
        uint at = start + gl_LocalInvocationID.x;
        uint value = at < total ? groups[at] : 0;
        uint inclusive = prefix_sum(value);
        if (at < total) groups[at] = base + inclusive - value;
        base += sums[GROUP - 1];
        barrier();
    }
    if (gl_LocalInvocationID.x == 0) found_count = base;
}

// Whether what the records say at a pixel differs by more than the contrast: σ > c·L, L the mean of their luminances.
bool disputed(ivec2 pixel, float weight) {
    vec2 moments = texelFetch(tally, pixel, 0).yz / weight;
    float limit = push.contrast * moments.x;
    return moments.y - moments.x * moments.x > limit * limit;
}

void main() {
    if (PHASE == 1) {
        sum_groups();
        return;
    }
    uint at = invocation();
    uint group = at / GROUP;
    uvec2 pixel = push.offset + push.stride * uvec2(at % push.lattice.x, at / push.lattice.x);
    bool inside = at < push.lattice.x * push.lattice.y && all(lessThan(pixel, push.size));
    bool open = inside && texelFetch(gbuffer_position, ivec2(pixel), 0).w == 1.0;
    if (open) {
        float weight = texelFetch(accumulated, ivec2(pixel), 0).w;
        bool bare = weight < push.covered;
        uint number = pixel.y * push.size.x + pixel.x;
        if (PHASE == 3 && !bare) atomicOr(settled[number / 32], 1u << number % 32);
        bool asks = HAS_CONTRAST != 0 && push.contrast > 0.0 && !bare && (settled[number / 32] >> number % 32 & 1u) == 0;
        open = bare || (asks && disputed(ivec2(pixel), weight));
    }
    if (PHASE == 3) return;
    uint inclusive = prefix_sum(open ? 1 : 0);
    if (PHASE == 0) {
        if (gl_LocalInvocationID.x == GROUP - 1) groups[group] = inclusive;
    } else if (open) {
        pixels[groups[group] + inclusive - 1] = pixel.y * push.size.x + pixel.x;
    }
}

// Any workgroup of 64.
#version 460
#extension GL_GOOGLE_include_directive : require

// All invocations are here before one goes on, and see what others wrote to shared memory.
void meet() { barrier(); }

shared uint wanting[2];  // bits of invocations

// Of the invocations that want a place in a row, in their order: how many come before this one, how many there are.
uvec2 places(bool wanted) {
    uint me = gl_LocalInvocationID.x, bit = 1u << me % 32;
    if (me < 2) wanting[me] = 0;
    barrier();
    if (wanted) atomicOr(wanting[me / 32], bit);
    barrier();
    uint low = bitCount(wanting[0]), before = bitCount(wanting[me / 32] & (bit - 1)) + (me < 32 ? 0 : low);
    uint all = low + bitCount(wanting[1]);
    barrier();
    return uvec2(before, all);
}

#include "capture_compute/body.glsl"

// A workgroup is one subgroup, which sums the face that it draws: no invocation waits for another, and each may ask the next.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SUMMING
#include "capture_compute/subgroup.glsl"
#include "capture_compute/body.glsl"

// A workgroup is one subgroup, which writes what every texel sees: no invocation waits for another, and each may ask the next.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "capture_compute/subgroup.glsl"
#include "capture_compute/body.glsl"

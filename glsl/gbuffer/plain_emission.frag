#version 460
#extension GL_GOOGLE_include_directive : require
#define EMISSION
#include "gbuffer/fragment.glsl"

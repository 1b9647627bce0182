#version 460
#extension GL_GOOGLE_include_directive : require
#define IDENTITY
#define FRAME_SET 1
#include "capture/masked_vert.glsl"

#version 460
#extension GL_GOOGLE_include_directive : require
#define IDENTITY
#define TEXTURED
#define FRAME_SET 2
#include "capture/masked_vert.glsl"

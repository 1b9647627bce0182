#version 460
#extension GL_GOOGLE_include_directive : require
#define IDENTITY
#include "capture/capture_body.glsl"

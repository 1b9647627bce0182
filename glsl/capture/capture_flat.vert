#version 460
#extension GL_GOOGLE_include_directive : require
// Every triangle has vertices of its own.
#define TRIANGLE gl_VertexIndex / 3
#include "capture/capture_body.glsl"

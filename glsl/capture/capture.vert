#version 460
#extension GL_GOOGLE_include_directive : require
// A draw's first triangle is its instance: the fragment shader adds gl_PrimitiveID.
#define TRIANGLE gl_InstanceIndex
#include "capture/capture_body.glsl"

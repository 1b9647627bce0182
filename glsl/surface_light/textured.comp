#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#define TEXTURED
#define LIGHT_SET 2
#include "surface_light/body.glsl"

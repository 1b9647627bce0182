// Direct irradiance of each pixel: adds the light samples of the current batch of shadow views.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/views.glsl"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint LIGHT_KIND = 0;
layout(constant_id = 1) const uint SHADOW_VIEWS = 0;
layout(constant_id = 2) const uint SHADOW_SIZE = 256;
layout(constant_id = 3) const uint SHADOW_COLUMNS = 1;

layout(set = 0, binding = 0, std430) readonly buffer Lights { LightSample lights[]; };
layout(set = 0, binding = 1, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 2) uniform texture2DArray shadow_depth;
layout(set = 0, binding = 3) uniform texture2D gbuffer_position;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 5, std430) buffer Direct { vec4 direct[]; };
layout(push_constant) uniform Push { uint width; uint height; uint light_count; float lift; } push;

#include "inc/light.glsl"
#include "inc/shadow.glsl"

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= push.width * push.height) return;
    ivec2 xy = ivec2(pixel % push.width, pixel / push.width);
    vec4 surface = texelFetch(gbuffer_position, xy, 0);
    if (surface.w != 1.0) return;
    uvec2 codes = texelFetch(gbuffer_normals, xy, 0).xy;
    vec3 n = oct_decode(codes.x), ng = oct_decode(codes.y);
    vec3 lifted = surface.xyz + ng * push.lift;
    vec3 sum = vec3(0.0);
    for (uint l = 0; l < push.light_count; ++l) {
        Arriving light = light_arriving(lights[l], surface.xyz);
        float cosine = dot(n, light.direction);
        if (cosine <= 0.0 || dot(ng, light.direction) <= 0.0 || !any(greaterThan(light.irradiance, vec3(0.0)))) continue;
        if (is_lit(l, lifted, ng)) sum += light.irradiance * cosine;
    }
    direct[pixel] += vec4(sum, 0.0);
}

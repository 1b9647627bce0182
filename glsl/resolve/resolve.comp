// The image: divides the splats' sums by their weights, multiplies by albedo/π, adds direct light and emission. Writes the
// planes of the layers that are asked for; a plane of −1 is not.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
layout(local_size_x = 64) in;
#include "inc/invocation.glsl"
layout(constant_id = 0) const uint HAS_INDIRECT = 1;
layout(constant_id = 1) const uint HAS_SKY = 0;
layout(constant_id = 2) const uint HAS_LIGHTS = 1;
layout(constant_id = 3) const uint HAS_EMISSION = 0;
layout(constant_id = 4) const uint COUNTS_RECORDS = 0;

layout(set = 0, binding = 0) uniform texture2D gbuffer_position;
layout(set = 0, binding = 1) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 2) uniform texture2D gbuffer_albedo;
layout(set = 0, binding = 3) uniform texture2D gbuffer_emission;
layout(set = 0, binding = 4) uniform texture2D indirect_sum;
layout(set = 0, binding = 5) uniform texture2D sky_sum;
layout(set = 0, binding = 6) uniform texture2D record_count;
layout(set = 0, binding = 7, std430) readonly buffer Direct { vec4 direct[]; };
layout(set = 0, binding = 8, std430) readonly buffer Sky { uvec4 sky_size; vec4 sky[]; };
layout(set = 0, binding = 9, std430) writeonly buffer Planes { float planes[]; };
layout(push_constant) uniform Push {
    mat4 clip_to_world_direction;
    vec4 forward;  // camera axis, relative to the eye; w: −(axis · eye)
    uvec2 size;
    int final_plane, direct_plane, indirect_plane, irradiance_plane, direct_irradiance_plane, albedo_plane;
} push;
layout(constant_id = 5) const int EMISSION_PLANE = -1;
layout(constant_id = 6) const int NORMAL_PLANE = -1;
layout(constant_id = 7) const int POSITION_PLANE = -1;
layout(constant_id = 8) const int DEPTH_PLANE = -1;
layout(constant_id = 9) const int RECORDS_PLANE = -1;
layout(constant_id = 10) const int MASK_PLANE = -1;
#include "inc/sky.glsl"

void put(int plane, uint pixel, vec3 value) {
    if (plane < 0) return;
    uint pixels = push.size.x * push.size.y;
    for (int c = 0; c < 3; ++c) planes[(plane + c) * pixels + pixel] = value[c];
}

void put(int plane, uint pixel, float value) {
    if (plane >= 0) planes[plane * push.size.x * push.size.y + pixel] = value;
}

vec3 divided(vec4 sum) { return sum.w > 0.0 ? sum.rgb / sum.w : vec3(0.0); }

void main() {
    uint pixel = invocation();
    if (pixel >= push.size.x * push.size.y) return;
    ivec2 xy = ivec2(pixel % push.size.x, pixel / push.size.x);
    vec4 surface = texelFetch(gbuffer_position, xy, 0);
    bool hit = surface.w > 0.0;
    vec3 e_direct = HAS_LIGHTS != 0 && hit ? direct[pixel].rgb : vec3(0.0);
    if (HAS_SKY != 0 && HAS_INDIRECT != 0) e_direct += divided(texelFetch(sky_sum, xy, 0));
    vec3 e_indirect = HAS_INDIRECT != 0 ? divided(texelFetch(indirect_sum, xy, 0)) : vec3(0.0);
    vec3 albedo = hit ? texelFetch(gbuffer_albedo, xy, 0).rgb : vec3(0.0);
    vec3 emission = HAS_EMISSION != 0 && hit ? texelFetch(gbuffer_emission, xy, 0).rgb : vec3(0.0);
    if (HAS_SKY != 0 && !hit) {
        vec2 ndc = (vec2(xy) + 0.5) / vec2(push.size) * 2.0 - 1.0;
        emission = sky_radiance((push.clip_to_world_direction * vec4(ndc, 1.0, 1.0)).xyz);
    }
    // precise: rounded the same way whichever constants leave parts out.
    precise vec3 out_direct = albedo * e_direct / PI, out_indirect = albedo * e_indirect / PI;
    precise vec3 all = out_direct + out_indirect + emission;
    put(push.final_plane, pixel, all);
    put(push.direct_plane, pixel, out_direct);
    put(push.indirect_plane, pixel, out_indirect);
    put(push.irradiance_plane, pixel, e_indirect);
    put(push.direct_irradiance_plane, pixel, e_direct);
    put(push.albedo_plane, pixel, albedo);
    put(EMISSION_PLANE, pixel, emission);
    uvec2 codes = texelFetch(gbuffer_normals, xy, 0).xy;
    put(NORMAL_PLANE, pixel, hit ? oct_decode(codes.x) : vec3(0.0));
    put(POSITION_PLANE, pixel, hit ? surface.xyz : vec3(0.0));
    put(DEPTH_PLANE, pixel, hit ? dot(push.forward.xyz, surface.xyz) + push.forward.w : 0.0);
    put(RECORDS_PLANE, pixel, COUNTS_RECORDS != 0 ? texelFetch(record_count, xy, 0).x : 0.0);
    put(MASK_PLANE, pixel, surface.w == 1.0 ? 1.0 : 0.0);
}

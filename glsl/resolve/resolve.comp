// Variants: INDIRECT SKY LIGHTS EMISSION RECORDS
// The image: divides the splats' sums by their weights, multiplies by albedo/π, adds direct light and emission. Writes the
// planes of the layers that are asked for; a plane of −1 is not. A dispatch writes a band: pixels after each other, as many as
// the output holds.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
layout(local_size_x = 64) in;
#include "inc/invocation.glsl"

layout(set = 0, binding = 0) uniform texture2D gbuffer_position;
layout(set = 0, binding = 1) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 2) uniform texture2D gbuffer_albedo;
#ifdef EMISSION
layout(set = 0, binding = 3) uniform texture2D gbuffer_emission;
#endif
#ifdef INDIRECT
layout(set = 0, binding = 4) uniform texture2D indirect_sum;
#endif
#ifdef SKY
#ifdef INDIRECT
layout(set = 0, binding = 5) uniform texture2D sky_sum;
#endif
layout(set = 0, binding = 8, std430) readonly buffer Sky { uvec4 sky_size; vec4 sky[]; };
#endif
#ifdef RECORDS
layout(set = 0, binding = 6) uniform texture2D record_count;
#endif
#ifdef LIGHTS
layout(set = 0, binding = 7, rgba32f) uniform readonly image2D direct;
#endif
layout(set = 0, binding = 9, std430) writeonly buffer Planes { float planes[]; };
layout(push_constant) uniform Push {
    mat4 clip_to_world_direction;
    vec4 forward;  // camera axis, relative to the eye; w: −(axis · eye)
    uvec2 size;
    uvec2 band;  // its first pixel, its number of pixels
    int final_plane, direct_plane, indirect_plane, irradiance_plane, direct_irradiance_plane, albedo_plane;
} push;
layout(constant_id = 0) const int EMISSION_PLANE = -1;
layout(constant_id = 1) const int NORMAL_PLANE = -1;
layout(constant_id = 2) const int POSITION_PLANE = -1;
layout(constant_id = 3) const int DEPTH_PLANE = -1;
layout(constant_id = 4) const int RECORDS_PLANE = -1;
layout(constant_id = 5) const int MASK_PLANE = -1;
#ifdef SKY
#include "inc/sky.glsl"
#endif

void put(int plane, uint pixel, vec3 value) {
    if (plane < 0) return;
    for (int c = 0; c < 3; ++c) planes[(plane + c) * push.band.y + pixel] = value[c];
}

void put(int plane, uint pixel, float value) {
    if (plane >= 0) planes[plane * push.band.y + pixel] = value;
}

vec3 divided(vec4 sum) { return sum.w > 0.0 ? sum.rgb / sum.w : vec3(0.0); }

void main() {
    uint pixel = invocation();
    if (pixel >= push.band.y) return;
    ivec2 xy = ivec2((push.band.x + pixel) % push.size.x, (push.band.x + pixel) / push.size.x);
    vec4 surface = texelFetch(gbuffer_position, xy, 0);
    bool hit = surface.w > 0.0;
    vec3 e_direct = vec3(0.0), e_indirect = vec3(0.0), emission = vec3(0.0);
#ifdef LIGHTS
    if (hit) e_direct = imageLoad(direct, xy).rgb;
#endif
#ifdef INDIRECT
    e_indirect = divided(texelFetch(indirect_sum, xy, 0));
#ifdef SKY
    e_direct += divided(texelFetch(sky_sum, xy, 0));
#endif
#endif
    vec3 albedo = hit ? texelFetch(gbuffer_albedo, xy, 0).rgb : vec3(0.0);
#ifdef EMISSION
    if (hit) emission = texelFetch(gbuffer_emission, xy, 0).rgb;
#endif
#ifdef SKY
    if (!hit) {
        vec2 ndc = (vec2(xy) + 0.5) / vec2(push.size) * 2.0 - 1.0;
        emission = sky_radiance((push.clip_to_world_direction * vec4(ndc, 1.0, 1.0)).xyz);
    }
#endif
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
#ifdef RECORDS
    put(RECORDS_PLANE, pixel, texelFetch(record_count, xy, 0).x);
#else
    put(RECORDS_PLANE, pixel, 0.0);
#endif
    put(MASK_PLANE, pixel, surface.w == 1.0 ? 1.0 : 0.0);
}

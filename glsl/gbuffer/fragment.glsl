// G-buffer of the visible surface at each pixel's centre, on the viewer's side.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/material_textures.glsl"
#include "inc/surface.glsl"

layout(push_constant) uniform Push { mat4 world_to_clip; vec4 eye; uint material; } push;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
#ifdef TEXTURED
layout(location = 2) in vec4 uvs;
layout(location = 3) in vec4 tangent;
#else
const vec4 uvs = vec4(0.0), tangent = vec4(0.0);
#endif
layout(location = 4) in vec4 color;
layout(location = 5) flat in vec3 geometric;

layout(location = 0) out vec4 out_position;  // xyz; w: 1 where the surface reflects, 2 where it only emits
layout(location = 1) out uvec2 out_normals;  // shading and geometric, octahedral
layout(location = 2) out vec4 out_albedo;
#ifdef EMISSION
layout(location = 3) out vec4 out_emission;
#endif

void main() {
    Material material = materials[push.material];
    float length2 = dot(normal, normal);
    vec3 shading = length2 > 1e-12 ? normal * inversesqrt(length2) : geometric;
    Surface s = surface_at(material, uvs.xy, uvs.zw, color, shading, tangent);
    if (HAS_MASK != 0 && s.albedo.a < material.alpha.x) discard;

    // Towards the viewer: along −eye for parallel views (w = 0).
    vec3 to_eye = push.eye.w == 0.0 ? push.eye.xyz : push.eye.xyz - position;
    bool front = dot(geometric, to_eye) >= 0.0;
    vec3 ng = front ? geometric : -geometric;
    vec3 ns = dot(s.normal, ng) >= 0.0 ? s.normal : -s.normal;
    bool emits_alone = any(greaterThan(s.emission, vec3(0.0))) && s.albedo.rgb == vec3(0.0);
    out_position = vec4(position, emits_alone ? 2.0 : 1.0);
    out_normals = uvec2(oct_encode(ns), oct_encode(ng));
    out_albedo = vec4(s.albedo.rgb, 1.0);
#ifdef EMISSION
    out_emission = vec4(front || material.alpha.y != 0.0 ? s.emission : vec3(0.0), 1.0);
#endif
}

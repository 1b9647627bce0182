// Alpha test of a capture, with the identity of the triangles that pass it.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/material_textures.glsl"
#include "inc/surface.glsl"

layout(push_constant) uniform Push { uint view; uint material; } push;
#ifdef TEXTURED
layout(location = 0) in vec4 uvs;
#else
const vec4 uvs = vec4(0.0);
#endif
layout(location = 1) in float alpha;
layout(location = 2) flat in uint triangle;
layout(location = 0) out uint identity;

void main() {
    Material material = materials[push.material];
    Surface s = surface_at(material, uvs.xy, uvs.zw, vec4(1.0, 1.0, 1.0, alpha), vec3(0.0, 0.0, 1.0), vec4(0.0));
    if (s.albedo.a < material.alpha.x) discard;
    identity = triangle + 1;
}

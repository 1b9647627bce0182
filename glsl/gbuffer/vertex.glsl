// G-buffer: one triangle corner a vertex, pulled from the scene's buffers so that the geometric normal is exact.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/vertex_streams.glsl"
#include "inc/triangles.glsl"
#include "inc/fan.glsl"
layout(constant_id = 8) const uint AS_FANS = 0;

layout(push_constant) uniform Push { mat4 world_to_clip; vec4 eye; uint material; } push;

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
#ifdef TEXTURED
layout(location = 2) out vec4 uvs;
layout(location = 3) out vec4 tangent;
#endif
layout(location = 4) out vec4 color;
layout(location = 5) flat out vec3 geometric;

void write_attributes(vec3 unit, vec4 uv, vec4 along, vec4 tint) {
    normal = unit;
#ifdef TEXTURED
    uvs = uv;
    tangent = along;
#endif
    color = tint;
}

vec4 clip_position(vec3 p) { return push.world_to_clip * vec4(p, 1.0); }
vec3 normal_of(uint vertex) { return oct_decode(normals[vertex]); }
vec4 uvs_of(uint vertex) { return vec4(uv0_of(vertex), uv1_of(vertex)); }

void main() {
    uint corner = AS_FANS != 0 ? gl_VertexIndex % (3 * FAN) : gl_VertexIndex % 3;
    uvec3 of = corners_of(AS_FANS != 0 ? gl_VertexIndex / (3 * FAN) : gl_VertexIndex / 3);
    mat3 p = mat3(position_of(of.x), position_of(of.y), position_of(of.z));
    geometric = normalize(cross(p[1] - p[0], p[2] - p[0]));
    if (AS_FANS != 0) {
        vec4 a = clip_position(p[0]), b = clip_position(p[1]), c = clip_position(p[2]);
        vec3 weights = fan_corner(a, b, c, corner);
        position = p * weights;
        gl_Position = fan_position(a, b, c, weights);
        write_attributes(mat3(normal_of(of.x), normal_of(of.y), normal_of(of.z)) * weights,
                         mat3x4(uvs_of(of.x), uvs_of(of.y), uvs_of(of.z)) * weights,
                         mat3x4(tangent_of(of.x), tangent_of(of.y), tangent_of(of.z)) * weights,
                         mat3x4(color_of(of.x), color_of(of.y), color_of(of.z)) * weights);
    } else {
        uint vertex = of[corner];
        position = p[corner];
        gl_Position = clip_position(position);
        write_attributes(normal_of(vertex), uvs_of(vertex), tangent_of(vertex), color_of(vertex));
    }
}

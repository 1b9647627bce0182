// G-buffer: one triangle corner a vertex, pulled from the scene's buffers so that the geometric normal is exact.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/vertex_streams.glsl"

layout(push_constant) uniform Push { mat4 world_to_clip; vec4 eye; uint material; } push;

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec4 uvs;
layout(location = 3) out vec4 tangent;
layout(location = 4) out vec4 color;
layout(location = 5) flat out vec3 geometric;

vec3 position_of(uint vertex) {
    return vec3(positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]);
}

void main() {
    uint triangle = gl_VertexIndex / 3, vertex = indices[gl_VertexIndex];
    vec3 p0 = position_of(indices[3 * triangle]);
    geometric = normalize(cross(position_of(indices[3 * triangle + 1]) - p0, position_of(indices[3 * triangle + 2]) - p0));
    position = position_of(vertex);
    normal = oct_decode(normals[vertex]);
    uvs = vec4(uv0_of(vertex), uv1_of(vertex));
    tangent = tangent_of(vertex);
    color = color_of(vertex);
    gl_Position = push.world_to_clip * vec4(position, 1.0);
}

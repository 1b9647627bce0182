// capture.vert for masked materials: corners are drawn one by one, so that attributes and the triangle come with them.
// Nothing is written that the fragment shader does not read: TEXTURED says what it does. Wants FRAME_SET.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/scene.glsl"
#include "inc/triangles.glsl"
#include "inc/material_constants.glsl"
#include "inc/vertex_streams.glsl"
#define CONSTANTS 8
#include "capture/frames.glsl"
#include "capture/fans.glsl"

#ifdef TEXTURED
layout(location = 0) out vec4 uvs;
#endif
layout(location = 1) out float alpha;
layout(location = 2) flat out uint triangle;

void write_attributes(uint number, vec4 uv, float a) {
#ifdef TEXTURED
    uvs = uv;
#endif
    alpha = a;
    triangle = number;
}

vec4 uvs_of(uint vertex) { return vec4(uv0_of(vertex), uv1_of(vertex)); }

void main() {
    uint number = frame_number();
    Frame frame = frames[number];
    if (AS_FANS != 0) {
        FanCorner corner = corner_of_fan(frame);
        uvec3 of = corner.vertices;
        place(number, frame, corner.clip, corner.positions * corner.weights);
        vec3 alphas = vec3(color_of(of.x).a, color_of(of.y).a, color_of(of.z).a);
        vec4 uv = mat3x4(uvs_of(of.x), uvs_of(of.y), uvs_of(of.z)) * corner.weights;
        write_attributes(corner.triangle, uv, dot(alphas, corner.weights));
    } else {
        uint vertex = indices[gl_VertexIndex];
        vec3 position = position_of(vertex);
        place(number, frame, projected(frame, position), position);
        write_attributes(gl_VertexIndex / 3, uvs_of(vertex), color_of(vertex).a);
    }
}

// capture.vert for masked materials: corners are drawn one by one, so that attributes and the triangle come with them.
// Nothing is written that the fragment shader does not read: TEXTURED and IDENTITY say what it does.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "shared/types.glsl"
#include "inc/views.glsl"
#include "inc/scene.glsl"
#include "inc/triangles.glsl"
#include "inc/material_constants.glsl"
#include "inc/vertex_streams.glsl"
#include "inc/fan.glsl"
layout(constant_id = 8) const uint VIEWS = 0;
layout(constant_id = 9) const uint HAS_HORIZON = 1;
layout(constant_id = 10) const uint AS_FANS = 0;

layout(set = FRAME_SET, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(push_constant) uniform Push { uint frame; uint material; } push;
#ifdef TEXTURED
layout(location = 0) out vec4 uvs;
#endif
layout(location = 1) out float alpha;
#ifdef IDENTITY
layout(location = 2) flat out uint triangle;
#endif

out float gl_ClipDistance[1];

void write_attributes(uint number, vec4 uv, float a) {
#ifdef TEXTURED
    uvs = uv;
#endif
    alpha = a;
#ifdef IDENTITY
    triangle = number;
#endif
}

vec4 uvs_of(uint vertex) { return vec4(uv0_of(vertex), uv1_of(vertex)); }

void main() {
    Frame frame = frames[push.frame];
    vec3 position;
    if (AS_FANS != 0) {
        uint number = gl_VertexIndex / (3 * FAN);
        uvec3 of = corners_of(number);
        mat3 p = mat3(position_of(of.x), position_of(of.y), position_of(of.z));
        vec4 a = project(VIEWS, gl_ViewIndex, frame, p[0]), b = project(VIEWS, gl_ViewIndex, frame, p[1]),
             c = project(VIEWS, gl_ViewIndex, frame, p[2]);
        vec3 weights = fan_corner(a, b, c, gl_VertexIndex % (3 * FAN));
        position = p * weights;
        gl_Position = fan_position(a, b, c, weights);
        vec3 alphas = vec3(color_of(of.x).a, color_of(of.y).a, color_of(of.z).a);
        write_attributes(number, mat3x4(uvs_of(of.x), uvs_of(of.y), uvs_of(of.z)) * weights, dot(alphas, weights));
    } else {
        uint vertex = indices[gl_VertexIndex];
        position = position_of(vertex);
        gl_Position = project(VIEWS, gl_ViewIndex, frame, position);
        write_attributes(gl_VertexIndex / 3, uvs_of(vertex), color_of(vertex).a);
    }
    gl_ClipDistance[0] = HAS_HORIZON != 0 ? above_horizon(VIEWS, frame, position) : 1.0;
}

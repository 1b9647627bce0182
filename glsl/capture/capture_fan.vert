#version 460
#extension GL_GOOGLE_include_directive : require
// capture_flat.vert for devices that set triangles up whole: what the view sees of each is a fan of its own.
#extension GL_EXT_multiview : require
#include "shared/types.glsl"
#include "inc/views.glsl"
#include "inc/scene.glsl"
#include "inc/triangles.glsl"
#include "inc/fan.glsl"

layout(constant_id = 0) const uint VIEWS = 0;
layout(constant_id = 1) const uint HAS_HORIZON = 1;

layout(set = 1, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(push_constant) uniform Push { uint frame; } push;
layout(location = 0) flat out uint triangle;

out float gl_ClipDistance[1];

void main() {
    Frame frame = frames[push.frame];
    uint number = gl_VertexIndex / (3 * FAN);
    uvec3 corners = corners_of(number);
    mat3 p = mat3(position_of(corners.x), position_of(corners.y), position_of(corners.z));
    triangle = number;
    vec4 a = project(VIEWS, gl_ViewIndex, frame, p[0]), b = project(VIEWS, gl_ViewIndex, frame, p[1]),
         c = project(VIEWS, gl_ViewIndex, frame, p[2]);
    vec3 weights = fan_corner(a, b, c, gl_VertexIndex % (3 * FAN));
    gl_Position = fan_position(a, b, c, weights);
    gl_ClipDistance[0] = HAS_HORIZON != 0 ? above_horizon(VIEWS, frame, p * weights) : 1.0;
}

// capture.vert for masked materials: corners are drawn one by one, so that attributes and the triangle come with them.
// Nothing is written that the fragment shader does not read: TEXTURED and IDENTITY say what it does.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "shared/types.glsl"
#include "inc/views.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/vertex_streams.glsl"
layout(constant_id = 8) const uint VIEWS = 0;
layout(constant_id = 9) const uint HAS_HORIZON = 1;

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

void main() {
    uint vertex = indices[gl_VertexIndex];
    vec3 position = vec3(positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]);
    Frame frame = frames[push.frame];
    gl_Position = project(VIEWS, gl_ViewIndex, frame, position);
    gl_ClipDistance[0] = HAS_HORIZON != 0 ? above_horizon(VIEWS, frame, position) : 1.0;
#ifdef TEXTURED
    uvs = vec4(uv0_of(vertex), uv1_of(vertex));
#endif
    alpha = color_of(vertex).a;
#ifdef IDENTITY
    triangle = gl_VertexIndex / 3;
#endif
}

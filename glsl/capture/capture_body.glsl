// A view of the scene from a frame: hemicube, cube, plane or parallel, one face a view of the multi-view pass.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "shared/types.glsl"
#include "inc/views.glsl"

layout(constant_id = 0) const uint VIEWS = 0;
layout(constant_id = 1) const uint HAS_HORIZON = 1;

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(push_constant) uniform Push { uint frame; } push;
layout(location = 0) in vec3 position;
#ifdef TRIANGLE
layout(location = 0) flat out uint triangle;
#endif

out float gl_ClipDistance[1];

void main() {
    Frame frame = frames[push.frame];
    gl_Position = project(VIEWS, gl_ViewIndex, frame, position);
    gl_ClipDistance[0] = HAS_HORIZON != 0 ? above_horizon(VIEWS, frame, position) : 1.0;
#ifdef TRIANGLE
    triangle = TRIANGLE;
#endif
}

// The frames of a capture: their tiles lie side by side in the target. With INSTANCES one draw goes to all of them, an instance
// each, and clip planes cut it to its tile; else a viewport is set for each. Wants FRAME_SET, and CONSTANTS, the first constant
// that is free.
#extension GL_EXT_multiview : require
#include "inc/views.glsl"

layout(constant_id = CONSTANTS) const uint VIEWS = 0;
layout(constant_id = CONSTANTS + 1) const uint HAS_HORIZON = 1;
layout(constant_id = CONSTANTS + 2) const uint AS_FANS = 0;  // triangles are cut to the view before they are placed
layout(constant_id = CONSTANTS + 3) const uint CLUSTER = 0;  // triangles of a cluster, where these are culled (cull/list.comp)

layout(set = FRAME_SET, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(push_constant) uniform Push {
    uint view;            // on top of gl_ViewIndex
    uint material;
    uint first_triangle;  // of the draw range
    uint columns;         // tiles in a row
    vec2 scale;           // of a tile, relative to the target
} push;

#ifdef INSTANCES
out float gl_ClipDistance[5];
#else
out float gl_ClipDistance[1];
#endif

uint frame_number() { return CLUSTER != 0 ? gl_InstanceIndex >> 16 : gl_InstanceIndex; }

// First triangle of the draw.
uint first_triangle() { return push.first_triangle + CLUSTER * (gl_InstanceIndex & 0xffff); }

vec4 projected(Frame frame, vec3 position) { return project(VIEWS, push.view + gl_ViewIndex, frame, position); }

// Puts a vertex into its frame's tile.
void place(uint number, Frame frame, vec4 clip, vec3 position) {
    gl_Position = clip;
    gl_ClipDistance[0] = HAS_HORIZON != 0 ? above_horizon(VIEWS, frame, position) : 1.0;
#ifdef INSTANCES
    vec2 tile = vec2(number % push.columns, number / push.columns);
    gl_Position.xy = clip.xy * push.scale + clip.w * ((2.0 * tile + 1.0) * push.scale - 1.0);
    vec4 sides = AS_FANS != 0 ? vec4(1.0) : vec4(clip.w - clip.xy, clip.w + clip.xy);
    for (int i = 0; i < 4; ++i) gl_ClipDistance[i + 1] = sides[i];
#endif
}

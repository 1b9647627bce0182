// Looks up what the texels of captures by render passes see, for glsl/project. One workgroup a record.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
const uint THREADS = 64;
layout(local_size_x = THREADS) in;

layout(constant_id = 0) const uint HAS_SKY = 0;
layout(constant_id = 1) const uint HAS_TRANSLATION = 1;  // planes are wanted
layout(constant_id = 2) const uint IS_CURVED = 0;  // triangles' sides are curves, drawn as chords

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) readonly buffer Texels { vec4 texels[]; };  // two values a texel (src/vk/gpu_types.rs)
layout(set = 0, binding = 2, std430) writeonly buffer Gathered { vec4 gathered[]; };  // laid out as inc/gathered.glsl says
layout(push_constant) uniform Push {
    uint texel_count;
    uint tile_size;
    uint columns;
} push;
vec4 texel_value(uint at) { return texels[at]; }

#include "inc/gathered.glsl"
#include "integrate/see.glsl"

void main() {
    uint record = gl_WorkGroupID.x;
    Frame frame = frames[record];
    for (uint i = gl_LocalInvocationID.x; i < push.texel_count; i += THREADS) {
        vec4 seen;
        vec3 beyond;
        see(record, frame, i, seen, beyond);
    }
}

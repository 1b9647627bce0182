// Distances that captures see, cell by cell of an octahedral map of the directions (math::octahedron): the moments of the distance,
// weighted by solid angle over its square, so that what is near counts where a cell also sees past its edge;
// the solid angle of triangles' backs, and the nearest. One workgroup a record, one invocation a cell; every sum has a fixed order.
#extension GL_GOOGLE_include_directive : require
const uint CELLS = 64;
layout(local_size_x = CELLS) in;

layout(constant_id = 0) const uint HAS_SKY = 0;
const uint HAS_TRANSLATION = 1;  // planes are kept, with the sides that are seen

#ifdef FROM_COMPUTE
layout(set = 0, binding = 0) uniform textureBuffer gathered;  // laid out as inc/gathered.glsl says
vec4 gathered_value(uint at) { return texelFetch(gathered, int(at)); }
#else
layout(set = 0, binding = 0, std430) readonly buffer Gathered { vec4 gathered[]; };
vec4 gathered_value(uint at) { return gathered[at]; }
#endif
layout(set = 0, binding = 1, std430) readonly buffer Starts { uint starts[]; };  // of each cell its first member, and the end
layout(set = 0, binding = 2, std430) readonly buffer Members { vec2 members[]; };  // texel (bits), solid angle
layout(set = 0, binding = 3, std430) writeonly buffer Results { vec4 results[]; };  // mean, mean square, backs, 1/nearest
layout(push_constant) uniform Push {
    uint texel_count;
    float farthest;  // distances are no longer than that; the sky's is that
} push;

#include "inc/gathered.glsl"

void main() {
    uint cell = gl_LocalInvocationID.x, base = gl_WorkGroupID.x * push.texel_count;
    vec2 moments = vec2(0.0);
    float whole = 0.0, backs = 0.0, nearness = 0.0;
    for (uint i = starts[cell]; i < starts[cell + 1]; ++i) {
        vec2 member = members[i];
        uint at = STRIDE * (base + floatBitsToUint(member.x));
        float inverse_distance = gathered_value(at).w;
        float r = 1.0 / max(inverse_distance, 1.0 / push.farthest);
        moments += member.y * vec2(1.0 / r, 1.0);
        whole += member.y / (r * r);
        if (is_back(gathered_value(at + STRIDE - 1).w)) backs += member.y;
        nearness = max(nearness, inverse_distance);
    }
    results[gl_WorkGroupID.x * CELLS + cell] = vec4(moments / whole, backs, nearness);
}

// Reads an irradiance volume at points.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;

layout(constant_id = 0) const uint ORDER = 3;
layout(constant_id = 1) const uint HAS_GRADIENTS = 1;
layout(constant_id = 2) const uint HAS_MOMENTS = 1;
layout(constant_id = 3) const uint WAY = 0;
layout(constant_id = 4) const uint GUARDED = 1;

layout(set = 0, binding = 0, std430) readonly buffer Nodes { uint volume_nodes[]; };
layout(set = 0, binding = 1, std430) readonly buffer Points { uvec2 volume_points[]; };
layout(set = 0, binding = 2, std430) readonly buffer Shares { uvec2 volume_shares[]; };
layout(set = 0, binding = 3, std430) readonly buffer Samples { float volume_samples[]; };
layout(set = 0, binding = 4, std430) readonly buffer Places { vec4 places[]; };
layout(set = 0, binding = 5, std430) writeonly buffer Results { float results[]; };  // rgb of each coefficient of each place
layout(push_constant) uniform Push {
    float low[3];
    float high[3];
    uint divisions[3];
    uint count;
} push;

#include "inc/volume.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    Volume volume = Volume(vec3(push.low[0], push.low[1], push.low[2]), vec3(push.high[0], push.high[1], push.high[2]),
                           uvec3(push.divisions[0], push.divisions[1], push.divisions[2]));
    vec3 coefficients[VOLUME_COUNT];
    read_volume(volume, places[i].xyz, WAY, GUARDED != 0, coefficients);
    for (uint c = 0; c < VOLUME_COUNT; ++c) {
        uint at = 3 * (i * VOLUME_COUNT + c);
        results[at] = coefficients[c].r;
        results[at + 1] = coefficients[c].g;
        results[at + 2] = coefficients[c].b;
    }
}

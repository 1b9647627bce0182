// Which clusters of triangles does each view of each frame see? One invocation tests 32 clusters and writes a bit for each.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
layout(local_size_x = 64) in;

layout(constant_id = 0) const uint VIEWS = 0;

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) readonly buffer Clusters { vec4 clusters[]; };  // centre, radius
layout(set = 0, binding = 2, std430) writeonly buffer Seen { uint seen[]; };
#include "cull/push.glsl"

bool sees(uint view, Frame frame, vec4 sphere) {
    vec3 d = sphere.xyz - frame.origin.xyz;
    float r = sphere.w;
    if (dot(frame.horizon.xyz, sphere.xyz) + frame.horizon.w < -r) return false;
    vec3 l = to_local(frame, d);
    if (VIEWS == VIEWS_ORTHOGRAPHIC)
        return abs(l.x) - r <= 1.0 / frame.tangent.w && abs(l.y) - r <= 1.0 / frame.bitangent.w;
    if (VIEWS == VIEWS_HEMISPHERE) return l.z >= -r;
    vec3 f = face_coordinates(view, l);
    if (VIEWS == VIEWS_HEMICUBE && view > 0 && f.y < -r) return false;
    vec2 k = 1.0 / vec2(frame.tangent.w, frame.bitangent.w);
    return all(greaterThanEqual(f.zz * k - abs(f.xy), -r * sqrt(1.0 + k * k)));
}

void main() {
    uint job = gl_GlobalInvocationID.x, view = gl_WorkGroupID.y;
    if (job >= push.frame_count * push.words) return;
    uint number = job / push.words, word = job % push.words;
    Frame frame = frames[number];
    uint first = 32 * word, count = min(32, push.clusters - first), bits = 0;
    for (uint c = 0; c < count; ++c)
        if (sees(view, frame, clusters[push.first_cluster + first + c])) bits |= 1u << c;
    seen[first_word_of(view, number) + word] = bits;
}

// Which clusters of triangles does each view of each frame see? One invocation a (frame, view, range) walks the range's
// clusters in order and writes one indirect draw a run of neighbours: the order, and with it every tie of depth, is
// always the same.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
layout(local_size_x = 32) in;

layout(constant_id = 0) const uint VIEWS = 0;
layout(constant_id = 1) const uint VIEW_COUNT = 5;
layout(constant_id = 2) const uint CLEAR_REST = 0;
layout(constant_id = 3) const uint FAN = 1;  // triangles that one is drawn as
layout(constant_id = 4) const uint COUNTS = 0;  // triangles that are drawn

struct Draw { uint index_count; uint instance_count; uint first_index; int vertex_offset; uint first_instance; };

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) readonly buffer Clusters { vec4 clusters[]; };  // centre, radius
layout(set = 0, binding = 2, std430) readonly buffer Ranges { uvec4 ranges[]; };     // first cluster, count, first triangle, end triangle
layout(set = 0, binding = 3, std430) writeonly buffer Draws { Draw draws[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 5, std430) buffer Count { uint count[2]; };
layout(push_constant) uniform Push { uint frame_count; uint range_count; uint cluster_count; uint cluster_size; } push;

#include "inc/count.glsl"

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
    uint job = gl_GlobalInvocationID.x;
    if (job >= push.frame_count * VIEW_COUNT * push.range_count) return;
    uint range_index = job % push.range_count;
    uint frame_view = job / push.range_count;
    uint view = frame_view % VIEW_COUNT;
    Frame frame = frames[frame_view / VIEW_COUNT];
    uvec4 range = ranges[range_index];

    uint first_draw = frame_view * push.cluster_count + range.x;
    uint written = 0, run = 0, drawn = 0;
    for (uint c = 0; c <= range.y; ++c) {
        bool seen = c < range.y && sees(view, frame, clusters[range.x + c]);
        if (seen) {
            ++run;
        } else if (run > 0) {
            uint begin = range.z + (c - run) * push.cluster_size;
            uint end = min(range.z + c * push.cluster_size, range.w);
            draws[first_draw + written] = Draw(3 * FAN * (end - begin), 1, 3 * FAN * begin, 0, begin);
            drawn += end - begin;
            ++written;
            run = 0;
        }
    }
    counts[job] = written;
    if (COUNTS != 0) add_to_count(drawn);
    if (CLEAR_REST != 0)
        for (uint c = written; c < range.y; ++c) draws[first_draw + c] = Draw(0, 0, 0, 0, 0);
}

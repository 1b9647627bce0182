// Which clusters each face of each hemicube may see: a bit a cluster. One invocation a word: 32 neighbours, none of which
// is looked at where the box around all of them is out of sight. Boxes outside the face, below the horizon, or between
// texel centres are out of sight.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
layout(local_size_x = 32) in;

layout(constant_id = 0) const uint SIZE = 32;
layout(constant_id = 1) const uint HAS_LEVELS = 0;
layout(constant_id = 2) const uint IS_DISC = 0;  // one view of the hemisphere in the first face's place

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1) uniform textureBuffer groups;    // of 32 clusters: boxes of ClusterTree
layout(set = 0, binding = 2) uniform textureBuffer clusters;  // likewise of each cluster
layout(set = 0, binding = 3, std430) writeonly buffer Visible { uint visible[]; };  // by frame, face and 32 clusters
layout(push_constant) uniform Push { uint cluster_count; uint word_count; float allowed_error; } push;

const int STRIDE = 6;  // texels of a cluster or group

// A box around what is looked at, in the frame's coordinates.
struct Box { vec3 centre, extent; bool above; };

Box local_box(Frame frame, vec3 low, vec3 high) {
    vec3 half_ = 0.5 * (high - low), centre = low + half_, c = to_local(frame, centre - frame.origin.xyz);
    vec3 e = vec3(dot(abs(frame.tangent.xyz), half_), dot(abs(frame.bitangent.xyz), half_),
                  dot(abs(frame.normal.xyz), half_));
    bool above = dot(frame.horizon.xyz, centre) + frame.horizon.w >= -dot(abs(frame.horizon.xyz), half_);
    return Box(c, e + 1e-5 * (abs(c) + e), above);  // a grain more, for the rounding of what is drawn
}

// Whether the face sees the centre of a texel within the box, as seen from the frame's origin.
bool sees(uint face, Box box) {
    vec3 centre = face_coordinates(face, box.centre), extent = abs(face_coordinates(face, box.extent));
    vec3 low = centre - extent, high = centre + extent;
    bool ahead = high.z > 0.0 && low.x <= high.z && -high.x <= high.z && low.y <= high.z
        && -high.y <= (face == 0 ? high.z : 0.0);
    // Bounds of the box's image, where it lies ahead as a whole: on a face of width 2, in texels.
    vec2 least = low.xy / mix(vec2(high.z), vec2(low.z), lessThan(low.xy, vec2(0.0)));
    vec2 most = high.xy / mix(vec2(high.z), vec2(low.z), greaterThan(high.xy, vec2(0.0)));
    vec2 from = ceil((least + 1.0) * (0.5 * float(SIZE)) - 0.501), to = floor((most + 1.0) * (0.5 * float(SIZE)) - 0.499);
    return box.above && ahead && (low.z <= 0.0 || all(lessThanEqual(from, to)));
}

// Likewise of the disc below the hemisphere: within a cap around the box's sphere.
bool sees_on_disc(Box box) {
    float distance_ = length(box.centre), sine = length(box.extent) / distance_;
    if (!(sine < 1.0)) return box.above;
    vec2 centre = box.centre.xy / distance_;
    float cosine = sqrt(1.0 - sine * sine);
    vec2 reach = sqrt(max(1.0 - centre * centre, 0.0)) * sine, least = cosine * centre - reach, most = cosine * centre + reach;
    least = mix(least, vec2(-1.0), lessThan(centre, vec2(-cosine)));
    most = mix(most, vec2(1.0), greaterThan(centre, vec2(cosine)));
    vec2 from = ceil((least + 1.0) * (0.5 * float(SIZE)) - 0.501), to = floor((most + 1.0) * (0.5 * float(SIZE)) - 0.499);
    return box.above && box.centre.z + box.extent.z > 0.0 && all(lessThanEqual(from, to));
}

bool sees_any(Box box) {
    if (IS_DISC != 0) return sees_on_disc(box);
    return sees(0, box) || sees(1, box) || sees(2, box) || sees(3, box) || sees(4, box);
}

float distance_to(vec3 p, vec3 low, vec3 high) { return length(max(max(low - p, p - high), vec3(0.0))); }

// Whether clusters with these bounds may be shown at this distance: fine enough themselves, and what replaces them is not.
bool is_shown_cluster(int at, vec3 eye) {
    vec4 own = texelFetch(clusters, at + 3), coarser = texelFetch(clusters, at + 5);
    precise float near = distance_to(eye, texelFetch(clusters, at + 2).xyz, own.xyz) * push.allowed_error;
    precise float far = distance_to(eye, texelFetch(clusters, at + 4).xyz, coarser.xyz) * push.allowed_error;
    return own.w <= near && coarser.w > far;
}

bool is_shown_group(int at, vec3 eye) {
    vec4 low = texelFetch(groups, at + 4), high = texelFetch(groups, at + 5);
    float least = texelFetch(groups, at + 3).w, most = high.w;
    float near = distance_to(eye, low.xyz, high.xyz), far = near + length(high.xyz - low.xyz);
    return least <= far * push.allowed_error && most > near * push.allowed_error;
}

void main() {
    uint word = gl_GlobalInvocationID.x, record = gl_WorkGroupID.y;
    if (word >= push.word_count) return;
    Frame frame = frames[record];
    int at = STRIDE * int(word);
    Box around = local_box(frame, texelFetch(groups, at).xyz, texelFetch(groups, at + 1).xyz);
    uint first = 32 * word, count = sees_any(around) && (HAS_LEVELS == 0 || is_shown_group(at, frame.origin.xyz)) ? min(push.cluster_count - first, 32) : 0;
    uint bits[5] = uint[5](0, 0, 0, 0, 0);
    for (uint i = 0; i < count; ++i) {
        at = STRIDE * int(first + i);
        if (HAS_LEVELS != 0 && !is_shown_cluster(at, frame.origin.xyz)) continue;
        Box box = local_box(frame, texelFetch(clusters, at).xyz, texelFetch(clusters, at + 1).xyz);
        if (IS_DISC != 0) {
            bits[0] |= sees_on_disc(box) ? 1 << i : 0;
            continue;
        }
        bits[0] |= sees(0, box) ? 1 << i : 0;
        bits[1] |= sees(1, box) ? 1 << i : 0;
        bits[2] |= sees(2, box) ? 1 << i : 0;
        bits[3] |= sees(3, box) ? 1 << i : 0;
        bits[4] |= sees(4, box) ? 1 << i : 0;
    }
    uint to = 5 * record * push.word_count + word;
    for (uint face = 0; face < 5; ++face) visible[to + face * push.word_count] = bits[face];
}

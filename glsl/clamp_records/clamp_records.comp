// Radius of the zone of each kept record in a view. Neighbour clamping (Křivánek, Bouatouch, Pattanaik and Žára 2006): a new
// record reaches no further beyond an older one, or one of its own batch, than that reaches itself, r ≤ a·R_i + ‖P − P_i‖, for what
// shortens one zone is near the other. By radii as they are without limits, so that the reach belongs to the record and is kept with
// it. The view's limits in pixels come last, and the smallest radius wins.
//
// Groups of the index that cannot shorten a zone are passed over. A dispatch looks at so many groups that no device ends its loops
// (llvmpipe does at 65,535 rounds); the next one goes on.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/index.glsl"
#include "inc/invocation.glsl"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint CLAMPED = 1;  // by neighbours

layout(set = 0, binding = 0, std430) buffer Entries { Entry entries[]; };
layout(set = 0, binding = 1, std430) readonly buffer Sorted { Entry sorted_[]; };
layout(set = 0, binding = 2, std430) readonly buffer Groups { Group groups[]; };
layout(set = 0, binding = 3, std430) buffer Zones { float zones[]; };
layout(push_constant) uniform Push {
    vec4 eye;      // xyz; w: 0 for parallel views
    vec4 forward;  // xyz; w: footprint of a pixel at distance 1 (or anywhere, for parallel views)
    uint first;    // of the records
    uint count;
    uint records;  // in the index
    uint group;    // first and last but one of the groups to look at
    uint end;
    uint is_last;  // of the dispatches
    uint is_new;   // neighbours clamp the records; else their kept reach counts
    float accuracy;
    float min_radius;  // in pixels
    float max_radius;
} push;

const float SAME_SURFACE = 0.5;  // least n·n_i of records that concern each other
const float SPARE = 0.9999;      // of a bound, for rounding

float clamped(Entry me, float radius) {
    vec3 p = me.place.xyz, n = oct_decode(me.about.x);
    for (uint g = push.group; g < push.end; ++g) {
        Group box = groups[g];
        vec3 away = max(max(box.low.xyz - p, p - box.high.xyz), vec3(0.0));
        if (!(SPARE * (push.accuracy * box.low.w + length(away)) < radius)) continue;
        uint end = min(GROUP * (g + 1), push.records);
        for (uint i = GROUP * g; i < end; ++i) {
            Entry other = sorted_[i];
            float reach = push.accuracy * other.place.w;
            if (reach < 0.0 || reach >= radius || dot(n, oct_decode(other.about.x)) < SAME_SURFACE) continue;
            radius = min(radius, reach + distance(p, other.place.xyz));
        }
    }
    return radius;
}

void main() {
    uint at = invocation();
    if (at >= push.count) return;
    uint number = push.first + at;
    Entry me = entries[number];
    float reach = push.group > 0 ? zones[number] : push.is_new == 0 ? uintBitsToFloat(me.about.z) : push.accuracy * me.place.w;
    if (CLAMPED != 0 && push.is_new != 0) reach = clamped(me, reach);
    if (push.is_last == 0) {
        zones[number] = reach;
        return;
    }
    if (push.is_new != 0) entries[number].about.z = floatBitsToUint(reach);
    float footprint = push.forward.w * (push.eye.w == 0.0 ? 1.0 : max(dot(me.place.xyz - push.eye.xyz, push.forward.xyz), 0.0));
    float radius = max(min(reach, push.max_radius * footprint), push.min_radius * footprint);
    zones[number] = me.place.w >= 0.0 ? radius : 0.0;
}

// Sorts the entries of kept records by cells of space, along a curve that keeps neighbours together (Morton 1966), and bounds
// every group of 64. Dispatches share this shader: bounds of all, count by cell, first of each cell, sorted entries, groups.
// Within a cell entries have any order: what is asked of the index must not depend on it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/index.glsl"
#include "inc/invocation.glsl"
const uint THREADS = 128, CELLS = 1u << 15, AXIS_BITS = 5;
layout(local_size_x = THREADS) in;
layout(constant_id = 0) const uint PHASE = 0;  // 0 bounds, 1 count, 2 sum, 3 sort, 4 group

layout(set = 0, binding = 0, std430) readonly buffer Entries { Entry entries[]; };
layout(set = 0, binding = 1, std430) buffer Sorted { Entry sorted_[]; };
layout(set = 0, binding = 2, std430) buffer Groups { Group groups[]; };
layout(set = 0, binding = 3, std430) buffer Cells { vec4 low; vec4 high; uint firsts[CELLS]; };
layout(push_constant) uniform Push { uint count; } push;

shared vec4 lows[THREADS], highs[THREADS];
shared uint sums[THREADS];

void bound_all() {
    uint me = gl_LocalInvocationID.x;
    vec3 least = entries[0].place.xyz, most = least;
    for (uint i = me; i < push.count; i += THREADS) {
        vec3 p = entries[i].place.xyz;
        least = min(least, p);
        most = max(most, p);
    }
    lows[me].xyz = least;
    highs[me].xyz = most;
    barrier();
    if (me > 0) return;
    for (uint i = 0; i < THREADS; ++i) {
        least = min(least, lows[i].xyz);
        most = max(most, highs[i].xyz);
    }
    low = vec4(least, 0.0);
    high = vec4(most, 0.0);
}

uint spread(uint bits) {
    uint all_ = 0;
    for (uint i = 0; i < AXIS_BITS; ++i) all_ |= (bits >> i & 1u) << (3 * i);
    return all_;
}

uint cell_of(vec3 p) {
    vec3 share = (p - low.xyz) / max(high.xyz - low.xyz, vec3(1e-30));
    uvec3 at = uvec3(clamp(share * float(1u << AXIS_BITS), vec3(0.0), vec3(float((1u << AXIS_BITS) - 1u))));
    return spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2;
}

// Counts become the first place of each cell. Each invocation sums a row of cells.
void sum_cells() {
    const uint ROW = CELLS / THREADS;
    uint me = gl_LocalInvocationID.x, sum = 0;
    for (uint i = 0; i < ROW; ++i) sum += firsts[me * ROW + i];
    sums[me] = sum;
    barrier();
    uint first = 0;
    for (uint i = 0; i < me; ++i) first += sums[i];
    for (uint i = 0; i < ROW; ++i) {
        uint count = firsts[me * ROW + i];
        firsts[me * ROW + i] = first;
        first += count;
    }
}

void bound_group(uint group) {
    uint first = group * GROUP, end = min(first + GROUP, push.count);
    if (first >= push.count) return;
    Group all_ = Group(vec4(sorted_[first].place.xyz, LARGEST), sorted_[first].place);
    for (uint i = first; i < end; ++i) {
        vec4 place = sorted_[i].place;
        all_.low.xyz = min(all_.low.xyz, place.xyz);
        all_.high.xyz = max(all_.high.xyz, place.xyz);
        if (place.w >= 0.0) all_.low.w = min(all_.low.w, place.w);
    }
    groups[group] = all_;
}

void main() {
    uint at = invocation();
    if (PHASE == 0) bound_all();
    if (PHASE == 1 && at < push.count) atomicAdd(firsts[cell_of(entries[at].place.xyz)], 1);
    if (PHASE == 2) sum_cells();
    if (PHASE == 3 && at < push.count) sorted_[atomicAdd(firsts[cell_of(entries[at].place.xyz)], 1)] = entries[at];
    if (PHASE == 4) bound_group(at);
}

// What voxels' faces across one axis show, to below and to above: mean over their samples of the radiance that leaves what is
// there; the share of them where something is, in sixteenths, plus the mean place of that between the slice's faces, 0 to 1.
// Outside the scene's bounds, half a voxel in, there are no samples.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Samples { uint samples[]; };
layout(set = 0, binding = 1, std430) readonly buffer CellRadiance { float cell_radiance[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Slices { vec4 slices[]; };

#include "slices/grid.glsl"
#include "inc/invocation.glsl"
#include "inc/cell_light.glsl"

struct Side { vec3 light; float count, place; };

void add(inout Side side, uint key, float place) {
    if (key == 0) return;
    side.light += cell_light(~key / 2, (~key & 1) == 0);
    side.count += 1.0;
    side.place += place;
}

vec4 shown(Side side, float samples) {
    // Less than a whole, also where rounding makes it one.
    float place = clamp(side.place / max(side.count, 1.0), 0.0, 0.999);
    return vec4(side.light / samples, round(16.0 * side.count / samples) + place);
}

float samples_within(uint at, uint dims) {
    return float(dims > 1 && (at == 0 || at == dims - 1) ? SAMPLES / 2 : SAMPLES);
}

void main() {
    uint index = invocation();
    uvec3 all = dims(), across = turned(all);
    if (index >= all.x * all.y * all.z) return;
    uvec3 at = uvec3(index % across.x, index / across.x % across.y, index / (across.x * across.y));
    Side below = Side(vec3(0.0), 0.0, 0.0), above = below;
    for (uint i = 0; i < SAMPLES * SAMPLES; ++i) {
        uint place = 4 * sample_at(uvec3(at.xy * SAMPLES + uvec2(i % SAMPLES, i / SAMPLES), at.z));
        add(below, samples[place + 2], uintBitsToFloat(~samples[place]) - float(at.z));
        add(above, samples[place + 3], uintBitsToFloat(samples[place + 1]) - float(at.z));
    }
    float within = samples_within(at.x, across.x) * samples_within(at.y, across.y);
    uvec3 voxel = turned_back(at);
    uint voxels = all.x * all.y * all.z, to = (voxel.z * all.y + voxel.y) * all.x + voxel.x;
    slices[2 * push.axis * voxels + to] = shown(below, within);
    slices[(2 * push.axis + 1) * voxels + to] = shown(above, within);
}

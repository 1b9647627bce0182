// Adds the records of a batch to the store: their place, payload and horizon, and their entry for the index. One workgroup a
// record.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/horizon.glsl"
const uint THREADS = 128;  // at least a column each: at most 32 are kept of each of four sides
layout(local_size_x = THREADS) in;
layout(constant_id = 0) const uint PAYLOADS = 1;  // of a record
layout(constant_id = 1) const uint SIZE = 0;      // texels a side of the hemicubes; 0: no horizon is kept
layout(constant_id = 2) const uint COLUMNS = 1;   // of a side face that are kept
layout(constant_id = 3) const uint STRIDE = 1;    // floats of a texel: 1/distance, or as inc/gathered.glsl has it

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) readonly buffer Records { Record records[]; };
layout(set = 0, binding = 2, std430) readonly buffer Payloads { Payload payloads[]; };
layout(set = 0, binding = 3, std430) readonly buffer Distances { float distances[]; };
layout(set = 0, binding = 4, std430) writeonly buffer KeptRecords { Kept kept[]; };
layout(set = 0, binding = 5, std430) writeonly buffer KeptPayloads { KeptPayload kept_payloads[]; };
layout(set = 0, binding = 6, std430) writeonly buffer Horizons { uint horizons[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Entries { Entry entries[]; };
layout(push_constant) uniform Push {
    uint from;   // first record of the batch
    uint to;     // its place in this piece of the store
    uint entry;  // its number in the whole store
} push;

shared float largest_of[THREADS];

// 1/(forward distance) of what a side face sees at the texel.
float inverse_forward(uint record, uint side, ivec2 texel) {
    uint n = SIZE, at = 3 * n * n * record + n * n + side * (n * n / 2) + uint(texel.y) * n + uint(texel.x);
    vec2 p = (vec2(texel) + 0.5) * (2.0 / float(n)) * vec2(1.0, -1.0) + vec2(-1.0, 1.0);
    return distances[STRIDE * at + min(STRIDE, 4) - 1] * sqrt(1.0 + dot(p, p));
}

// The same at the middle of a kept column, in a kept row: linear along the row, as it is along a plane.
float horizon_at(uint record, uint column, uint row) {
    float x = (float(column % COLUMNS) + 0.5) * float(SIZE) / float(COLUMNS) - 0.5;
    int low = min(int(x), int(SIZE) - 1), y = int(SIZE) / 2 - 1 - horizon_row(row, int(SIZE));
    float a = inverse_forward(record, column / COLUMNS, ivec2(low, y));
    return x == float(low) ? a : mix(a, inverse_forward(record, column / COLUMNS, ivec2(low + 1, y)), x - float(low));
}

float keep_horizon(uint from, uint to) {
    float seen[HORIZON_ROWS], largest = 0.0;
    uint me = gl_LocalInvocationID.x, columns = 4 * COLUMNS;
    for (uint row = 0; row < HORIZON_ROWS; ++row) {
        seen[row] = me < columns ? horizon_at(from, me, row) : 0.0;
        largest = max(largest, seen[row]);
    }
    largest_of[me] = largest;
    barrier();
    for (uint i = 0; i < THREADS; ++i) largest = max(largest, largest_of[i]);
    for (uint word = 0; word < HORIZON_WORDS && me < columns; ++word) {
        uint bytes = 0;
        for (uint i = 0; i < 4; ++i) bytes |= horizon_byte(seen[4 * word + i], largest) << (8 * i);
        horizons[HORIZON_WORDS * (columns * to + me) + word] = bytes;
    }
    return largest;
}

// Whether all of it is finite.
bool is_number(vec4 v) { return all(lessThan(abs(v), vec4(3e38))); }

bool is_number(Payload p) {
    bool valid = is_number(p.irradiance);
    for (uint c = 0; c < 3; ++c) valid = valid && is_number(p.rotation[c]) && is_number(p.translation[c]);
    return valid;
}

KeptPayload keep(Frame frame, Payload p) {
    vec3 t = frame.tangent.xyz, b = frame.bitangent.xyz;
    KeptPayload k;
    k.irradiance = vec4(p.irradiance.rgb, p.rotation[0].w);
    for (uint c = 0; c < 3; ++c) {
        vec3 turn = p.rotation[c].xyz, slope = p.translation[c].xyz;
        k.change[c] = vec4(dot(turn, t), dot(turn, b), dot(slope, t), dot(slope, b));
    }
    k.most = vec4(p.rotation[1].w, p.rotation[2].w, 0.0, 0.0);
    return k;
}

void main() {
    uint from = push.from + gl_WorkGroupID.x, to = push.to + gl_WorkGroupID.x, number = push.entry + gl_WorkGroupID.x;
    uint me = gl_LocalInvocationID.x;
    if (me < PAYLOADS) kept_payloads[PAYLOADS * to + me] = keep(frames[from], payloads[PAYLOADS * from + me]);
    float largest = SIZE != 0 ? keep_horizon(from, to) : 0.0;
    if (me > 0) return;
    Record record = records[from];
    bool valid = is_number(record.position) && record.position.w >= 0.0 && is_number(record.normal);
    for (uint i = 0; i < PAYLOADS; ++i) valid = valid && is_number(payloads[PAYLOADS * from + i]);
    float r = valid ? record.position.w : -1.0;
    kept[to].position = vec4(record.position.xyz, r);
    kept[to].normal = vec4(record.normal.xyz, largest);
    kept[to].tangent = vec4(frames[from].tangent.xyz, 0.0);
    entries[number].place = vec4(record.position.xyz, r);
    entries[number].about = uvec4(oct_encode(record.normal.xyz), number, 0, 0);
}

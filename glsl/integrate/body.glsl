// Irradiance, its gradients and the harmonic mean distance of each record of a batch, from what its texels see. One
// workgroup a record; every sum has a fixed order. Texels and edges come as tables (src/math/capture.rs), so that the same
// pass serves any projection. CPU twin: math::capture::Table::integrate.
//
// FROM_COMPUTE: the capture wrote what texels see, or it has summed faces by itself and wrote what texels at their borders
// see: then texels are those alone, and edges those between faces. What is only read is fetched through buffer views then,
// several times faster on CPU devices; captures by render passes ask no such views of a device.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
const uint THREADS = 64;
layout(local_size_x = THREADS) in;

layout(constant_id = 0) const uint HAS_SKY = 0;
layout(constant_id = 1) const uint HAS_ROTATION = 1;
layout(constant_id = 2) const uint HAS_TRANSLATION = 1;
layout(constant_id = 3) const uint IS_CURVED = 0;  // triangles' sides are curves, drawn as chords
layout(constant_id = 4) const uint BY_HESSIAN = 0;  // R from the second derivatives of E; wants the translation gradient
layout(constant_id = 5) const uint PARTS = 0;  // of each sum that the capture made; 0: it made none
layout(constant_id = 6) const uint HAS_OUTLINES = 0;  // followed over the triangles' edges

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) buffer Records { Record records[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Payloads { Payload payloads[]; };
// Of each texel two values, of each edge three (src/vk/gpu_types.rs).
#ifdef FROM_COMPUTE
layout(set = 0, binding = 3) uniform textureBuffer texels;
layout(set = 0, binding = 4) uniform textureBuffer edges;
layout(set = 0, binding = 5) uniform textureBuffer gathered;  // laid out as inc/gathered.glsl says
layout(set = 0, binding = 6, std430) readonly buffer Sums { float face_sums[]; };
vec4 texel_value(uint at) { return texelFetch(texels, int(at)); }
vec4 edge_value(uint at) { return texelFetch(edges, int(at)); }
vec4 gathered_value(uint at) { return texelFetch(gathered, int(at)); }
#else
layout(set = 0, binding = 3, std430) readonly buffer Texels { vec4 texels[]; };
layout(set = 0, binding = 4, std430) readonly buffer Edges { vec4 edges[]; };
layout(set = 0, binding = 5, std430) coherent buffer Gathered { vec4 gathered[]; };  // shared by a workgroup
vec4 texel_value(uint at) { return texels[at]; }
vec4 edge_value(uint at) { return edges[at]; }
vec4 gathered_value(uint at) { return gathered[at]; }
#endif
layout(push_constant) uniform Push {
    uint texel_count;
    uint edge_count;
    uint tile_size;
    uint columns;
    float inverse_weight;  // 1/Σ of the cosine weights
    float scene_radius;  // R of a record that sees nothing
} push;

#include "inc/gathered.glsl"
#include "inc/sums.glsl"
#ifdef FROM_COMPUTE
// What texel i of a record sees: of surfaces, with 1/distance, and of the sky.
void see(uint record, Frame frame, uint i, out vec4 seen, out vec3 beyond) {
    uint at = STRIDE * (record * push.texel_count + i);
    seen = gathered_value(at);
    beyond = HAS_SKY != 0 ? gathered_value(at + 1).rgb : vec3(0.0);
}
#else
#include "integrate/see.glsl"
#endif
#include "integrate/outlines.glsl"

const float DARK_SHARE = 0.02;

// Sums of a workgroup. Each invocation leaves its part; a row longer than it has parts keeps columns in different banks.
const uint COUNT = BY_HESSIAN != 0 ? SUMS : BEND;
const uint ROW = THREADS + 1;
shared float parts[COUNT * ROW];
shared float sums[2 * LIGHT + 9];

void put(uint which, float value) { parts[which * ROW + gl_LocalInvocationID.x] = value; }
void put3(uint which, vec3 v) { for (int c = 0; c < 3; ++c) put(which + c, v[c]); }
vec3 sums3(uint which) { return vec3(sums[which], sums[which + 1], sums[which + 2]); }

// Of a row, on top of `all`.
float with(float all, float part, bool is_peak) { return is_peak ? max(all, part) : all + part; }

void add_up(uint record) {
    barrier();
    for (uint which = gl_LocalInvocationID.x; which < COUNT; which += THREADS) {
        uint kind = which < BEND ? which % LIGHT : BEND;
        bool is_peak = kind >= PEAK && kind < LIGHT, is_of_edges = kind >= TRANSLATION && !is_peak;
        float all = 0.0;
#ifdef FROM_COMPUTE
        for (uint i = 0; i < PARTS; ++i) all = with(all, face_sums[(record * SUMS + which) * PARTS + i], is_peak);
#endif
        if (PARTS == 0 || is_of_edges)
            for (uint i = 0; i < THREADS; ++i) all = with(all, parts[which * ROW + i], is_peak);
        sums[which] = all;
    }
    barrier();
}

// What texels see, with the weights of E and ∇_r E = ∫ L (n×ω) dω.
void gather(uint record, Frame frame) {
    vec4 lit = vec4(0.0);
    vec3 lit_x = vec3(0.0), lit_y = vec3(0.0), lit_peak = vec3(0.0);
    vec3 open = vec3(0.0), open_x = vec3(0.0), open_y = vec3(0.0), open_peak = vec3(0.0);
    for (uint i = gl_LocalInvocationID.x; i < push.texel_count; i += THREADS) {
        vec4 seen;
        vec3 beyond;
        see(record, frame, i, seen, beyond);
        vec3 weight = texel_value(2 * i).xyz;
        lit += weight.x * seen;
        lit_x += weight.y * seen.rgb;
        lit_y += weight.z * seen.rgb;
        lit_peak = max(lit_peak, seen.rgb);
        open += weight.x * beyond;
        open_x += weight.y * beyond;
        open_y += weight.z * beyond;
        open_peak = max(open_peak, beyond);
    }
    put3(0, lit.rgb);
    put(3, lit.w);
    put3(ROTATION, lit_x);
    put3(ROTATION + 3, lit_y);
    put3(PEAK, lit_peak);
    if (HAS_SKY == 0) return;
    put3(LIGHT, open);
    put(LIGHT + 3, 0.0);
    put3(LIGHT + ROTATION, open_x);
    put3(LIGHT + ROTATION + 3, open_y);
    put3(LIGHT + PEAK, open_peak);
}

// What an edge between texels adds by the plane of what is nearer there; whether there is an outline.
bool slide_at(uint base, uint e, inout Slide sum) {
    vec4 edge = edge_value(3 * e);
    uvec2 of = floatBitsToUint(edge.zw);
    uint i = STRIDE * (base + of.x), j = STRIDE * (base + of.y);
    vec4 a = gathered_value(i), b = gathered_value(j);
    vec3 beyond = HAS_SKY != 0 ? gathered_value(j + 1).rgb - gathered_value(i + 1).rgb : vec3(0.0);
    float nearest = max(a.w, b.w);
    bool turned = a.w < b.w;
    vec3 between = edge_value(3 * e + 1).xyz, plane = gathered_value((turned ? j : i) + STRIDE - 1).xyz;
    vec3 bend = BY_HESSIAN != 0 ? edge_value(3 * e + 2).xyz : vec3(0.0);
    float at_edge = dot(plane, between);
    slide_over(sum, b.rgb - a.rgb, beyond, edge.xy, bend, at_edge, nearest);
    if (HAS_OUTLINES == 0) return false;
    vec3 other = gathered_value((turned ? i : j) + STRIDE - 1).xyz;
    return nearest > 0.0 && is_outline(vec2(at_edge, dot(other, between)));
}

// What edges between texels add.
void slide(uint record, Frame frame) {
    Slide sum = no_slide();
    uint base = record * push.texel_count;
    uint rounds = (push.edge_count + THREADS - 1) / THREADS, round = 0;
    while (round < rounds) {
        uint found[KEPT], count = 0;
        for (; round < rounds && count < KEPT; ++round) {
            uint e = edge_at(round);
            if (e < push.edge_count && slide_at(base, e, sum)) found[count++] = round;
        }
        if (HAS_OUTLINES != 0) correct_outlines(frame, base, found, count, sum);
    }
    put3(TRANSLATION, sum.lit_x);
    put3(TRANSLATION + 3, sum.lit_y);
    if (HAS_SKY != 0) {
        put3(LIGHT + TRANSLATION, sum.open_x);
        put3(LIGHT + TRANSLATION + 3, sum.open_y);
    }
    if (BY_HESSIAN == 0) return;
    put3(BEND, sum.xx);
    put3(BEND + 3, sum.xy);
    put3(BEND + 6, sum.yy);
}

// What a record carries of the light whose sums start at `first`.
Payload payload(Frame frame, uint first) {
    Payload p;
    p.irradiance = vec4(sums3(first), 1.0);
    for (uint c = 0; c < 3; ++c) {
        uint r = first + ROTATION + c, t = first + TRANSLATION + c;
        vec3 turn = HAS_ROTATION != 0 ? vec3(sums[r], sums[r + 3], 0.0) : vec3(0.0);
        vec3 slope = HAS_TRANSLATION != 0 ? vec3(sums[t], sums[t + 3], 0.0) : vec3(0.0);
        p.rotation[c] = vec4(to_world(frame, turn), PI * sums[first + PEAK + c]);
        p.translation[c] = vec4(to_world(frame, slope), 0.0);
    }
    return p;
}

float brightness(vec3 v) { return max(v.r, max(v.g, v.b)); }

// R by the split-sphere guess: the harmonic mean distance, no larger than E/‖∇_t E‖ (Křivánek et al. 2005).
float harmonic_r(float inverse_r) {
    float r = 1.0 / max(inverse_r, 1.0 / push.scene_radius);
    if (HAS_TRANSLATION != 0) {
        vec3 x = sums3(TRANSLATION), y = sums3(TRANSLATION + 3);
        float e = brightness(sums3(0)), g = brightness(sqrt(x * x + y * y));
        if (g * r > e) r = e / max(g, 1e-30);
    }
    return r;
}

// R by the error of the linear extrapolation, ½|λ|d² at a distance d along the worst direction, λ the eigenvalue of H
// (Jarosz et al. 2012; Schwarzhaupt et al. 2012): at d = a·R it is a²/2 of E. Where E is next to nothing, a share of the
// most that what is seen could give stands for it. A record that sees no light at all, in a nook behind a wall say, knows
// nothing of where that begins, but of what is near. CPU twin: math::ward::hessian_radius.
float hessian_r(float inverse_r) {
    vec3 e = sums3(0), most = PI * sums3(PEAK), xx = sums3(BEND), xy = sums3(BEND + 3), yy = sums3(BEND + 6);
    if (HAS_SKY != 0) {
        e += sums3(LIGHT);
        most += PI * sums3(LIGHT + PEAK);
    }
    vec3 half_ = 0.5 * (xx - yy), worst = 0.5 * abs(xx + yy) + sqrt(half_ * half_ + xy * xy);
    float lambda = brightness(worst), scale = brightness(e) + DARK_SHARE * brightness(most), r = push.scene_radius;
    if (lambda * r * r > scale) r = sqrt(scale / lambda);
    return scale > 0.0 ? r : harmonic_r(inverse_r);
}

void main() {
    uint record = gl_WorkGroupID.x;
    Frame frame = frames[record];
    if (PARTS == 0) gather(record, frame);
    if (HAS_TRANSLATION != 0) {
#ifndef FROM_COMPUTE
        memoryBarrierBuffer();
        barrier();
#endif
        slide(record, frame);
    }
    add_up(record);
    if (gl_LocalInvocationID.x > 0) return;
    float inverse_r = sums[3] * push.inverse_weight;
    float r = BY_HESSIAN != 0 ? hessian_r(inverse_r) : harmonic_r(inverse_r);
    payloads[(HAS_SKY + 1) * record] = payload(frame, 0);
    if (HAS_SKY != 0) payloads[2 * record + 1] = payload(frame, LIGHT);
    records[record].position.w = r;
    records[record].normal.w = inverse_r;
}

// Irradiance, its gradients and the harmonic mean distance of each record of a batch, from what its texels see. One
// workgroup a record; every sum has a fixed order. Texels and edges come as tables (src/math/capture.rs), so that the same
// pass serves any projection. CPU twin: math::capture::Table::integrate.
//
// FROM_COMPUTE: the capture wrote what texels see. What is only read is fetched through buffer views then, several times
// faster on CPU devices; captures by render passes ask no such views of a device.
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

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) buffer Records { Record records[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Payloads { Payload payloads[]; };
// Of each texel two values, of each edge three (src/vk/gpu_types.rs).
#ifdef FROM_COMPUTE
layout(set = 0, binding = 3) uniform textureBuffer texels;
layout(set = 0, binding = 4) uniform textureBuffer edges;
layout(set = 0, binding = 5) uniform textureBuffer gathered;  // laid out as inc/gathered.glsl says
vec4 texel_value(uint at) { return texelFetch(texels, int(at)); }
vec4 edge_value(uint at) { return texelFetch(edges, int(at)); }
vec4 gathered_value(uint at) { return texelFetch(gathered, int(at)); }
#else
layout(set = 0, binding = 3, std430) readonly buffer Texels { vec4 texels[]; };
layout(set = 0, binding = 4, std430) readonly buffer Edges { vec4 edges[]; };
layout(set = 0, binding = 5, std430) buffer Gathered { vec4 gathered[]; };
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
    float accuracy;      // Ward's a
    float min_radius;    // of the zone of influence, in pixels
    float max_radius;
    float scene_radius;  // R of a record that sees nothing
} push;

#include "inc/gathered.glsl"
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

const float DARK_SHARE = 0.02;

// Sums of a workgroup: of each kind of light E and Σ w/d, ∇_r E and ∇_t E channel by channel, and the largest radiance;
// then H of all light. Each invocation leaves its part; a row longer than it has parts keeps columns in different banks.
const uint ROTATION = 4, TRANSLATION = 10, PEAK = 16, LIGHT = 19, BEND = LIGHT * (1 + HAS_SKY), COUNT = BEND + 9 * BY_HESSIAN;
const uint ROW = THREADS + 1;
shared float parts[COUNT * ROW];
shared float sums[2 * LIGHT + 9];

void put(uint which, float value) { parts[which * ROW + gl_LocalInvocationID.x] = value; }
void put3(uint which, vec3 v) { for (int c = 0; c < 3; ++c) put(which + c, v[c]); }
vec3 sums3(uint which) { return vec3(sums[which], sums[which + 1], sums[which + 2]); }

void add_up() {
    barrier();
    for (uint which = gl_LocalInvocationID.x; which < COUNT; which += THREADS) {
        bool is_peak = which < BEND && which % LIGHT >= PEAK;
        float all = 0.0;
        for (uint i = 0; i < THREADS; ++i) {
            float part = parts[which * ROW + i];
            all = is_peak ? max(all, part) : all + part;
        }
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

// 1/distance of what moves at the edge between texels i and j: the nearer surface, where its plane meets the edge, not at
// the texel's centre. An outline lies within half a texel of the edge that stands for it, on either side alike, so that
// the error is of second order in the texel's width; with the centre's distance, which is always further inside, it is
// of first. Planes seen edge-on are extrapolated to three times the distance's inverse at most, evenly both ways.
float inverse_edge_distance(vec3 between, float a, float b, uint i, uint j) {
    float nearest = max(a, b);
    vec3 plane = gathered_value((a >= b ? i : j) + STRIDE - 1).xyz;
    return clamp(dot(plane, between), -nearest, 3.0 * nearest);
}

// ∇_t E = −Σ (L_i − L_j)·tan(γ/2)·n·(a+b)·m / r over all edges between texels.
//
// Its own derivative, an edge in the direction ω staying where it is in space: H = −4 Σ (L_i − L_j) sym(step ⊗ ω) / r².
// With w = M − x from the point to an edge's middle M, D along it, the step over r is (n·w)(D×w)/|w|⁴; x in the tangent
// plane leaves n·w as it is, D×w changes by an antisymmetric part alone, and |w|⁻⁴ by 4w/|w|⁶. The light of the sky and of
// surfaces together; `bend` is (xx, xy, yy), local.
void slide(uint record) {
    vec3 lit_x = vec3(0.0), lit_y = vec3(0.0), open_x = vec3(0.0), open_y = vec3(0.0);
    vec3 bend[3] = vec3[3](vec3(0.0), vec3(0.0), vec3(0.0));
    uint base = record * push.texel_count;
    for (uint e = gl_LocalInvocationID.x; e < push.edge_count; e += THREADS) {
        vec4 edge = edge_value(3 * e);
        uvec2 of = floatBitsToUint(edge.zw);
        uint i = STRIDE * (base + of.x), j = STRIDE * (base + of.y);
        vec4 a = gathered_value(i), b = gathered_value(j);
        vec3 difference = a.rgb - b.rgb;
        vec2 step_ = edge.xy * inverse_edge_distance(edge_value(3 * e + 1).xyz, a.w, b.w, i, j);
        lit_x -= difference * step_.x;
        lit_y -= difference * step_.y;
        if (HAS_SKY != 0) {
            vec3 beyond = gathered_value(i + 1).rgb - gathered_value(j + 1).rgb;
            open_x -= beyond * step_.x;
            open_y -= beyond * step_.y;
            difference += beyond;
        }
        if (BY_HESSIAN != 0) {
            // By the texels' own distances: what is extrapolated to the edge would be squared here.
            float nearest = max(a.w, b.w);
            vec2 m = edge_value(3 * e + 2).xy, s = nearest * nearest * edge.xy;
            bend[0] -= difference * (4.0 * s.x * m.x);
            bend[1] -= difference * (2.0 * (s.x * m.y + s.y * m.x));
            bend[2] -= difference * (4.0 * s.y * m.y);
        }
    }
    put3(TRANSLATION, lit_x);
    put3(TRANSLATION + 3, lit_y);
    if (HAS_SKY != 0) {
        put3(LIGHT + TRANSLATION, open_x);
        put3(LIGHT + TRANSLATION + 3, open_y);
    }
    if (BY_HESSIAN != 0) for (int c = 0; c < 3; ++c) put3(BEND + 3 * c, bend[c]);
}

// What a record carries of the light whose sums start at `first`; beyond the radius that the gradient is good for, it is
// damped to stay bounded.
Payload payload(Frame frame, uint first, float damping, float share) {
    Payload p;
    p.irradiance = vec4(sums3(first), 1.0);
    for (uint c = 0; c < 3; ++c) {
        uint r = first + ROTATION + c, t = first + TRANSLATION + c;
        vec3 turn = HAS_ROTATION != 0 ? vec3(sums[r], sums[r + 3], 0.0) : vec3(0.0);
        vec3 slope = HAS_TRANSLATION != 0 ? vec3(sums[t], sums[t + 3], 0.0) : vec3(0.0);
        p.rotation[c] = vec4(to_world(frame, turn), PI * sums[first + PEAK + c]);
        p.translation[c] = vec4(to_world(frame, slope) * damping, share);
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
    gather(record, frame);
    if (HAS_TRANSLATION != 0) {
#ifndef FROM_COMPUTE
        memoryBarrierBuffer();
        barrier();
#endif
        slide(record);
    }
    add_up();
    if (gl_LocalInvocationID.x > 0) return;
    float inverse_r = sums[3] * push.inverse_weight;
    float r = BY_HESSIAN != 0 ? hessian_r(inverse_r) : harmonic_r(inverse_r);
    float wanted = push.accuracy * r, footprint = records[record].geometric.w;
    float radius = clamp(wanted, push.min_radius * footprint, push.max_radius * footprint);
    // A linear change is good for something up to R, where what it leaves out is half of E, whatever the accuracy. In a
    // zone that is wider still, it is damped.
    float damping = min(1.0, r / radius), share = min(1.0, wanted / radius);
    payloads[(HAS_SKY + 1) * record] = payload(frame, 0, damping, share);
    if (HAS_SKY != 0) payloads[2 * record + 1] = payload(frame, LIGHT, damping, share);
    records[record].position.w = radius;
    records[record].normal.w = inverse_r;
}

// Irradiance, its gradients and the harmonic mean distance of each record of a batch, from its captured views. One
// workgroup a record; every sum has a fixed order. Texels and edges come as tables (src/math/capture.rs), so that the same
// pass serves any projection. CPU twin: math::capture::Table::integrate.
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

struct Texel { vec4 direction; uvec4 place; };  // local unit direction, cosine weight | layer<<16 | y<<8 | x, forward, ∫ n×ω dω
struct Edge { vec4 step_; uvec4 texels; };      // tan(γ/2)·n·(a+b)·m from i to j (local) | i, j, tangential part of the direction of its middle

layout(set = 0, binding = 0, std430) readonly buffer Positions { float positions[]; };
layout(set = 0, binding = 1, std430) readonly buffer Indices { uint indices[]; };
layout(set = 0, binding = 2, std430) readonly buffer FirstCell { uint first_cell[]; };
layout(set = 0, binding = 3, std430) readonly buffer CellRadiance { float cell_radiance[]; };
#ifdef FROM_COMPUTE
layout(set = 1, binding = 0, std430) readonly buffer Seen { uvec2 seen_texels[]; };  // identity, 1/distance
layout(set = 1, binding = 1, std430) readonly buffer Unused { uint unused[]; };
#else
layout(set = 1, binding = 0) uniform utexture2DArray identities;
layout(set = 1, binding = 1) uniform texture2DArray depths;
#endif
layout(set = 1, binding = 2, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 1, binding = 3, std430) readonly buffer Texels { Texel texels[]; };
layout(set = 1, binding = 4, std430) readonly buffer Edges { Edge edges[]; };
layout(set = 1, binding = 5, std430) buffer Gathered { vec4 gathered[]; };  // radiance, 1/distance; the sky's; the plane
layout(set = 1, binding = 6, std430) buffer Records { Record records[]; };
layout(set = 1, binding = 7, std430) writeonly buffer Payloads { Payload payloads[]; };
layout(set = 1, binding = 8, std430) readonly buffer Sky { uvec4 sky_size; vec4 sky[]; };
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

#include "inc/cells.glsl"
#include "inc/sky.glsl"
#ifndef FROM_COMPUTE
#include "integrate/curved.glsl"
#endif

const float DARK_SHARE = 0.02;

shared vec4 partial[THREADS];

vec4 sum_all(vec4 value) {
    uint me = gl_LocalInvocationID.x;
    barrier();
    partial[me] = value;
    for (uint half_ = THREADS / 2; half_ > 0; half_ /= 2) {
        barrier();
        if (me < half_) partial[me] += partial[me + half_];
    }
    barrier();
    return partial[0];
}

vec3 max_all(vec3 value) {
    uint me = gl_LocalInvocationID.x;
    barrier();
    partial[me].xyz = value;
    for (uint half_ = THREADS / 2; half_ > 0; half_ /= 2) {
        barrier();
        if (me < half_) partial[me].xyz = max(partial[me].xyz, partial[me + half_].xyz);
    }
    barrier();
    return partial[0].xyz;
}

ivec2 place_of(Texel texel) { return ivec2(texel.place.x & 255, (texel.place.x >> 8) & 255); }

// Identity, and 1/distance as bits, of what a texel sees.
uvec2 look(uint record, uint i, uvec2 tile, Texel texel, float near) {
#ifdef FROM_COMPUTE
    return seen_texels[record * push.texel_count + i];
#else
    ivec3 at = ivec3(ivec2(tile) + place_of(texel), texel.place.x >> 16);
    float depth = texelFetch(depths, at, 0).x;
    return uvec2(texelFetch(identities, at, 0).x, floatBitsToUint(depth * uintBitsToFloat(texel.place.y) / near));
#endif
}

// Values of a texel in `gathered`: always radiance, then the sky's, then the plane.
const uint STRIDE = 1 + HAS_SKY + HAS_TRANSLATION;

// The plane of a triangle, local: along any unit direction its dot product is 1/distance from the frame's origin.
vec3 inverse_plane(uint triangle, Frame frame) {
    uvec3 c = corners_of(triangle);
    vec3 p0 = position_of(c.x);
    vec3 n = cross(position_of(c.y) - p0, position_of(c.z) - p0);
    float height = dot(n, p0 - frame.origin.xyz);
    return height != 0.0 ? to_local(frame, n) / height : vec3(0.0);
}

struct Sums { vec4 irradiance; vec3 rotation[3]; vec3 peak; };  // irradiance.w: Σ w/d; peak: largest radiance

void gather(uint record, Frame frame, out Sums lit, out Sums open) {
    lit = Sums(vec4(0.0), vec3[3](vec3(0.0), vec3(0.0), vec3(0.0)), vec3(0.0));
    open = lit;
    uvec2 tile = uvec2(record % push.columns, record / push.columns) * push.tile_size;
    for (uint i = gl_LocalInvocationID.x; i < push.texel_count; i += THREADS) {
        Texel texel = texels[i];
        uvec2 hit = look(record, i, tile, texel, frame.origin.w);
        vec3 direction = to_world(frame, texel.direction.xyz);
#ifndef FROM_COMPUTE
        if (IS_CURVED != 0) hit = look_closely(tile, place_of(texel), frame.origin.xyz, direction);
#endif
        uint identity = hit.x;
        float weight = texel.direction.w;
        vec3 turn = vec3(uintBitsToFloat(texel.place.z), uintBitsToFloat(texel.place.w), 0.0);
        vec4 seen = vec4(0.0);
        vec3 beyond = vec3(0.0), plane = vec3(0.0);
        bool above = dot(direction, frame.horizon.xyz) > 0.0;
        if (identity != 0 && above) {
            uint triangle = (identity & 0x7fffffffu) - 1;
            seen.rgb = surface_radiance(triangle, identity >= 0x80000000u, frame.origin.xyz, direction);
            seen.w = uintBitsToFloat(hit.y);
            if (HAS_TRANSLATION != 0) plane = inverse_plane(triangle, frame);
        } else if (HAS_SKY != 0 && above) {
            beyond = sky_radiance(direction);
        }
        lit.irradiance += weight * seen;
        lit.peak = max(lit.peak, seen.rgb);
        if (HAS_ROTATION != 0) for (int c = 0; c < 3; ++c) lit.rotation[c] += seen[c] * turn;
        uint at = STRIDE * (record * push.texel_count + i);
        gathered[at] = seen;
        if (HAS_TRANSLATION != 0) gathered[at + STRIDE - 1] = vec4(plane, 0.0);
        if (HAS_SKY != 0) {
            open.irradiance.rgb += weight * beyond;
            open.peak = max(open.peak, beyond);
            if (HAS_ROTATION != 0) for (int c = 0; c < 3; ++c) open.rotation[c] += beyond[c] * turn;
            gathered[at + 1] = vec4(beyond, 0.0);
        }
    }
}

// 1/distance of what moves at the edge between texels i and j: the nearer surface, where its plane meets the edge, not at
// the texel's centre. An outline lies within half a texel of the edge that stands for it, on either side alike, so that
// the error is of second order in the texel's width; with the centre's distance, which is always further inside, it is
// of first. Planes seen edge-on are extrapolated to three times the distance's inverse at most, evenly both ways.
float inverse_edge_distance(uvec2 edge, uint i, uint j) {
    float a = gathered[i].w, b = gathered[j].w;
    float nearest = max(a, b);
    vec3 plane = gathered[(a >= b ? i : j) + STRIDE - 1].xyz;
    vec3 between = normalize(texels[edge.x].direction.xyz + texels[edge.y].direction.xyz);
    return clamp(dot(plane, between), -nearest, 3.0 * nearest);
}

// ∇_t E = −Σ (L_i − L_j)·tan(γ/2)·n·(a+b)·m / r over all edges between texels.
//
// Its own derivative, an edge in the direction ω staying where it is in space: H = −4 Σ (L_i − L_j) sym(step ⊗ ω) / r².
// With w = M − x from the point to an edge's middle M, D along it, the step over r is (n·w)(D×w)/|w|⁴; x in the tangent
// plane leaves n·w as it is, D×w changes by an antisymmetric part alone, and |w|⁻⁴ by 4w/|w|⁶. The light of the sky and of
// surfaces together; `bend` is (xx, xy, yy), local.
void slide(uint record, out vec3 lit[3], out vec3 open[3], out vec3 bend[3]) {
    for (int c = 0; c < 3; ++c) lit[c] = open[c] = bend[c] = vec3(0.0);
    uint base = record * push.texel_count;
    for (uint e = gl_LocalInvocationID.x; e < push.edge_count; e += THREADS) {
        Edge edge = edges[e];
        uint i = STRIDE * (base + edge.texels.x), j = STRIDE * (base + edge.texels.y);
        vec3 step_ = edge.step_.xyz * inverse_edge_distance(edge.texels.xy, i, j);
        vec3 difference = gathered[i].rgb - gathered[j].rgb;
        for (int c = 0; c < 3; ++c) lit[c] -= difference[c] * step_;
        if (HAS_SKY != 0) {
            vec3 beyond = gathered[i + 1].rgb - gathered[j + 1].rgb;
            for (int c = 0; c < 3; ++c) open[c] -= beyond[c] * step_;
            difference += beyond;
        }
        if (BY_HESSIAN != 0) {
            // By the texels' own distances: what is extrapolated to the edge would be squared here.
            float nearest = max(gathered[i].w, gathered[j].w);
            vec2 m = uintBitsToFloat(edge.texels.zw), s = nearest * nearest * edge.step_.xy;
            vec3 h = vec3(4.0 * s.x * m.x, 2.0 * (s.x * m.y + s.y * m.x), 4.0 * s.y * m.y);
            for (int c = 0; c < 3; ++c) bend[c] -= difference[c] * h;
        }
    }
}

Payload total(Frame frame, Sums sums, vec3 moves[3]) {
    Payload p;
    vec3 most = PI * max_all(sums.peak);
    p.irradiance = vec4(sum_all(sums.irradiance).rgb, 1.0);
    for (int c = 0; c < 3; ++c) {
        vec3 r = HAS_ROTATION != 0 ? sum_all(vec4(sums.rotation[c], 0.0)).xyz : vec3(0.0);
        vec3 t = HAS_TRANSLATION != 0 ? sum_all(vec4(moves[c], 0.0)).xyz : vec3(0.0);
        p.rotation[c] = vec4(to_world(frame, vec3(r.xy, 0.0)), most[c]);
        p.translation[c] = vec4(to_world(frame, vec3(t.xy, 0.0)), 0.0);
    }
    return p;
}

float brightness(vec3 v) { return max(v.r, max(v.g, v.b)); }

// R by the split-sphere guess: the harmonic mean distance, no larger than E/‖∇_t E‖ (Křivánek et al. 2005).
float harmonic_r(float inverse_r, Payload p) {
    float r = 1.0 / max(inverse_r, 1.0 / push.scene_radius);
    if (HAS_TRANSLATION != 0) {
        vec3 slope = vec3(length(p.translation[0].xyz), length(p.translation[1].xyz), length(p.translation[2].xyz));
        float e = brightness(p.irradiance.rgb), g = brightness(slope);
        if (g * r > e) r = e / max(g, 1e-30);
    }
    return r;
}

// R by the error of the linear extrapolation, ½|λ|d² at a distance d along the worst direction, λ the eigenvalue of H
// (Jarosz et al. 2012; Schwarzhaupt et al. 2012): at d = a·R it is a²/2 of E. Where E is next to nothing, a share of the
// most that what is seen could give stands for it. CPU twin: math::ward::hessian_radius.
float hessian_r(float e, float most, vec3 bend[3]) {
    vec3 worst;
    for (int c = 0; c < 3; ++c)
        worst[c] = abs(bend[c].x + bend[c].z) * 0.5 + length(vec2((bend[c].x - bend[c].z) * 0.5, bend[c].y));
    float lambda = brightness(worst), scale = e + DARK_SHARE * most, r = push.scene_radius;
    if (lambda * r * r > scale) r = sqrt(scale / lambda);
    return r;
}

void main() {
    uint record = gl_WorkGroupID.x;
    Frame frame = frames[record];
    Sums lit, open;
    gather(record, frame, lit, open);
    vec3 lit_moves[3], open_moves[3], bend[3];
    if (HAS_TRANSLATION != 0) {
        memoryBarrierBuffer();
        barrier();
        slide(record, lit_moves, open_moves, bend);
    }
    float inverse_r = sum_all(lit.irradiance).w * push.inverse_weight;
    Payload p = total(frame, lit, lit_moves), q;
    if (HAS_SKY != 0) q = total(frame, open, open_moves);
    float r;
    if (BY_HESSIAN != 0) {
        for (int c = 0; c < 3; ++c) bend[c] = sum_all(vec4(bend[c], 0.0)).xyz;
        vec3 e = p.irradiance.rgb, most = vec3(p.rotation[0].w, p.rotation[1].w, p.rotation[2].w);
        if (HAS_SKY != 0) {
            e += q.irradiance.rgb;
            most += vec3(q.rotation[0].w, q.rotation[1].w, q.rotation[2].w);
        }
        r = hessian_r(brightness(e), brightness(most), bend);
    } else {
        r = harmonic_r(inverse_r, p);
    }
    float wanted = push.accuracy * r, footprint = records[record].geometric.w;
    float radius = clamp(wanted, push.min_radius * footprint, push.max_radius * footprint);
    // Beyond the radius that the gradient is good for, it is damped to stay bounded.
    float allowed = min(1.0, wanted / radius);
    for (int c = 0; c < 3; ++c) {
        p.translation[c] = vec4(p.translation[c].xyz * allowed, allowed);
        if (HAS_SKY != 0) q.translation[c] = vec4(q.translation[c].xyz * allowed, allowed);
    }
    if (gl_LocalInvocationID.x == 0) {
        payloads[(HAS_SKY + 1) * record] = p;
        if (HAS_SKY != 0) payloads[2 * record + 1] = q;
        records[record].position.w = radius;
        records[record].normal.w = inverse_r;
    }
}

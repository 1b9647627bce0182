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

struct Texel { vec4 direction; uvec4 place; };  // local unit direction, cosine weight | layer<<16 | y<<8 | x, forward, ∫ n×ω dω
struct Edge { vec4 step_; uvec4 texels; };      // tan(γ/2)·n·(a+b)·m from i to j (local) | i, j

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

struct Sums { vec4 irradiance; vec3 rotation[3]; };  // irradiance.w: Σ w/d

void gather(uint record, Frame frame, out Sums lit, out Sums open) {
    lit = Sums(vec4(0.0), vec3[3](vec3(0.0), vec3(0.0), vec3(0.0)));
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
        if (HAS_ROTATION != 0) for (int c = 0; c < 3; ++c) lit.rotation[c] += seen[c] * turn;
        uint at = STRIDE * (record * push.texel_count + i);
        gathered[at] = seen;
        if (HAS_TRANSLATION != 0) gathered[at + STRIDE - 1] = vec4(plane, 0.0);
        if (HAS_SKY != 0) {
            open.irradiance.rgb += weight * beyond;
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
void slide(uint record, out vec3 lit[3], out vec3 open[3]) {
    for (int c = 0; c < 3; ++c) lit[c] = open[c] = vec3(0.0);
    uint base = record * push.texel_count;
    for (uint e = gl_LocalInvocationID.x; e < push.edge_count; e += THREADS) {
        Edge edge = edges[e];
        uint i = STRIDE * (base + edge.texels.x), j = STRIDE * (base + edge.texels.y);
        vec3 step_ = edge.step_.xyz * inverse_edge_distance(edge.texels.xy, i, j);
        vec3 change = gathered[i].rgb - gathered[j].rgb;
        for (int c = 0; c < 3; ++c) lit[c] -= change[c] * step_;
        if (HAS_SKY != 0) {
            vec3 difference = gathered[i + 1].rgb - gathered[j + 1].rgb;
            for (int c = 0; c < 3; ++c) open[c] -= difference[c] * step_;
        }
    }
}

Payload total(Frame frame, Sums sums, vec3 moves[3], float allowed) {
    Payload p;
    p.irradiance = vec4(sum_all(sums.irradiance).rgb, 1.0);
    for (int c = 0; c < 3; ++c) {
        vec3 r = HAS_ROTATION != 0 ? sum_all(vec4(sums.rotation[c], 0.0)).xyz : vec3(0.0);
        vec3 t = HAS_TRANSLATION != 0 ? sum_all(vec4(moves[c], 0.0)).xyz : vec3(0.0);
        p.rotation[c] = vec4(to_world(frame, vec3(r.xy, 0.0)), 0.0);
        p.translation[c] = vec4(to_world(frame, vec3(t.xy, 0.0)), allowed);
    }
    return p;
}

float brightness(vec3 v) { return max(v.r, max(v.g, v.b)); }

// Radius of the zone of influence: a·R, R no larger than E/‖∇_t E‖ (Křivánek et al. 2005), within limits in pixels.
float zone_radius(float inverse_r, Payload p, float footprint, out float wanted) {
    float r = 1.0 / max(inverse_r, 1.0 / push.scene_radius);
    if (HAS_TRANSLATION != 0) {
        vec3 slope = vec3(length(p.translation[0].xyz), length(p.translation[1].xyz), length(p.translation[2].xyz));
        float e = brightness(p.irradiance.rgb), g = brightness(slope);
        if (g * r > e) r = e / max(g, 1e-30);
    }
    wanted = push.accuracy * r;
    return clamp(wanted, push.min_radius * footprint, push.max_radius * footprint);
}

void main() {
    uint record = gl_WorkGroupID.x;
    Frame frame = frames[record];
    Sums lit, open;
    gather(record, frame, lit, open);
    vec3 lit_moves[3], open_moves[3];
    if (HAS_TRANSLATION != 0) {
        memoryBarrierBuffer();
        barrier();
        slide(record, lit_moves, open_moves);
    }
    float inverse_r = sum_all(lit.irradiance).w * push.inverse_weight;
    Payload p = total(frame, lit, lit_moves, 1.0);
    float wanted, radius = zone_radius(inverse_r, p, records[record].geometric.w, wanted);
    // Beyond the radius that the gradient is good for, it is damped to stay bounded.
    float allowed = min(1.0, wanted / radius);
    for (int c = 0; c < 3; ++c) p.translation[c].xyz *= allowed;
    if (gl_LocalInvocationID.x == 0) payloads[(HAS_SKY + 1) * record] = p;
    if (HAS_SKY != 0) {
        Payload q = total(frame, open, open_moves, allowed);
        for (int c = 0; c < 3; ++c) q.translation[c].xyz *= allowed;
        if (gl_LocalInvocationID.x == 0) payloads[2 * record + 1] = q;
    }
    if (gl_LocalInvocationID.x == 0) {
        records[record].position.w = radius;
        records[record].normal.w = inverse_r;
    }
}

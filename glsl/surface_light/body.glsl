// Lights the surface cells of one material: adds, for each light sample of the current batch of shadow views, the
// radiance that a cell reflects to its front and to its back. Each pair of cell and light sample uses a point of its own
// in the cell, so that the cell's mean over many samples is a mean over its area too: that part which an alpha mask leaves.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/hash.glsl"
#include "inc/views.glsl"
layout(local_size_x = 64) in;
#include "inc/invocation.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/material_textures.glsl"
#include "inc/vertex_streams.glsl"
#include "inc/surface.glsl"
layout(constant_id = 8) const uint LIGHT_KIND = 0;
layout(constant_id = 9) const uint SHADOW_VIEWS = 0;
layout(constant_id = 10) const uint SHADOW_SIZE = 256;
layout(constant_id = 11) const uint SHADOW_COLUMNS = 1;
layout(constant_id = 12) const uint SHADOW_ROWS = 1;
layout(constant_id = 13) const uint SHADOW_OPAQUE = 0;
layout(constant_id = 14) const uint SHADOW_OWN = 1;  // the map shows the cells' own triangles, not coarser ones

layout(set = LIGHT_SET, binding = 0, std430) readonly buffer Lights { LightSample lights[]; };
layout(set = LIGHT_SET, binding = 1, std430) readonly buffer Frames { Frame frames[]; };
layout(set = LIGHT_SET, binding = 2) uniform sampler2DArray shadow_depth;
layout(set = LIGHT_SET, binding = 3) uniform utexture2DArray shadow_identity;
layout(set = LIGHT_SET, binding = 4) uniform utexture2D triangles;
layout(set = LIGHT_SET, binding = 5, std430) readonly buffer FirstCell { uint first_cell[]; };
layout(set = LIGHT_SET, binding = 6, std430) readonly buffer CellTriangle { uint cell_triangle[]; };
layout(set = LIGHT_SET, binding = 7, std430) buffer CellRadiance { float cell_radiance[]; };
layout(push_constant) uniform Push {
    uint material;
    uint first;        // cell
    uint count;
    uint first_light;  // of the batch
    uint light_count;
    uint points;       // points in a cell for each light sample
    float lift;
    uint stride;       // of pairs of a light sample and a point a cell takes one in so many, from a place of its own on
    vec4 core;
} push;

#include "inc/cells.glsl"
#include "inc/triangles.glsl"
#include "inc/light.glsl"
#include "inc/lift.glsl"
#include "inc/shadow.glsl"

// Captures see masked materials where they are present, so that only such points count: this many are tried for a pair.
const uint TRIES = 8;

// The s-th point of a cell's triangle: R2 sequence (Roberts 2018), turned by the cell and by how often it was tried, folded.
vec2 point_in_cell(uint cell, uint s, uint tries) {
    uint seed = cell ^ tries * 0x85ebca6bu;
    vec2 turn = vec2(unit_float(pcg(seed)), unit_float(pcg(seed ^ 0x9e3779b9u)));
    vec2 p = fract(turn + vec2(0.7548776662466927, 0.5698402909980532) * float(s + 1));
    return p.x + p.y > 1.0 ? 1.0 - p : p;
}

struct Corners { vec3 p0, e1, e2; vec3 geometric; vec3 normals[3]; vec2 uv0[3], uv1[3]; vec4 colors[3], tangents[3]; };

Corners corners_at(uint triangle) {
    uvec3 c = corners_of(triangle);
    Corners t;
    t.p0 = position_of(c.x);
    t.e1 = position_of(c.y) - t.p0;
    t.e2 = position_of(c.z) - t.p0;
    t.geometric = normalize(cross(t.e1, t.e2));
    for (int i = 0; i < 3; ++i) {
        t.normals[i] = oct_decode(normals[c[i]]);
        t.uv0[i] = uv0_of(c[i]);
        t.uv1[i] = uv1_of(c[i]);
        t.colors[i] = color_of(c[i]);
        t.tangents[i] = tangent_of(c[i]);
    }
    return t;
}

Surface surface_of(Corners t, Material material, vec2 uv) {
    vec3 b = vec3(1.0 - uv.x - uv.y, uv);
    vec3 normal = b.x * t.normals[0] + b.y * t.normals[1] + b.z * t.normals[2];
    float length2 = dot(normal, normal);
    normal = length2 > 1e-12 ? normal * inversesqrt(length2) : t.geometric;
    Surface surface = surface_at(material, b.x * t.uv0[0] + b.y * t.uv0[1] + b.z * t.uv0[2],
        b.x * t.uv1[0] + b.y * t.uv1[1] + b.z * t.uv1[2], b.x * t.colors[0] + b.y * t.colors[1] + b.z * t.colors[2],
        normal, b.x * t.tangents[0] + b.y * t.tangents[1] + b.z * t.tangents[2]);
    if (dot(surface.normal, t.geometric) < 0.0) surface.normal = -surface.normal;
    return surface;
}

// Where in its triangle a pair's point is, tried for the n-th time.
vec2 place_of(uint index, uint r, uint cell, uint first, uint n) {
    vec2 uv = cell_point(r, cell - first, point_in_cell(cell, push.first_light * push.points + index, n));
    // A grain inside: what lies on the triangle's edge may be rounded to lie on the other side of what joins it there.
    return 1e-6 + (1.0 - 3e-6) * uv;
}

// The first try that meets the surface; TRIES if none does.
uint present_try(uint index, Corners t, Material material, uint r, uint cell, uint first) {
    for (uint n = 0; n < TRIES; ++n)
        if (surface_of(t, material, place_of(index, r, cell, first, n)).albedo.a >= material.alpha.x) return n;
    return TRIES;
}

// A point of a cell and what one light sample sends to it, before its shadow.
struct Sample { uint light; vec2 uv; vec3 lifted; vec3 direction; vec3 irradiance; float side; };

Sample sample_at(uint index, Corners t, uint r, uint cell, uint first, uint n) {
    Sample s;
    s.light = index / push.points;
    s.uv = place_of(index, r, cell, first, n);
    vec3 p = t.p0 + s.uv.x * t.e1 + s.uv.y * t.e2;
    Arriving light = light_arriving(lights[s.light], p);
    s.side = dot(t.geometric, light.direction);
    float lift = lift_at(p, push.core, push.lift);
    s.lifted = p + t.geometric * (s.side >= 0.0 ? lift : -lift);
    s.direction = light.direction;
    s.irradiance = is_in_shell(lights[s.light], p, push.core.xyz) ? light.irradiance : vec3(0.0);
    return s;
}

// Which try of a pair met the surface: of 32 pairs, a bit of each in a word.
uint try_of(uvec3 words, uint i) {
    if (HAS_MASK == 0) return 0;
    uvec3 bits = words >> i & 1;
    return bits.x | bits.y << 1 | bits.z << 2;
}

void main() {
    uint at = invocation();
    if (at >= push.count) return;
    uint cell = push.first + at;
    uint triangle = cell_triangle[cell];
    uint first = first_cell[triangle], r = cell_resolution(first_cell[triangle + 1] - first);
    Corners corners = corners_at(triangle);
    Material material = materials[push.material];

    vec3 front = vec3(0.0), back = vec3(0.0);
    uint samples = push.light_count * push.points, taken = 0, absent = 0;
    // Neighbours begin at others, so that together they take all pairs.
    for (uint start = (cell + push.first_light) % push.stride; start < samples; start += 32 * push.stride) {
        // Of up to 32 pairs of light sample and point: which are lit, which too close to an edge to tell so quickly.
        uint lit = 0, close = 0, end = min(32, (samples - start + push.stride - 1) / push.stride);
        taken += end;
        uvec3 tries = uvec3(0);
        for (uint i = 0; i < end; ++i) {
            if (HAS_MASK != 0) {
                uint n = present_try(start + i * push.stride, corners, material, r, cell, first);
                if (n == TRIES) {
                    ++absent;
                    continue;
                }
                tries |= (uvec3(n, n >> 1, n >> 2) & 1) << i;
            }
            Sample s = sample_at(start + i * push.stride, corners, r, cell, first, try_of(tries, i));
            if (!any(greaterThan(s.irradiance, vec3(0.0)))) continue;
            float nearness;
            uint shadow = shadow_at(s.light, s.lifted, corners.geometric, SHADOW_OWN != 0, nearness);
            if (shadow == LIT) lit |= 1u << i;
            if (shadow == CLOSE) close |= 1u << i;
        }
        for (; close != 0; close &= close - 1) {
            uint i = findLSB(close);
            Sample s = sample_at(start + i * push.stride, corners, r, cell, first, try_of(tries, i));
            if (is_lit(s.light, SHADOW_OWN != 0 ? triangle : NO_TRIANGLE, s.lifted, corners.geometric)) lit |= 1u << i;
        }
        for (; lit != 0; lit &= lit - 1) {
            uint i = findLSB(lit);
            Sample s = sample_at(start + i * push.stride, corners, r, cell, first, try_of(tries, i));
            Surface surface = surface_of(corners, material, s.uv);
            vec3 leaving = surface.albedo.rgb * s.irradiance / (PI * float(push.points));
            float cosine = dot(surface.normal, s.direction);
            if (s.side > 0.0) front += leaving * max(cosine, 0.0);
            else back += leaving * max(-cosine, 0.0);
        }
    }
    // Pairs that are taken stand for the others, and for those without a point of the surface. Of what has none nothing is seen.
    float share = absent < taken ? float(push.stride * taken) / float(taken - absent) : 0.0;
    for (int k = 0; k < 3; ++k) {
        cell_radiance[6 * cell + k] += share * front[k];
        cell_radiance[6 * cell + 3 + k] += share * back[k];
    }
}

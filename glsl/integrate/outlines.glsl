// Outlines between texels, also of different faces (inc/outlines.glsl). Each invocation finds some among its edges, then sifts
// and corrects them, and waits for no other. Wants what body.glsl declares.

#ifdef FROM_COMPUTE
layout(set = 0, binding = 7) uniform textureBuffer corners;  // as the capture has them
layout(set = 0, binding = 8) uniform textureBuffer across;   // numbers plus 1 (bits) of the triangles across the edges
                                                             // opposite to the corners; 0: none
layout(set = 0, binding = 9, std430) readonly buffer CellRadiance { float cell_radiance[]; };
#include "inc/cells.glsl"
#include "inc/cell_light.glsl"
#else
layout(set = 1, binding = 6, std430) readonly buffer Across { uint across[]; };  // the same
#endif
#include "inc/outlines.glsl"

#ifdef FROM_COMPUTE
#include "inc/tree_facets.glsl"

// Of coarse triangles there are none: scenes that have them have more triangles than a capture in shared memory has texels.
uint facet_cell(uint number, Facet f, vec2 uv) {
    return floatBitsToUint(f.a.w) + cell_at(floatBitsToUint(f.b.w) >> 16, uv);
}
#else
Facet facet(uint number) {
    uvec3 c = corners_of(number - 1);
    return Facet(vec4(position_of(c.x), 0.0), vec4(position_of(c.y), 0.0), position_of(c.z));
}

uvec3 across_of(uint number) {
    uint at = 3 * (number - 1);
    return uvec3(across[at], across[at + 1], across[at + 2]);
}

uint facet_cell(uint number, Facet f, vec2 uv) { return cell_of(number - 1, uv); }
#endif

vec3 facet_light(uint number, Facet f, vec3 eye, vec3 way) {
    vec3 a = f.a.xyz - eye, e1 = f.b.xyz - f.a.xyz, e2 = f.c - f.a.xyz;
    return cell_light(facet_cell(number, f, barycentrics(a, e1, e2, way)), dot(a, cross(e1, e2)) < 0.0);
}

// Outlines that an invocation finds before it goes through them.
const uint KEPT = HAS_OUTLINES != 0 ? 32 : 1;

// The edge that an invocation looks at in a round, or one behind the last. If those of a column of texels fell to one
// invocation, a straight outline did.
uint edge_at(uint round) {
    return THREADS * round + (gl_LocalInvocationID.x + (HAS_OUTLINES != 0 ? 5 * round : 0)) % THREADS;
}

// Places in `gathered` of two texels, the nearer one first; the step from it to the other.
struct Pair { uint near, far; vec2 step_; float sense; Question asked; };

Pair pair_of(Frame frame, uint base, uint e) {
    vec4 edge = edge_value(3 * e);
    uvec2 of = floatBitsToUint(edge.zw), at = STRIDE * (base + of);
    vec3 way = to_world(frame, texel_value(2 * of.x + 1).xyz), next = to_world(frame, texel_value(2 * of.y + 1).xyz);
    float here = gathered_value(at.x).w, there = gathered_value(at.y).w, nearest = max(here, there);
    bool turned = here < there;
    if (turned) at = at.yx;
    vec4 plane = gathered_value(at.x + STRIDE - 1);
    float plain = bounded(dot(plane.xyz, edge_value(3 * e + 1).xyz), nearest), sense = turned ? -1.0 : 1.0;
    uint near = untagged(plane.w), far = untagged(gathered_value(at.y + STRIDE - 1).w);
    Question asked = question(near, far, frame.origin.xyz, turned ? next : way, turned ? way : next, nearest, plain);
    return Pair(at.x, at.y, sense * edge.xy, sense, asked);
}

// Corrects the edges of `count` rounds.
void correct_outlines(Frame frame, uint base, uint rounds[KEPT], uint count, inout Slide slide) {
    uint kept = 0;
    for (uint i = 0; i < count; ++i) {
        Question asked = pair_of(frame, base, edge_at(rounds[i])).asked;
        if (is_worth_it(asked, facet(asked.near))) rounds[kept++] = rounds[i];
    }
    for (uint i = 0; i < kept; ++i) {
        uint e = edge_at(rounds[i]);
        Pair pair = pair_of(frame, base, e);
        vec3 beyond = HAS_SKY != 0 ? gathered_value(pair.far + 1).rgb : vec3(0.0);
        vec3 bend = BY_HESSIAN != 0 ? pair.sense * edge_value(3 * e + 2).xyz : vec3(0.0);
        Ends ends = Ends(gathered_value(pair.near).rgb, gathered_value(pair.far).rgb, beyond, pair.step_, bend);
        correct(slide, pair.asked, facet(pair.asked.near), ends);
    }
}

// Outlines within a face that a subgroup sums (inc/outlines.glsl). `tell` marks in `keys` between which texels they are. They
// are listed, then sifted, for on a CPU invocations side by side all take the time of those that have something to do.

layout(set = 0, binding = 15) uniform textureBuffer across;  // numbers plus 1 (bits) of the triangles across the edges
                                                             // opposite to the corners; 0: none

#include "inc/outlines.glsl"
#include "inc/tree_facets.glsl"

vec3 facet_light(uint number, Facet f, vec3 eye, vec3 way) {
    return light_of(f.a, f.b, f.a.xyz - eye, f.b.xyz - f.a.xyz, f.c - f.a.xyz, way);
}

// What is kept of a texel in place of its key: the number of its triangle plus 1, whether there is an outline to the left and
// above, and whether what is nearer there is the texel before.
const uint LEFT = 1u << 31, ABOVE = 1u << 30, LEFT_IS_NEARER = 1u << 29, ABOVE_IS_NEARER = 1u << 28;
const uint NUMBER = ABOVE_IS_NEARER - 1, SKY = NUMBER;

// Marks of the edge between a texel and the one before it, if there is an outline; 1/depth of both planes there.
uint marks_of(Seen before, Seen now, vec2 planes, bool is_edge, uint outline, uint nearer) {
    if (!is_outline(planes) || !is_edge || max(before.light.w, now.light.w) <= 0.0) return 0;
    return before.light.w >= now.light.w ? outline | nearer : outline;
}

// Two neighbouring texels between which there is an outline: numbers of the triangles that they see, the nearer one first; what
// the table has of the edge; whether the nearer one comes first.
struct Pair { uint near, far; vec3 near_way, far_way; vec4 edge; vec3 bend; bool turned; };

// Texel `entry / 2` and the one before it, to the left or above.
Pair pair_of(uint entry, uint base) {
    uint i = entry / 2, is_up = entry % 2, j = i - (is_up != 0 ? SIZE : 1), now = keys[i], before = keys[j];
    bool turned = (now & (is_up != 0 ? ABOVE_IS_NEARER : LEFT_IS_NEARER)) != 0;
    vec3 way = spot_of(i).way, last = spot_of(j).way;
    int at = 4 * int(base + i);
    vec4 edge = texelFetch(texel_table, at + 1 + int(is_up)), bend = texelFetch(texel_table, at + 3);
    return Pair((turned ? before : now) & NUMBER, (turned ? now : before) & NUMBER, turned ? last : way,
                turned ? way : last, edge,
                vec3(edge.w, is_up != 0 ? bend.zw : bend.xy), turned);
}

Question question_of(View view, Pair pair, Facet f) {
    vec3 near_way = pair.near_way * view.axes, far_way = pair.far_way * view.axes, eye = view.frame.origin.xyz;
    vec3 plane = inverse_plane(f.a.xyz - eye, f.b.xyz - f.a.xyz, f.c - f.a.xyz);
    float nearest = dot(plane, near_way) * inversesqrt(dot(near_way, near_way));
    float plain = bounded(dot(plane, near_way + far_way) * 0.5 * pair.edge.z, nearest);
    return question(pair.near, pair.far, eye, near_way, far_way, nearest, plain);
}

bool is_worth_it(View view, uint entry, uint base) {
    Pair pair = pair_of(entry, base);
    Facet f = facet(pair.near);
    return is_worth_it(question_of(view, pair, f), f);
}

void correct(View view, uint entry, uint base, inout Slide slide) {
    Pair pair = pair_of(entry, base);
    Facet f = facet(pair.near);
    Ends ends = Ends(vec3(0.0), vec3(0.0), vec3(0.0), pair.turned ? pair.edge.xy : -pair.edge.xy,
                     pair.turned ? pair.bend : -pair.bend);
    vec3 plane;
    look(view, pair.near - 1, pair.near_way, ends.near, plane);
    bool is_surface = pair.far != 0 && pair.far != SKY;
    look(view, (is_surface ? pair.far : pair.near) - 1, pair.far_way, ends.far, plane);
    if (!is_surface) ends.far = vec3(0.0);
    if (HAS_SKY != 0 && pair.far == SKY) ends.beyond = sky_radiance(pair.far_way * view.axes);
    correct(slide, question_of(view, pair, f), f, ends);
}

// Lists marked neighbours from texel `i` on, as many as there is room for.
uint list_marked(uint texels, inout uint i) {
    uint me = gl_LocalInvocationID.x, listed = 0;
    for (; i < texels && listed <= LIST - 2 * THREADS; i += THREADS) {
        uint texel = keys[i + me];
        uvec2 left = places((texel & LEFT) != 0), above = places((texel & ABOVE) != 0);
        if ((texel & LEFT) != 0) list[listed + left.x] = 2 * (i + me);
        if ((texel & ABOVE) != 0) list[listed + left.y + above.x] = 2 * (i + me) + 1;
        listed += left.y + above.y;
    }
    meet();
    return listed;
}

void correct_outlines(View view, uint texels, uint base, inout Slide slide) {
    uint me = gl_LocalInvocationID.x, i = 0;
    meet();
    while (i < texels) {
        uint listed = list_marked(texels, i), kept = 0;
        for (uint at = 0; at < listed; at += THREADS) {
            uint entry = list[min(at + me, listed - 1)];
            bool worth = at + me < listed && is_worth_it(view, entry, base);
            uvec2 place = places(worth);
            if (worth) list[kept + place.x] = entry;
            kept += place.y;
        }
        meet();
        for (uint at = me; at < kept; at += THREADS) correct(view, list[at], base, slide);
        meet();
    }
}

// Integrates a face where it was rasterised. Of its texels nothing is written but what those at its border see, which meet
// texels of other faces there (glsl/integrate), and how far away what the sides see is, which tells what is hidden
// (glsl/splat). Texels pass row by row, as many side by side as there are invocations in the subgroup: what is to the left
// is the next invocation's, and what is above this one's own, some steps ago. Each invocation leaves its part of every sum.
#include "inc/sums.glsl"

layout(set = 0, binding = 4) uniform textureBuffer cell_radiance;  // two floats a texel, three a cell: to front and back
layout(set = 0, binding = 13, std430) coherent buffer Distances { uint inverse_distances[]; };  // of each texel, bits
layout(set = 0, binding = 14, std430) writeonly buffer Sums { float sums[]; };

vec3 cell_light(uint cell, bool front) {
    int at = 3 * int(cell) + (front ? 0 : 1);
    vec2 a = texelFetch(cell_radiance, at).xy, b = texelFetch(cell_radiance, at + 1).xy;
    return front ? vec3(a, b.x) : vec3(a.y, b);
}

// Triangles' numbers are kept in place of the distances meanwhile.
uint meanwhile(uint at) { return inverse_distances[at]; }

void keep(uint at, uint triangle) { inverse_distances[at] = triangle; }

uint triangle_at(uint i, uint key, uint first);

const uint FACES = 5;
const uint ROW = SIZE / THREADS;  // steps
const uint LONGEST_ROW = 8;  // MOST_STEPS in capture_compute.rs

struct Seen {
    vec4 light;   // of surfaces; w: 1/distance
    vec3 beyond;  // of the sky
    vec2 onward;  // its plane where it meets the edges to the right and below: 1/depth
};

// Of the texel before, in a row: the one that the previous invocation sees now, or the last one has just seen.
vec4 before(vec4 now, vec4 just) {
    uint me = gl_LocalInvocationID.x;
    return subgroupShuffle(me == THREADS - 1 ? just : now, (me + THREADS - 1) % THREADS);
}

Seen left_of(Seen now, Seen just) {
    vec4 light = before(now.light, just.light);
    vec4 rest = before(vec4(now.beyond, now.onward.x), vec4(just.beyond, just.onward.x));
    return Seen(light, rest.xyz, vec2(rest.w, 0.0));
}

// Over the edge from a texel before to this one; `edge` is its step and 1/distance of its middle.
void step_over(inout Slide slide, Seen before, Seen now, float onward, float back, vec3 edge, vec3 bend) {
    float nearest = max(before.light.w, now.light.w), at_edge = before.light.w >= now.light.w ? onward : back;
    vec3 lit = now.light.rgb - before.light.rgb, open = now.beyond - before.beyond;
    slide_over(slide, lit, open, edge.xy, bend, at_edge * edge.z, nearest);
}

// Parts of the integrals over texels.
struct Part { vec4 value; vec3 x, y, peak; };

void add(inout Part part, vec4 seen, vec3 weight) {
    part.value += weight.x * seen;
    part.x += weight.y * seen.rgb;
    part.y += weight.z * seen.rgb;
    part.peak = max(part.peak, seen.rgb);
}

void put(inout uint at, float value) {
    sums[at] = value;
    at += FACES * THREADS;
}

void put3(inout uint at, vec3 v) {
    put(at, v.x);
    put(at, v.y);
    put(at, v.z);
}

void put_part(inout uint at, Part part, vec3 slope_x, vec3 slope_y) {
    put3(at, part.value.rgb);
    put(at, part.value.w);
    put3(at, part.x);
    put3(at, part.y);
    put3(at, slope_x);
    put3(at, slope_y);
    put3(at, part.peak);
}

// Of the plane, from a texel's centre to its edges to the right and below.
vec2 to_edges(vec3 plane) { return vec2(plane.x, -plane.y) / float(SIZE); }

// Of a face's texels those at its border. They are looked at once more: some devices take as long to pass over a write as to
// do it, and most texels have none.
void leave_at_border(View view, uint first, uint record) {
    const uint upper = 4 * (SIZE - 1);
    uint of_side = (push.border_count - upper) / 4, from = view.face == 0 ? 0 : upper + (view.face - 1) * of_side;
    uint count = view.face == 0 ? upper : of_side;
    for (uint j = gl_LocalInvocationID.x; j < count; j += THREADS) {
        vec4 place = texelFetch(texel_table, int(4 * push.texel_count + from + j));  // in the face, among all at borders (bits)
        uint i = floatBitsToUint(place.x), at = STRIDE * (record * push.border_count + floatBitsToUint(place.y));
        uint key = keys[i];
        Sight sight = see(view, key, triangle_at(i, key, first), spot_of(i).way);
        gathered[at] = vec4(sight.light, sight.inverse_distance);
        if (HAS_SKY != 0) gathered[at + 1] = vec4(sight.beyond, 0.0);
        gathered[at + STRIDE - 1] = vec4(sight.plane * local_axes(view.face), 0.0);
    }
}

#include "capture_compute/outlines.glsl"

void tell(View view, uint texels, uint first) {
    Part lit = Part(vec4(0.0), vec3(0.0), vec3(0.0), vec3(0.0)), open = lit;
    Slide slide = no_slide();
    Seen nothing = Seen(vec4(0.0), vec3(0.0), vec2(0.0));
    Seen above[LONGEST_ROW] = Seen[LONGEST_ROW](nothing, nothing, nothing, nothing, nothing, nothing, nothing, nothing);
    uint me = gl_LocalInvocationID.x, record = first / push.texel_count, base = first % push.texel_count;
    if (HAS_TRANSLATION != 0) leave_at_border(view, first, record);
    meet();  // the triangles' numbers that it has read are overwritten from here on
    for (uint i = me; i < texels; i += THREADS) {
        uint key = keys[i];
        vec3 way = spot_of(i).way;
        uint triangle = triangle_at(i, key, first);
        Sight sight = see(view, key, triangle, way);
        float inverse_depth = dot(sight.plane, way);
        Seen now = Seen(vec4(sight.light, sight.inverse_distance), sight.beyond, inverse_depth + to_edges(sight.plane));
        if (view.face > 0) inverse_distances[first + i] = floatBitsToUint(now.light.w);
        // Values of src/vk/gpu_types.rs.
        int at = 4 * int(base + i);
        vec4 weight = texelFetch(texel_table, at);
        add(lit, now.light, weight.xyz);
        if (HAS_SKY != 0) add(open, vec4(now.beyond, 0.0), weight.xyz);
        if (HAS_TRANSLATION == 0) continue;
        vec4 to_left = texelFetch(texel_table, at + 1), up = texelFetch(texel_table, at + 2);
        vec4 bend = texelFetch(texel_table, at + 3);
        Seen left = left_of(now, above[0]), over = above[ROW - 1];
        vec2 back = inverse_depth - to_edges(sight.plane);
        if (HAS_OUTLINES != 0)
            keys[i] = (key == NOTHING ? SKY : triangle)
                | marks_of(left, now, vec2(left.onward.x, back.x), to_left.z > 0.0, LEFT, LEFT_IS_NEARER)
                | marks_of(over, now, vec2(over.onward.y, back.y), up.z > 0.0, ABOVE, ABOVE_IS_NEARER);
        step_over(slide, left, now, left.onward.x, back.x, to_left.xyz, vec3(to_left.w, bend.xy));
        step_over(slide, over, now, over.onward.y, back.y, up.xyz, vec3(up.w, bend.zw));
        // One by one, for what is indexed by a variable lies in memory.
        if (ROW > 7) above[7] = above[6];
        if (ROW > 6) above[6] = above[5];
        if (ROW > 5) above[5] = above[4];
        if (ROW > 4) above[4] = above[3];
        if (ROW > 3) above[3] = above[2];
        if (ROW > 2) above[2] = above[1];
        if (ROW > 1) above[1] = above[0];
        above[0] = now;
    }
    if (HAS_OUTLINES != 0) correct_outlines(view, texels, base, slide);
    uint to = FACES * THREADS * SUMS * record + THREADS * view.face + me;
    put_part(to, lit, slide.lit_x, slide.lit_y);
    if (HAS_SKY != 0) put_part(to, open, slide.open_x, slide.open_y);
    if (HAS_TRANSLATION == 0) return;
    put3(to, slide.xx);
    put3(to, slide.xy);
    put3(to, slide.yy);
}

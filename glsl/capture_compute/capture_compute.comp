// Views of a record rasterised in shared memory, after micro-rendering (Ritschel et al. 2009): no image is written, only
// the light that each texel sees. A view is a hemicube's face, or the hemisphere projected onto the disc below it. One
// workgroup a (record, view) lists the clusters of triangles that the view may see and draws them; each invocation takes
// one triangle of a cluster. Triangles are tested by the texels' directions, in homogeneous coordinates (Olano and Greer
// 1997): what crosses the face's plane needs no clipping, and no projection bends a side.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
const uint THREADS = 64;  // triangles of a cluster
layout(local_size_x = THREADS) in;

layout(constant_id = 0) const uint SIZE = 32;
layout(constant_id = 1) const uint HAS_MASKS = 0;
layout(constant_id = 2) const uint HAS_SKY = 0;
layout(constant_id = 3) const uint HAS_TRANSLATION = 1;  // planes are wanted
layout(constant_id = 4) const uint IS_DISC = 0;
layout(constant_id = 5) const uint HAS_LEVELS = 0;

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) readonly buffer Visible { uint visible[]; };  // a bit a cluster, by frame and face
layout(set = 0, binding = 2) uniform textureBuffer corners;  // three a triangle; w: the geometry's triangle; its mask
layout(set = 0, binding = 3) uniform textureBuffer masks;  // bits, 128 a texel
layout(set = 0, binding = 4, std430) readonly buffer FirstCell { uint first_cell[]; };
layout(set = 0, binding = 5, std430) readonly buffer CellRadiance { float cell_radiance[]; };
layout(set = 0, binding = 6, std430) readonly buffer Sky { uvec4 sky_size; vec4 sky[]; };
layout(set = 0, binding = 7, std430) buffer Gathered { vec4 gathered[]; };  // laid out as inc/gathered.glsl says
layout(set = 0, binding = 8) uniform textureBuffer disc;  // of each texel: its direction, its place in the square (bits)
layout(set = 0, binding = 9, std430) readonly buffer ShownCell { uint shown_cell[]; };  // of each coarse one
layout(push_constant) uniform Push {
    float nearest;  // smallest depth that is told from others
    uint word_count;
    uint texel_count;
    uint first_coarse_cell;
} push;

#include "inc/cells.glsl"
#include "inc/gathered.glsl"
#include "inc/sky.glsl"

const uint NOTHING = 0xffffffffu;
// A key is the logarithm of depth in the upper bits; then the entry of the triangle's cluster in the list, plus 1, and
// its place in the cluster. Entry 0 are triangles whose numbers `gathered` holds meanwhile: the list is used again and
// again, so that any number of triangles has a name.
const uint PLACE_BITS = 6, ENTRY_BITS = 11, ID_BITS = PLACE_BITS + ENTRY_BITS;
const uint WORDS = 63;  // of bits that are listed at once: fewer entries than names

shared uint keys[SIZE * SIZE];
shared uint list[WORDS * 32];
shared uint counts[THREADS];

// A face of a record's hemicube, or its disc, which looks as the first face does.
struct View { uint face; mat3 axes; Frame frame; uint first_word; };
// Corners, in face coordinates; of its alpha mask cells along a side, 0 without one, and the first texel.
struct Triangle { vec3 a, b, c; uvec2 mask; };
struct Box { ivec2 low, high; };    // texels, both ends included

// A face's right, up and forward as rows, local.
mat3 local_axes(uint face) {
    return mat3(face_coordinates(face, vec3(1.0, 0.0, 0.0)), face_coordinates(face, vec3(0.0, 1.0, 0.0)),
                face_coordinates(face, vec3(0.0, 0.0, 1.0)));
}

// In the world.
mat3 world_axes(uint face, Frame frame) {
    return local_axes(face) * transpose(mat3(frame.tangent.xyz, frame.bitangent.xyz, frame.normal.xyz));
}

vec3 place(View view, vec4 corner) { return view.axes * (corner.xyz - view.frame.origin.xyz); }

Triangle load(View view, uint triangle) {
    int at = int(3 * triangle);
    vec4 a = texelFetch(corners, at), b = texelFetch(corners, at + 1), c = texelFetch(corners, at + 2);
    return Triangle(place(view, a), place(view, b), place(view, c), floatBitsToUint(vec2(b.w, c.w)));
}

// The point of the face's plane at distance 1 in a texel's centre. Row 0 is at the top.
vec2 texel_centre(ivec2 at) { return ((vec2(at) + 0.5) * (2.0 / float(SIZE)) - 1.0) * vec2(1.0, -1.0); }

// Direction of a place in the square, in face coordinates: of length 1 on the disc, of depth 1 on a face.
vec3 direction_of(ivec2 at) {
    vec2 p = texel_centre(at);
    return vec3(p, IS_DISC != 0 ? sqrt(max(1.0 - dot(p, p), 0.0)) : 1.0);
}

// A texel's direction, and the place of its key. The disc has none outside.
struct Spot { vec3 way; uint key; };

Spot spot_of(uint i) {
    if (IS_DISC == 0) return Spot(direction_of(ivec2(i % SIZE, i / SIZE)), i);
    vec4 texel = texelFetch(disc, int(i));
    return Spot(texel.xyz, floatBitsToUint(texel.w));
}

// The face's own rows: above the horizon on the sides.
uint rows(uint face) { return face == 0 ? SIZE : SIZE / 2; }

Box whole(uint face) { return Box(ivec2(0), ivec2(SIZE, rows(face)) - 1); }

// Texels whose centres lie within [least, most] of the plane at distance 1, or a hair beyond: rounding must not lose one.
Box texels_within(uint face, vec2 least, vec2 most) {
    vec2 from = (vec2(least.x, -most.y) + 1.0) * (0.5 * float(SIZE)) - 0.501;
    vec2 to = (vec2(most.x, -least.y) + 1.0) * (0.5 * float(SIZE)) - 0.499;
    Box all = whole(face);
    return Box(max(all.low, ivec2(ceil(clamp(from, vec2(-1.0), vec2(float(SIZE)))))),
               min(all.high, ivec2(floor(clamp(to, vec2(-1.0), vec2(float(SIZE)))))));
}

// Depth to key: steps of equal ratio over the range that matters, by the float's own bits.
uint depth_key(float z) {
    uint bits = floatBitsToUint(max(z, push.nearest)) - floatBitsToUint(push.nearest);
    // 16 octaves of 2²³ steps: 27 bits.
    return min(bits, (1u << 27) - 1) >> (ID_BITS - 5);
}

bool outside(Triangle t, uint face) {
    vec3 x = vec3(t.a.x, t.b.x, t.c.x), y = vec3(t.a.y, t.b.y, t.c.y), z = vec3(t.a.z, t.b.z, t.c.z);
    if (IS_DISC != 0) return all(lessThanEqual(z, vec3(0.0)));
    bool below = face > 0 && all(lessThan(y, vec3(0.0)));
    return below || all(lessThanEqual(z, vec3(0.0))) || all(greaterThan(x, z)) || all(lessThan(x, -z))
        || all(greaterThan(y, z)) || all(lessThan(y, -z));
}

const float FAR = 1e30;

// Takes into the bounds of a triangle's image the corner `a`, if it lies ahead, and if the side from there to `b` passes the
// face's own plane, all that lies beyond on that side: the image goes on without end.
void include(vec3 a, vec3 b, inout vec2 least, inout vec2 most) {
    if (a.z > 0.0) {
        least = min(least, a.xy / a.z);
        most = max(most, a.xy / a.z);
    }
    if ((a.z > 0.0) != (b.z > 0.0)) {
        vec2 from = a.xy * abs(b.z), to = b.xy * abs(a.z), along = from + to, unsure = 1e-5 * (abs(from) + abs(to));
        least = mix(least, vec2(-FAR), lessThanEqual(along, unsure));
        most = mix(most, vec2(FAR), greaterThanEqual(along, -unsure));
    }
}

// On the sphere a triangle's points are those p of the flat one between the corners' directions, divided by |p|. None is
// nearer than the flat one's extent along a direction, so that p/|p| lies between p and p divided by that.
Box bounds_on_disc(Triangle t) {
    vec3 a = normalize(t.a), b = normalize(t.b), c = normalize(t.c), middle = normalize(a + b + c);
    float nearest = min(dot(middle, a), min(dot(middle, b), dot(middle, c)));
    if (!(nearest > 0.0)) return whole(0);
    vec2 least = min(a.xy, min(b.xy, c.xy)), most = max(a.xy, max(b.xy, c.xy));
    return texels_within(0, min(least, least / nearest), max(most, most / nearest));
}

Box bounds(Triangle t, uint face) {
    if (outside(t, face)) return Box(ivec2(0), ivec2(-1));
    if (IS_DISC != 0) return bounds_on_disc(t);
    vec2 least = vec2(FAR), most = vec2(-FAR);
    include(t.a, t.b, least, most);
    include(t.b, t.c, least, most);
    include(t.c, t.a, least, most);
    return texels_within(face, least, most);
}

// Columns where a triangle's sides cross the rows of texels, as a function of the row's height.
struct Sides { vec3 slope, offset; bvec3 is_left; };

// Of sides as signed volumes (x, y, z), positive within. With a grain to spare: what is within must not be lost.
Sides sides_of(vec3 x, vec3 y, vec3 z) {
    // A side along the rows bounds none of them.
    bvec3 is_bound = greaterThan(abs(x), 1e-6 * (abs(y) + abs(z)));
    vec3 inverse = -1.0 / mix(vec3(1.0), x, is_bound), slope = y * inverse, offset = z * inverse;
    bvec3 is_left = bvec3(x.x > 0.0, x.y > 0.0, x.z > 0.0);
    vec3 spare = 0.01 + 1e-6 * float(SIZE) * (abs(slope) + abs(offset));
    slope *= 0.5 * float(SIZE);
    offset = 0.5 * float(SIZE) * (offset + 1.0) - 0.5 + mix(spare, -spare, is_left);
    return Sides(mix(vec3(0.0), slope, is_bound), mix(mix(vec3(FAR), vec3(-FAR), is_left), offset, is_bound), is_left);
}

// First and last column of a box between the sides. On the disc these are arcs, and the box alone bounds a row.
ivec2 columns(Sides sides, Box box, float y) {
    if (IS_DISC != 0) return ivec2(box.low.x, box.high.x);
    vec3 at = sides.slope * y + sides.offset;
    vec3 left = mix(vec3(-FAR), at, sides.is_left), right = mix(at, vec3(FAR), sides.is_left);
    float from = max(left.x, max(left.y, left.z)), to = min(right.x, min(right.y, right.z));
    ivec2 between = ivec2(ceil(clamp(from, -1.0, float(SIZE))), floor(clamp(to, -1.0, float(SIZE))));
    return ivec2(max(box.low.x, between.x), min(box.high.x, between.y));
}

// Whether the surface is there at the point (1−u−v)·a + u·b + v·c.
bool is_present(uvec2 mask, vec2 uv) {
    uint cell = cell_at(max(mask.x, 1), uv);
    uvec4 bits = floatBitsToUint(texelFetch(masks, int(mask.y + cell / 128)));
    return mask.x == 0 || (bits[cell / 32 % 4] >> cell % 32 & 1) != 0;
}

// On which side of an edge a direction lies: exactly the negative for the edge in the other sense.
float side_of(vec3 edge, vec3 way) {
    precise float side = edge.x * way.x + edge.y * way.y + (IS_DISC != 0 ? edge.z * way.z : edge.z);
    return side;
}

// One loop over the rows and columns of a box, not one in another: side by side, invocations wait for the largest
// triangle alone.
void rasterise(Triangle t, Box box, uint id) {
    // Signed volumes of the direction with each edge; each is exactly the negative of its neighbour's.
    precise vec3 ea = cross(t.b, t.c), eb = cross(t.c, t.a), ec = cross(t.a, t.b);
    // What is seen from behind is turned: then sides are positive within, and what they bound lies ahead.
    float turn = sign(dot(t.a, ea)), volume = abs(dot(t.a, ea));
    ea *= turn;
    eb *= turn;
    ec *= turn;
    vec3 normal = ea + eb + ec;
    Sides sides = sides_of(vec3(ea.x, eb.x, ec.x), vec3(ea.y, eb.y, ec.y), vec3(ea.z, eb.z, ec.z));
    ivec2 at = ivec2(0, box.low.y - 1);
    int last = -1;  // column of the row
    if (box.low.x > box.high.x || volume == 0.0) box.high.y = -1;
    while (at.y < box.high.y || (at.y == box.high.y && at.x <= last)) {
        if (at.x > last) {
            ++at.y;
            ivec2 between = columns(sides, box, texel_centre(at).y);
            at.x = between.x;
            last = between.y;
        }
        vec3 way = direction_of(at), side = vec3(side_of(ea, way), side_of(eb, way), side_of(ec, way));
        float sum = dot(normal, way), z = volume / sum;
        bool drawn = at.x <= last && all(greaterThanEqual(side, vec3(0.0))) && sum > 0.0;
        if (HAS_MASKS != 0) drawn = drawn && is_present(t.mask, side.yz / sum);
        if (drawn) atomicMin(keys[at.y * int(SIZE) + at.x], (depth_key(z) << ID_BITS) | id);
        ++at.x;
    }
}

// Number of the triangle that a texel sees, plus 1; 0 for none.
uint triangle_at(uint i, uint key, uint first) {
    if (key == NOTHING) return 0;
    uint entry = (key >> PLACE_BITS) & ((1 << ENTRY_BITS) - 1), place = key & (THREADS - 1);
    return entry == 0 ? floatBitsToUint(gathered[STRIDE * (first + i)].x) : list[entry - 1] * THREADS + place + 1;
}

// Makes the list free: keeps what texels see so far in `gathered`.
void retire(uint texels, uint first) {
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        uint at = spot_of(i).key, key = keys[at];
        if (key == NOTHING) continue;
        gathered[STRIDE * (first + i)].x = uintBitsToFloat(triangle_at(i, key, first));
        keys[at] = key >> ID_BITS << ID_BITS;
    }
}

// Lists the clusters whose bits are set in WORDS words from `start` on; returns how many.
uint list_clusters(View view, uint start) {
    uint me = gl_LocalInvocationID.x;
    bool mine = me < WORDS && start + me < push.word_count;
    uint bits = mine ? visible[view.first_word + start + me] : 0;
    counts[me] = bitCount(bits);
    barrier();
    uint entry = 0, all = 0;
    for (uint i = 0; i < WORDS; ++i) {
        entry += i < me ? counts[i] : 0;
        all += counts[i];
    }
    for (; bits != 0; bits &= bits - 1) list[entry++] = 32 * (start + me) + findLSB(bits);
    barrier();
    return all;
}

void draw(View view, uint texels, uint first) {
    uint me = gl_LocalInvocationID.x;
    for (uint start = 0; start < push.word_count; start += WORDS) {
        if (start > 0) retire(texels, first);
        barrier();
        uint listed = list_clusters(view, start);
        for (uint entry = 0; entry < listed; ++entry) {
            uint triangle = list[entry] * THREADS + me;
            Triangle t = load(view, triangle);
            rasterise(t, bounds(t, view.face), (entry + 1) << PLACE_BITS | me);
        }
        barrier();
    }
}

void clear(View view, uint texels, uint first) {
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        Spot spot = spot_of(i);
        bool above = dot(spot.way * view.axes, view.frame.horizon.xyz) > 0.0;
        // Below the horizon nothing is nearer than the nothing that is there already.
        keys[spot.key] = above ? NOTHING : 0;
        if (!above) gathered[STRIDE * (first + i)].x = 0.0;
    }
}

void gather(View view, uint texels, uint first) {
    mat3 axes = local_axes(view.face);
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        Spot spot = spot_of(i);
        uint key = keys[spot.key], triangle = triangle_at(i, key, first), at = STRIDE * (first + i);
        vec3 way = normalize(spot.way), plane = vec3(0.0), beyond = vec3(0.0);
        vec4 seen = vec4(0.0);
        if (triangle != 0) {
            Triangle t = load(view, triangle - 1);
            vec3 e1 = t.b - t.a, e2 = t.c - t.a;
            plane = inverse_plane(t.a, e1, e2);
            // Faces are mirrored: what shows its front has a positive volume in the world and a negative one here.
            bool front = dot(t.a, cross(e1, e2)) < 0.0;
            uint name = floatBitsToUint(texelFetch(corners, int(3 * triangle - 3)).w);
            uint cell = cell_of(name, barycentrics(t.a, e1, e2, way));
            if (HAS_LEVELS != 0 && cell >= push.first_coarse_cell) cell = shown_cell[cell - push.first_coarse_cell];
            seen = vec4(cell_light(cell, front), max(dot(plane, way), 0.0));
        }
        if (HAS_SKY != 0) {
            if (key == NOTHING) beyond = sky_radiance(way * view.axes);
            gathered[at + 1] = vec4(beyond, 0.0);
        }
        gathered[at] = seen;
        if (HAS_TRANSLATION != 0) gathered[at + STRIDE - 1] = vec4(plane * axes, 0.0);
    }
}

void main() {
    uint views = IS_DISC != 0 ? 1 : 5, record = gl_WorkGroupID.x / views, face = gl_WorkGroupID.x % views;
    View view = View(face, world_axes(face, frames[record]), frames[record], (5 * record + face) * push.word_count);
    uint texels = IS_DISC != 0 ? push.texel_count : SIZE * rows(face);
    uint first = record * push.texel_count + (face == 0 ? 0 : SIZE * SIZE + (face - 1) * (SIZE * SIZE / 2));
    clear(view, texels, first);
    barrier();
    draw(view, texels, first);
    gather(view, texels, first);
}

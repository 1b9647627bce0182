// Views of a record rasterised in shared memory, after micro-rendering (Ritschel et al. 2009): no image is written, only
// the light that each texel sees, or, with SUMMING, the integrals over them. A view is a face of a hemicube or cube, or the hemisphere projected onto the disc below it. One
// workgroup a (record, view) walks the tree of the scene's triangles and draws those that the view sees, an invocation
// each. Triangles are tested by the texels' directions, in homogeneous coordinates (Olano and Greer 1997): what crosses the
// face's plane needs no clipping, and no projection bends a side.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
layout(local_size_x_id = 6) in;

layout(constant_id = 0) const uint SIZE = 32;
layout(constant_id = 1) const uint HAS_MASKS = 0;
layout(constant_id = 2) const uint HAS_SKY = 0;
layout(constant_id = 3) const uint HAS_TRANSLATION = 1;  // planes are wanted
layout(constant_id = 4) const uint IS_DISC = 0;
layout(constant_id = 5) const uint HAS_LEVELS = 0;
layout(constant_id = 6) const uint THREADS = 64;  // a multiple of the tree's children
layout(constant_id = 7) const uint COUNTS = 0;  // triangles that are drawn
layout(constant_id = 8) const uint MAY_END = 0;  // the device may end loops
layout(constant_id = 9) const uint HAS_SLICES = 0;  // for what is far
layout(constant_id = 10) const uint HAS_OUTLINES = 0;  // followed over the triangles' edges
layout(constant_id = 11) const uint VIEW_COUNT = 5;
layout(constant_id = 12) const uint SIDE_ROWS = 16;  // rows of texels of every view but the first

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1) uniform textureBuffer octets;  // boxes of triangles: low, high
layout(set = 0, binding = 2) uniform textureBuffer corners;  // three a triangle; w (bits): first surface cell;
                                                             // cells along a side of the mask, of the surface << 16; the mask
layout(set = 0, binding = 3) uniform textureBuffer masks;  // bits, 128 a texel
layout(set = 0, binding = 5, std430) readonly buffer Sky { uvec4 sky_size; vec4 sky[]; };
layout(set = 0, binding = 6, std430) buffer Gathered { vec4 gathered[]; };  // laid out as inc/gathered.glsl says
layout(set = 0, binding = 7) uniform textureBuffer texel_table;  // of a disc's texels, or those of faces that are summed
layout(set = 0, binding = 8, std430) readonly buffer ShownCell { uint shown_cell[]; };  // of each coarse one
layout(set = 0, binding = 9) uniform textureBuffer nodes;  // box; children, middle; a box for errors; least, most
layout(set = 0, binding = 10, std430) buffer Count { uint count[2]; };
layout(set = 0, binding = 11, std430) writeonly buffer Ended { uint ended[2]; };  // not 0 where loops were
layout(push_constant) uniform Push {
    vec4 sphere;  // around the scene: centre, radius
    float allowed_error;  // at distance 1
    uint texel_count;
    uint border_count;  // of them, at borders between faces
    uint first_coarse_cell;
    uint clusters;  // of the tree: its first nodes
    uint root;      // its children
    // Of slices: the grid; within which distance all is drawn as it is, the longest side of a voxel.
    float low[3];
    float per_length[3];  // voxels
    uint dims[3];
    float near;
    float voxel;
    float nearest;  // of what is told apart, from within the scene
} push;

#include "inc/cells.glsl"
#include "inc/count.glsl"
#include "inc/gathered.glsl"
#include "inc/mask.glsl"
#include "inc/sky.glsl"

const uint OCTET = 8;  // triangles that are drawn side by side; children of a node
const uint NOTHING = 0xffffffffu;
const uint BELOW = 1;  // the horizon: nearer than all that has a name, and no name itself
// A key is the logarithm of depth in the upper bits; then the entry of the triangle's octet in the list, plus 1, and
// its place in it. Entry 0 are triangles whose numbers are kept elsewhere meanwhile: the list is used again and again, so
// that any number of triangles has a name.
const uint PLACE_BITS = 3, ENTRY_BITS = 11, ID_BITS = PLACE_BITS + ENTRY_BITS, DEPTH_BITS = 32 - ID_BITS;

shared uint keys[SIZE * SIZE];

// The range of depths that are told apart.
struct Depths { float nearest, steps; };  // steps to a unit of a float's bits

// A face of a record's hemicube or cube, or its disc, which looks as the first face does.
struct View { uint face; mat3 axes; Frame frame; Depths depths; };
// Corners, in face coordinates; of its alpha mask cells along a side, 0 without one, and the first texel.
struct Triangle { vec3 a, b, c; uvec2 mask; };

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
    return Triangle(place(view, a), place(view, b), place(view, c), uvec2(floatBitsToUint(b.w) & 0xffffu, floatBitsToUint(c.w)));
}

// The point of the face's plane at distance 1 in a texel's centre. Row 0 is at the top.
vec2 texel_centre(vec2 at) { return ((at + 0.5) * (2.0 / float(SIZE)) - 1.0) * vec2(1.0, -1.0); }

// Direction of a place in the square, in face coordinates: of length 1 on the disc, of depth 1 on a face.
vec3 direction_of(vec2 at) {
    vec2 p = texel_centre(at);
    return vec3(p, IS_DISC != 0 ? sqrt(max(1.0 - dot(p, p), 0.0)) : 1.0);
}

// A texel's direction, and the place of its key. The disc has none outside.
struct Spot { vec3 way; uint key; };

Spot spot_of(uint i) {
    if (IS_DISC == 0) return Spot(direction_of(vec2(i % SIZE, i / SIZE)), i);
    vec4 texel = texelFetch(texel_table, int(i));  // direction, place in the square (bits)
    return Spot(texel.xyz, floatBitsToUint(texel.w));
}

#include "capture_compute/rasterise.glsl"
#include "capture_compute/walk.glsl"

vec3 cell_light(uint cell, bool front);

// Radiance of a triangle of texels p0 and p1 with the corners a, a + e1 and a + e2 from here, in a direction of any length.
vec3 light_of(vec4 p0, vec4 p1, vec3 a, vec3 e1, vec3 e2, vec3 direction) {
    uint cell = floatBitsToUint(p0.w) + cell_at(floatBitsToUint(p1.w) >> 16, barycentrics(a, e1, e2, direction));
    if (HAS_LEVELS != 0 && cell >= push.first_coarse_cell) cell = shown_cell[cell - push.first_coarse_cell];
    return cell_light(cell, dot(a, cross(e1, e2)) < 0.0);
}

// Radiance of a triangle in a direction of any length, and its plane; direction and plane in face coordinates. Whether its back is seen.
bool look(View view, uint triangle, vec3 way, out vec3 light, out vec3 plane) {
    int at = 3 * int(triangle);
    vec4 p0 = texelFetch(corners, at), p1 = texelFetch(corners, at + 1);
    vec3 a = p0.xyz - view.frame.origin.xyz, e1 = p1.xyz - p0.xyz, e2 = texelFetch(corners, at + 2).xyz - p0.xyz;
    plane = view.axes * inverse_plane(a, e1, e2);
    light = light_of(p0, p1, a, e1, e2, way * view.axes);
    return dot(a, cross(e1, e2)) >= 0.0;
}

#include "capture_compute/slices.glsl"

// What a texel sees, of the triangle's number plus 1.
Sight see(View view, uint key, uint triangle, vec3 way) {
    Sight sight = Sight(vec3(0.0), vec3(0.0), 0.0, vec3(0.0), false);
    if (triangle != 0) sight.back = look(view, triangle - 1, way, sight.light, sight.plane);
    if (HAS_SKY != 0 && key == NOTHING) sight.beyond = sky_radiance(way * view.axes);
    sight.inverse_distance = max(dot(sight.plane, way) * inversesqrt(dot(way, way)), 0.0);
    // Below the horizon there is nothing.
    if (HAS_SLICES != 0 && (triangle != 0 || key == NOTHING)) see_slices(view, way, triangle != 0, sight);
    return sight;
}

#ifdef SUMMING
#include "capture_compute/sum.glsl"
#else
#include "capture_compute/gather.glsl"
#endif

// Whether a texel sees no triangle.
bool sees_none(uint key) { return key == NOTHING || key == BELOW; }

// Number of the triangle that a texel sees, plus 1; 0 for none.
uint triangle_at(uint i, uint key, uint first) {
    if (sees_none(key)) return 0;
    uint id = key & ((1 << ID_BITS) - 1);
    return id < OCTET ? meanwhile(first + i) : triangle_of(id) + 1;
}

// Makes the list free: keeps what texels see so far.
void retire(uint texels, uint first) {
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        uint at = spot_of(i).key, key = keys[at];
        if (sees_none(key)) continue;
        keep(first + i, triangle_at(i, key, first));
        keys[at] = key >> ID_BITS << ID_BITS;
    }
}

void draw(View view, uint texels, uint first) {
    uint me = gl_LocalInvocationID.x;
    Walk walk = start();
    while (walk.depth > 0) {
        if (walk.listed > 0) retire(texels, first);
        walk.listed = 0;
        meet();
        while (walk.depth > 0 && walk.listed <= LIST - OCTET * CLUSTERS) {
            uint found = find_clusters(view, walk);
            list_octets(view, walk, found);
        }
        if (COUNTS != 0 && me == 0) add_to_count(OCTET * walk.listed);
        for (uint entry = me / OCTET; entry < walk.listed; entry += SIDE_BY_SIDE) {
            uint id = (entry + 1) << PLACE_BITS | me % OCTET;
            Triangle t = load(view, triangle_of(id));
            rasterise(t, bounds(t, view.face), view.depths, id);
        }
        meet();
    }
}

void clear(View view, uint texels) {
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        Spot spot = spot_of(i);
        bool above = is_above(view.frame, spot.way * view.axes);
        // Below the horizon nothing is nearer than the nothing that is there already.
        keys[spot.key] = above ? NOTHING : BELOW;
    }
}

// A device that ends loops after so many rounds of all of them (llvmpipe: 65,535) ends the next ones after their first. That
// this one has a second round no compiler may know.
void tell_ended() {
    uint rounds = 0;
    while (rounds < min(push.texel_count, 2)) ++rounds;
    if (rounds < 2) ended[0] = 1;
}

void main() {
    uint record = gl_WorkGroupID.x / VIEW_COUNT, face = gl_WorkGroupID.x % VIEW_COUNT;
    Frame frame = frames[record];
    View view = View(face, world_axes(face, frame), frame, depths_from(frame.origin.xyz));
    uint texels = IS_DISC != 0 ? push.texel_count : SIZE * rows(face);
    uint first = record * push.texel_count + (face == 0 ? 0 : SIZE * (SIZE + (face - 1) * SIDE_ROWS));
    clear(view, texels);
    meet();
    draw(view, texels, first);
    tell(view, texels, first);
    if (MAY_END != 0) tell_ended();
}

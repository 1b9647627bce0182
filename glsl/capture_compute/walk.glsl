// Finds what a view sees of the tree, from its root to octets of triangles. Wants `octets`, `nodes`, View, meet and places.

const uint LIST = 2016;                      // octets: fewer than names
const uint SIDE_BY_SIDE = THREADS / OCTET;   // nodes that the workgroup looks at at once
const uint STACK = 10 * OCTET * SIDE_BY_SIDE;
const uint CLUSTERS = 64 + THREADS;          // that are found before their octets are looked at
const uint NODE = HAS_LEVELS != 0 ? 4 : 2;   // texels of a node

shared uint list[LIST];          // octets
shared uint clusters[CLUSTERS];
shared uint stack[STACK];        // of a node its first child, times 8, and how many more it has

struct Walk { uint depth, listed; };  // of the stack, octets

Walk start() {
    if (gl_LocalInvocationID.x == 0) stack[0] = push.root;
    meet();
    return Walk(push.clusters > 0 ? 1 : 0, 0);
}

uint triangle_of(uint id) { return list[(id >> PLACE_BITS) - 1] * OCTET + id % OCTET; }

float distance_to(vec3 p, vec3 low, vec3 high) { return length(max(max(low - p, p - high), vec3(0.0))); }

// How far away the boxes are at most by which clusters decide: all are near to a point of the box of their node
// (src/passes/cluster_tree/nodes.rs).
float farthest_from(vec3 eye, vec3 low, vec3 size, uint middle) {
    vec3 point = low + size * (vec3(uvec3(middle, middle >> 8, middle >> 16) & 255u) / 255.0);
    return 1.0001 * (distance(eye, point) + length(size) * (float(middle >> 24) / 126.0));
}

// Whether a cluster is fine enough at this distance; of what holds clusters, whether some may be that, and what replaces
// them is not. A cluster's neighbours that are replaced with it decide by the same numbers.
bool is_shown(uint node, uint middle, vec3 eye) {
    vec4 low = texelFetch(nodes, int(NODE * node) + 2), high = texelFetch(nodes, int(NODE * node) + 3);
    precise float near = distance_to(eye, low.xyz, high.xyz), allowed = near * push.allowed_error;
    float farthest = farthest_from(eye, low.xyz, high.xyz - low.xyz, middle) * push.allowed_error;
    return node < push.clusters ? low.w <= allowed : low.w <= farthest && high.w > allowed;
}

// Whether the view sees a texel's centre within a box: not outside the face, below the horizon, or between centres.
bool sees(View view, vec3 low, vec3 high) {
    vec3 half_ = 0.5 * (high - low), centre = low + half_, c = view.axes * (centre - view.frame.origin.xyz);
    vec3 e = vec3(dot(abs(vec3(view.axes[0].x, view.axes[1].x, view.axes[2].x)), half_),
                  dot(abs(vec3(view.axes[0].y, view.axes[1].y, view.axes[2].y)), half_),
                  dot(abs(vec3(view.axes[0].z, view.axes[1].z, view.axes[2].z)), half_));
    vec4 horizon = view.frame.horizon;
    bool above = dot(horizon.xyz, centre) + horizon.w >= -dot(abs(horizon.xyz), half_);
    e += 1e-5 * (abs(c) + e);  // a grain more, for the rounding of what is drawn
    return above && (IS_DISC != 0 ? sees_on_disc(c, e) : sees_on_face(view.face, c - e, c + e));
}

// Goes on along the tree, depth first, until it is done or enough clusters are found; returns how many.
uint find_clusters(View view, inout Walk walk) {
    uint me = gl_LocalInvocationID.x, found = 0;
    while (walk.depth > 0 && found <= CLUSTERS - THREADS) {
        uint taken = min(walk.depth, SIDE_BY_SIDE);
        bool mine = me / OCTET < taken;
        uint children = stack[mine ? walk.depth - 1 - me / OCTET : 0];
        mine = mine && me % OCTET <= children % OCTET;
        uint node = children / OCTET + (mine ? me % OCTET : 0);
        vec4 low = texelFetch(nodes, int(NODE * node)), high = texelFetch(nodes, int(NODE * node) + 1);
        bool seen = mine && sees(view, low.xyz, high.xyz), is_cluster = node < push.clusters;
        if (HAS_SLICES != 0) seen = seen && distance_to(view.frame.origin.xyz, low.xyz, high.xyz) <= push.near;
        if (HAS_LEVELS != 0) seen = seen && is_shown(node, floatBitsToUint(high.w), view.frame.origin.xyz);
        meet();
        uvec2 leaves = places(seen && is_cluster), inner = places(seen && !is_cluster);
        if (seen && is_cluster) clusters[found + leaves.x] = node;
        if (seen && !is_cluster) stack[walk.depth - taken + inner.x] = floatBitsToUint(low.w);
        walk.depth += inner.y - taken;
        found += leaves.y;
        meet();
    }
    return found;
}

// Adds to the list what the view sees of the octets of the clusters found.
void list_octets(View view, inout Walk walk, uint found) {
    uint me = gl_LocalInvocationID.x;
    for (uint first = 0; first < found; first += SIDE_BY_SIDE) {
        uint place = first + me / OCTET, octet = clusters[min(place, found - 1)] * OCTET + me % OCTET;
        vec3 low = texelFetch(octets, int(2 * octet)).xyz, high = texelFetch(octets, int(2 * octet) + 1).xyz;
        bool seen = place < found && sees(view, low, high);
        if (HAS_SLICES != 0) seen = seen && distance_to(view.frame.origin.xyz, low, high) <= push.near;
        uvec2 at = places(seen);
        if (seen) list[walk.listed + at.x] = octet;
        walk.listed += at.y;
    }
    meet();
}

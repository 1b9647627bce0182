// Finds what a view sees of the tree, from its root to octets of triangles. Wants `boxes`, `errors`, View, meet and places.

const uint LIST = 2016;                      // octets: fewer than names
const uint SIDE_BY_SIDE = THREADS / OCTET;   // nodes that the workgroup looks at at once
const uint STACK = 10 * OCTET * SIDE_BY_SIDE;
const uint LEVEL_BITS = 4;

shared uint list[LIST];       // octets
shared uint stack[STACK];     // nodes: its number among those of its level, the level

struct Walk { uint depth, listed; };  // of the stack, octets

Walk start() {
    if (gl_LocalInvocationID.x == 0) stack[0] = push.levels - 1;
    meet();
    return Walk(push.levels > 1 ? 1 : 0, 0);
}

uint triangle_of(uint id) { return list[(id >> PLACE_BITS) - 1] * OCTET + id % OCTET; }

float distance_to(vec3 p, vec3 low, vec3 high) { return length(max(max(low - p, p - high), vec3(0.0))); }

// Whether a node is what is shown at this distance, or may hold that: fine enough itself, and what replaces it is not. A
// cluster's neighbours that are replaced with it decide by the same numbers.
bool is_shown(uint node, bool is_cluster, vec3 eye) {
    int at = 4 * int(node);
    vec4 own = texelFetch(errors, at + 1), low = texelFetch(errors, at + 2), coarser = texelFetch(errors, at + 3);
    precise float here = distance_to(eye, texelFetch(errors, at).xyz, own.xyz) * push.allowed_error;
    precise float near = distance_to(eye, low.xyz, coarser.xyz), there = near * push.allowed_error;
    float farthest = (near + length(coarser.xyz - low.xyz)) * push.allowed_error;
    return own.w <= (is_cluster ? here : farthest) && coarser.w > there;
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

// Goes on along the tree, depth first, until it is done or octets are listed up to an end, or as many more as there are
// invocations.
void list_octets(View view, inout Walk walk, uint end) {
    uint me = gl_LocalInvocationID.x;
    while (walk.depth > 0 && walk.listed < end) {
        uint taken = min(walk.depth, SIDE_BY_SIDE);
        bool mine = me / OCTET < taken;
        uint node = stack[mine ? walk.depth - 1 - me / OCTET : 0], level = node % (1 << LEVEL_BITS) - 1;
        uint child = (node >> LEVEL_BITS) * OCTET + me % OCTET, at = push.first[level] + child;
        mine = mine && at < push.first[level + 1];
        at = mine ? at : 0;
        bool seen = mine && sees(view, texelFetch(boxes, int(2 * at)).xyz, texelFetch(boxes, int(2 * at + 1)).xyz);
        if (HAS_LEVELS != 0) seen = seen && (level == 0 || is_shown(max(at, push.first[1]) - push.first[1], level == 1, view.frame.origin.xyz));
        meet();
        uvec2 octets = places(seen && level == 0), nodes = places(seen && level > 0);
        if (seen && level == 0) list[walk.listed + octets.x] = child;
        if (seen && level > 0) stack[walk.depth - taken + nodes.x] = child << LEVEL_BITS | level;
        walk.depth += nodes.y - taken;
        walk.listed += octets.y;
        meet();
    }
}

// Light at outlines: where what a texel sees ends before what its neighbour sees, further away.
//
// The plane of a surface tells where its outline is only if it is not seen edge-on: half a texel further, such a plane may be
// three times as far away. And a face that is seen so nearly edge-on that it passes between two texels' centres is seen by
// none: between the side T of a box and the wall W behind it there is the top S, thinner than a texel, which is as bright as
// it is. Then the step from L_T to L_S moves as the edge that T and S share, the one from L_S to L_W as the far edge of S.
//
// So what lies between the two directions is followed over the triangles' edges: the directions' plane leaves T at a point
// P_0 of an edge, the triangle across it, unless that turns away from the eye, at P_1, and so on, up to the outline at P_k.
// In place of (L_W − L_T)/r there is then, L_i being the light of the i-th triangle in the middle of what the plane meets,
//
//     Σ (L_{i+1} − L_i)/|P_i| = L_W/|P_k| − L_T/|P_0| + Σ_{i=1..k} L_i (1/|P_{i−1}| − 1/|P_i|),
//
// and for the second derivatives the same with squares of distances (inc/sums.glsl).
// What `tell` adds, by the plane of T, is corrected by the difference. It marks such neighbours in `keys`. They
// are listed, then sifted, for on a CPU invocations side by side all take the time of those that have something to do.
// CPU twin: math::outline.

layout(set = 0, binding = 15) uniform textureBuffer across;  // numbers plus 1 (bits) of the triangles across the edges
                                                             // opposite to the corners; 0: none

// Triangles that are followed at most, beyond the nearer one: a quad is two of them.
const uint STEPS = 3;
// Inverse distances that differ by a smaller share are the same: no more than that is wrong then.
const float SHARE = 0.2;

// What is kept of a texel in place of its key: the number of its triangle plus 1, whether there is an outline to the left and
// above, and whether what is nearer there is the texel before.
const uint LEFT = 1u << 31, ABOVE = 1u << 30, LEFT_IS_NEARER = 1u << 29, ABOVE_IS_NEARER = 1u << 28;
const uint NUMBER = ABOVE_IS_NEARER - 1, SKY = NUMBER;

// Marks of the edge between a texel and the one before it, if there is an outline; 1/depth of both planes there.
uint marks_of(Seen before, Seen now, vec2 planes, bool is_edge, uint outline, uint nearer) {
    bool is_outline = abs(planes.x - planes.y) > SHARE * max(planes.x, planes.y);
    if (!is_outline || !is_edge || max(before.light.w, now.light.w) <= 0.0) return 0;
    return before.light.w >= now.light.w ? outline | nearer : outline;
}

// The plane of two directions: its normal, the first direction, and across it in the plane.
struct Fan { vec3 normal, along, across; };

// Where a triangle leaves it: point; tangent of the angle from the first direction; what is across the edge, plus 1.
struct Leave { vec3 point; float turn; uint next; };

// Leaves by the edge from a to b, if that is further on.
void leave_by(inout Leave leave, Fan fan, vec3 a, vec3 b, float next, uint came) {
    float h = dot(fan.normal, a), k = dot(fan.normal, b);
    vec3 point = (a * k - b * h) / (k - h);
    float depth = dot(fan.along, point), turn = dot(fan.across, point) / depth;
    bool further = (h >= 0.0) != (k >= 0.0) && floatBitsToUint(next) != came && depth > 0.0 && turn > leave.turn;
    leave.point = further ? point : leave.point;
    leave.turn = further ? turn : leave.turn;
    leave.next = further ? floatBitsToUint(next) : leave.next;
}

// A triangle by its number plus 1.
struct Facet { vec4 a, b; vec3 c; };

Facet facet(uint number) {
    int at = 3 * int(number - 1);
    return Facet(texelFetch(corners, at), texelFetch(corners, at + 1), texelFetch(corners, at + 2).xyz);
}

Leave leave_from(Facet f, uint number, vec3 eye, Fan fan, uint came, Leave leave) {
    vec3 a = f.a.xyz - eye, b = f.b.xyz - eye, c = f.c - eye, next = texelFetch(across, int(number - 1)).xyz;
    leave_by(leave, fan, b, c, next.x, came);
    leave_by(leave, fan, c, a, next.y, came);
    leave_by(leave, fan, a, b, next.z, came);
    return leave;
}

// Two neighbouring texels between which there is an outline: numbers of the triangles that they see, the nearer one first; what
// the table has of the edge; whether the nearer one comes first.
struct Pair { uint near, far; vec3 near_way, far_way; vec4 edge; vec3 bend; bool turned; };

// Texel `entry / 2` and the one before it, to the left or above.
Pair pair_of(View view, uint entry, uint base) {
    uint i = entry / 2, is_up = entry % 2, j = i - (is_up != 0 ? SIZE : 1), now = keys[i], before = keys[j];
    bool turned = (now & (is_up != 0 ? ABOVE_IS_NEARER : LEFT_IS_NEARER)) != 0;
    vec3 way = spot_of(i).way, last = spot_of(j).way;
    int at = 4 * int(base + i);
    vec4 edge = texelFetch(texel_table, at + 1 + int(is_up)), bend = texelFetch(texel_table, at + 3);
    return Pair((turned ? before : now) & NUMBER, (turned ? now : before) & NUMBER, turned ? last : way,
                turned ? way : last, edge,
                vec3(edge.w, is_up != 0 ? bend.zw : bend.xy), turned);
}

// What is asked of it: 1/distance of the nearer texel, and by the plane alone at the edge; the plane of both directions, and how
// far the second is turned.
struct Question { float nearest, plain; Fan fan; float turn; };

Question question(View view, Pair pair, Facet f) {
    vec3 near_way = pair.near_way * view.axes, far_way = pair.far_way * view.axes;
    vec3 plane = inverse_plane(f.a.xyz - view.frame.origin.xyz, f.b.xyz - f.a.xyz, f.c - f.a.xyz);
    float nearest = dot(plane, near_way) * inversesqrt(dot(near_way, near_way));
    float plain = clamp(dot(plane, near_way + far_way) * 0.5 * pair.edge.z, -nearest, 3.0 * nearest);
    vec3 n = cross(near_way, far_way), across_ = cross(n, near_way);
    // Tangents are off by a factor, for the directions have any length: all alike.
    return Question(nearest, plain, Fan(n, near_way, across_), dot(across_, far_way) / dot(near_way, far_way));
}

// As much as `slide_over` takes at most.
float closeness(Leave leave, Question asked) {
    return min(inversesqrt(dot(leave.point, leave.point)), 3.0 * asked.nearest);
}

Leave first_leave(uint number, Facet f, vec3 eye, Question asked) {
    return leave_from(f, number, eye, asked.fan, NOTHING, Leave(vec3(1.0), -FAR, 0));
}

// Whether there is more to it than the nearer triangle's plane tells: the outline is not where that meets the edge, or another
// triangle lies between.
bool is_worth_it(View view, uint entry, uint base) {
    Pair pair = pair_of(view, entry, base);
    vec3 eye = view.frame.origin.xyz;
    Facet f = facet(pair.near);
    Question asked = question(view, pair, f);
    Leave leave = first_leave(pair.near, f, eye, asked);
    bool differs = abs(closeness(leave, asked) - asked.plain) > SHARE * asked.nearest;
    bool has_next = leave.next != 0 && leave.next != pair.far;
    uint number = has_next ? leave.next : pair.near;
    Leave next = leave_from(facet(number), number, eye, asked.fan, pair.near, leave);
    bool goes_on = has_next && next.turn > leave.turn;
    return leave.turn > -FAR && leave.turn <= asked.turn && (differs || goes_on);
}

// Adds the difference.
void correct(View view, uint entry, uint base, inout Slide slide) {
    Pair pair = pair_of(view, entry, base);
    vec3 eye = view.frame.origin.xyz;
    Facet f = facet(pair.near);
    Question asked = question(view, pair, f);
    Leave leave = first_leave(pair.near, f, eye, asked);
    uint came = pair.near;
    float first = closeness(leave, asked), last = first;
    bool found = true, going = true;
    vec3 between = vec3(0.0), bent = vec3(0.0);  // by 1/distance, and by its square
    for (uint i = 0; i < STEPS && going; ++i) {
        uint number = leave.next;
        going = number != 0 && number != pair.far;
        Facet s = facet(going ? number : pair.near);
        Leave next = leave_from(s, going ? number : pair.near, eye, asked.fan, came, leave);
        going = going && next.turn > leave.turn;
        found = found && !(going && next.turn > asked.turn);  // what the other texel would see
        vec3 light = light_of(s.a, s.b, s.a.xyz - eye, s.b.xyz - s.a.xyz, s.c - s.a.xyz, leave.point + next.point);
        float then = closeness(next, asked);
        if (going) {
            between += light * (last - then);
            bent += light * (last * last - then * then);
            last = then;
            came = number;
            leave = next;
        }
    }
    vec3 near_light, far_light, plane;
    look(view, pair.near - 1, pair.near_way, near_light, plane);
    bool is_surface = pair.far != 0 && pair.far != SKY;
    look(view, (is_surface ? pair.far : pair.near) - 1, pair.far_way, far_light, plane);
    if (!is_surface) far_light = vec3(0.0);
    vec2 step_ = found ? (pair.turned ? pair.edge.xy : -pair.edge.xy) : vec2(0.0);
    vec3 lit = far_light * (last - asked.plain) - near_light * (first - asked.plain) + between;
    slide.lit_x += lit * step_.x;
    slide.lit_y += lit * step_.y;
    if (HAS_SKY != 0 && pair.far == SKY) {
        vec3 beyond = sky_radiance(pair.far_way * view.axes), open = beyond * (last - asked.plain);
        slide.open_x += open * step_.x;
        slide.open_y += open * step_.y;
        far_light += beyond;
    }
    float square = asked.nearest * asked.nearest;
    bent += far_light * (last * last - square) - near_light * (first * first - square);
    bent *= found ? (pair.turned ? 1.0 : -1.0) : 0.0;
    slide.xx += bent * pair.bend.x;
    slide.xy += bent * pair.bend.y;
    slide.yy += bent * pair.bend.z;
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

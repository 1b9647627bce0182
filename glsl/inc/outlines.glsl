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
// What `slide_over` adds, by the plane of T, is corrected by the difference. Wants inc/sums.glsl. CPU twin: math::outline.

// Triangles that are followed at most, beyond the nearer one: a quad is two of them.
const uint STEPS = 3;
// Inverse distances that differ by a smaller share are the same: no more than that is wrong then.
const float SHARE = 0.2;
// Came from no triangle; further back than any tangent.
const uint NOWHERE = 0xffffffffu;
const float BACK = -1e30;

// A triangle; w: what its light takes, where something does.
struct Facet { vec4 a, b; vec3 c; };

// Of who includes this: a triangle by its number plus 1; numbers plus 1 of those across the edges opposite to its corners, 0
// for none; its light in a direction of any length.
Facet facet(uint number);
uvec3 across_of(uint number);
vec3 facet_light(uint number, Facet f, vec3 eye, vec3 way);

// Whether there is an outline where two planes are as near as this: 1/distance, in one measure.
bool is_outline(vec2 planes) { return abs(planes.x - planes.y) > SHARE * max(planes.x, planes.y); }

// The plane of two directions: its normal, the first direction, and across it in the plane.
struct Fan { vec3 normal, along, across; };

// Where a triangle leaves it: point; tangent of the angle from the first direction; what is across the edge, plus 1.
struct Leave { vec3 point; float turn; uint next; };

// Leaves by the edge from a to b, if that is further on.
void leave_by(inout Leave leave, Fan fan, vec3 a, vec3 b, uint next, uint came) {
    float h = dot(fan.normal, a), k = dot(fan.normal, b);
    vec3 point = (a * k - b * h) / (k - h);
    float depth = dot(fan.along, point), turn = dot(fan.across, point) / depth;
    bool further = (h >= 0.0) != (k >= 0.0) && next != came && depth > 0.0 && turn > leave.turn;
    leave.point = further ? point : leave.point;
    leave.turn = further ? turn : leave.turn;
    leave.next = further ? next : leave.next;
}

Leave leave_from(Facet f, uint number, vec3 eye, Fan fan, uint came, Leave leave) {
    vec3 a = f.a.xyz - eye, b = f.b.xyz - eye, c = f.c - eye;
    uvec3 next = across_of(number);
    leave_by(leave, fan, b, c, next.x, came);
    leave_by(leave, fan, c, a, next.y, came);
    leave_by(leave, fan, a, b, next.z, came);
    return leave;
}

// What is asked of two neighbouring directions between which there is an outline: numbers plus 1 of the triangles that they
// see, the nearer one first; 1/distance of that, and by its plane alone at the edge; the plane of both directions, and how
// far the second is turned.
struct Question { uint near, far; vec3 eye; float nearest, plain; Fan fan; float turn; };

// Directions have any length.
Question question(uint near, uint far, vec3 eye, vec3 near_way, vec3 far_way, float nearest, float plain) {
    vec3 n = cross(near_way, far_way), across_ = cross(n, near_way);
    // Tangents are off by a factor: all alike.
    float turn = dot(across_, far_way) / dot(near_way, far_way);
    return Question(near, far, eye, nearest, plain, Fan(n, near_way, across_), turn);
}

// As much as `slide_over` takes at most.
float closeness(Leave leave, Question asked) {
    return min(inversesqrt(dot(leave.point, leave.point)), 3.0 * asked.nearest);
}

Leave first_leave(Question asked, Facet f) {
    return leave_from(f, asked.near, asked.eye, asked.fan, NOWHERE, Leave(vec3(1.0), BACK, 0));
}

// Whether there is more to it than the plane of the nearer triangle f tells: the outline is not where that meets the edge, or
// another triangle lies between.
bool is_worth_it(Question asked, Facet f) {
    Leave leave = first_leave(asked, f);
    bool differs = abs(closeness(leave, asked) - asked.plain) > SHARE * asked.nearest;
    bool has_next = leave.next != 0 && leave.next != asked.far;
    uint number = has_next ? leave.next : asked.near;
    Leave next = leave_from(facet(number), number, asked.eye, asked.fan, asked.near, leave);
    bool goes_on = has_next && next.turn > leave.turn;
    return leave.turn > BACK && leave.turn <= asked.turn && (differs || goes_on);
}

// Light of what is seen in both directions, of the sky in the second; step and bend of the edge, from the first to the second.
struct Ends { vec3 near, far, beyond; vec2 step_; vec3 bend; };

// Adds the difference; f is the nearer triangle.
void correct(inout Slide slide, Question asked, Facet f, Ends ends) {
    Leave leave = first_leave(asked, f);
    uint came = asked.near;
    float first = closeness(leave, asked), last = first;
    bool found = true, going = true;
    vec3 between = vec3(0.0), bent = vec3(0.0);  // by 1/distance, and by its square
    for (uint i = 0; i < STEPS && going; ++i) {
        going = leave.next != 0 && leave.next != asked.far;
        uint number = going ? leave.next : asked.near;
        Facet s = facet(number);
        Leave next = leave_from(s, number, asked.eye, asked.fan, came, leave);
        going = going && next.turn > leave.turn;
        found = found && !(going && next.turn > asked.turn);  // what the other texel would see
        vec3 light = facet_light(number, s, asked.eye, leave.point + next.point);
        float then = closeness(next, asked);
        if (going) {
            between += light * (last - then);
            bent += light * (last * last - then * then);
            last = then;
            came = number;
            leave = next;
        }
    }
    if (!found) return;
    vec3 lit = ends.far * (last - asked.plain) - ends.near * (first - asked.plain) + between;
    slide.lit_x += lit * ends.step_.x;
    slide.lit_y += lit * ends.step_.y;
    vec3 far = ends.far;
    if (HAS_SKY != 0) {
        vec3 open = ends.beyond * (last - asked.plain);
        slide.open_x += open * ends.step_.x;
        slide.open_y += open * ends.step_.y;
        far += ends.beyond;
    }
    float square = asked.nearest * asked.nearest;
    bent += far * (last * last - square) - ends.near * (first * first - square);
    slide.xx += bent * ends.bend.x;
    slide.xy += bent * ends.bend.y;
    slide.yy += bent * ends.bend.z;
}

// Draws a triangle: row by row of texels between its sides. Wants `keys`, `masks`, Depths and Push.sphere.

struct Texels { ivec2 low, high; };  // both ends included

const Texels NO_TEXELS = Texels(ivec2(0), ivec2(-1));

bool is_empty(Texels texels) { return any(greaterThan(texels.low, texels.high)); }

// The face's own rows: above the horizon on the sides.
uint rows(uint face) { return face == 0 ? SIZE : SIZE / 2; }

Texels whole(uint face) { return Texels(ivec2(0), ivec2(SIZE, rows(face)) - 1); }

// Texels whose centres lie within [least, most] of the plane at distance 1, or a hair beyond: rounding must not lose one.
Texels texels_within(uint face, vec2 least, vec2 most) {
    vec2 from = (vec2(least.x, -most.y) + 1.0) * (0.5 * float(SIZE)) - 0.501;
    vec2 to = (vec2(most.x, -least.y) + 1.0) * (0.5 * float(SIZE)) - 0.499;
    Texels all = whole(face);
    return Texels(max(all.low, ivec2(ceil(clamp(from, vec2(-1.0), vec2(float(SIZE)))))),
                  min(all.high, ivec2(floor(clamp(to, vec2(-1.0), vec2(float(SIZE)))))));
}

// Whether texels of a face may see a box from the frame's origin. Face coordinates.
bool sees_on_face(uint face, vec3 low, vec3 high) {
    bool ahead = high.z > 0.0 && low.x <= high.z && -high.x <= high.z && low.y <= high.z
        && -high.y <= (face == 0 ? high.z : 0.0);
    // Bounds of the box's image, where it lies ahead as a whole: on a face of width 2.
    vec2 least = low.xy / mix(vec2(high.z), vec2(low.z), lessThan(low.xy, vec2(0.0)));
    vec2 most = high.xy / mix(vec2(high.z), vec2(low.z), greaterThan(high.xy, vec2(0.0)));
    return ahead && (low.z <= 0.0 || !is_empty(texels_within(face, least, most)));
}

// Likewise texels of the disc: within a cap around the box's sphere.
bool sees_on_disc(vec3 middle, vec3 extent) {
    float distance_ = length(middle), sine = length(extent) / distance_;
    vec2 centre = middle.xy / distance_;
    float cosine = sqrt(max(1.0 - sine * sine, 0.0));
    vec2 reach = sqrt(max(1.0 - centre * centre, 0.0)) * sine, least = cosine * centre - reach, most = cosine * centre + reach;
    least = mix(least, vec2(-1.0), lessThan(centre, vec2(-cosine)));
    most = mix(most, vec2(1.0), greaterThan(centre, vec2(cosine)));
    return !(sine < 1.0) || (middle.z + extent.z > 0.0 && !is_empty(texels_within(0, least, most)));
}

const float NEAREST = 1.0 / float(1 << 18);  // relative to the scene's radius

// All that may be seen from a point, but from within the scene no nearer than what records are lifted by.
Depths depths_from(vec3 eye) {
    float away = distance(eye, push.sphere.xyz), radius = push.sphere.w;
    float nearest = max(0.5 * (away - radius), radius * NEAREST), farthest = 1.001 * (away + radius);
    return Depths(nearest, float((1u << DEPTH_BITS) - 1) / float(floatBitsToUint(farthest) - floatBitsToUint(nearest)));
}

// Depth to key: steps of equal ratio, within two, by the float's own bits.
uint depth_key(float z, Depths depths) {
    float bits = float(floatBitsToUint(max(z, depths.nearest)) - floatBitsToUint(depths.nearest));
    return uint(min(bits * depths.steps, float((1u << DEPTH_BITS) - 1)));
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
Texels bounds_on_disc(Triangle t) {
    vec3 a = normalize(t.a), b = normalize(t.b), c = normalize(t.c), middle = normalize(a + b + c);
    float nearest = min(dot(middle, a), min(dot(middle, b), dot(middle, c)));
    if (!(nearest > 0.0)) return whole(0);
    vec2 least = min(a.xy, min(b.xy, c.xy)), most = max(a.xy, max(b.xy, c.xy));
    return texels_within(0, min(least, least / nearest), max(most, most / nearest));
}

Texels bounds(Triangle t, uint face) {
    if (outside(t, face)) return NO_TEXELS;
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

// First and last column between the sides. On the disc these are arcs, and nothing but the bounds bounds a row.
ivec2 columns(Sides sides, Texels within, float y) {
    if (IS_DISC != 0) return ivec2(within.low.x, within.high.x);
    vec3 at = sides.slope * y + sides.offset;
    vec3 left = mix(vec3(-FAR), at, sides.is_left), right = mix(at, vec3(FAR), sides.is_left);
    float from = max(left.x, max(left.y, left.z)), to = min(right.x, min(right.y, right.z));
    ivec2 between = ivec2(ceil(clamp(from, -1.0, float(SIZE))), floor(clamp(to, -1.0, float(SIZE))));
    return ivec2(max(within.low.x, between.x), min(within.high.x, between.y));
}

// On which side of an edge a direction lies: exactly the negative for the edge in the other sense.
float side_of(vec3 edge, vec3 way) {
    precise float side = edge.x * way.x + edge.y * way.y + (IS_DISC != 0 ? edge.z * way.z : edge.z);
    return side;
}

// One loop over the rows and columns of the bounds, not one in another: side by side, invocations wait for the largest
// triangle alone.
void rasterise(Triangle t, Texels within, Depths depths, uint id) {
    // Signed volumes of the direction with each edge; each is exactly the negative of its neighbour's.
    precise vec3 ea = cross(t.b, t.c), eb = cross(t.c, t.a), ec = cross(t.a, t.b);
    // What is seen from behind is turned: then sides are positive within, and what they bound lies ahead.
    float turn = sign(dot(t.a, ea)), volume = abs(dot(t.a, ea));
    ea *= turn;
    eb *= turn;
    ec *= turn;
    vec3 normal = ea + eb + ec;
    Sides sides = sides_of(vec3(ea.x, eb.x, ec.x), vec3(ea.y, eb.y, ec.y), vec3(ea.z, eb.z, ec.z));
    ivec2 at = ivec2(0, within.low.y - 1);
    int last = -1;  // column of the row
    if (is_empty(within) || volume == 0.0) within.high.y = -1;
    while (at.y < within.high.y || (at.y == within.high.y && at.x <= last)) {
        if (at.x > last) {
            ++at.y;
            ivec2 between = columns(sides, within, texel_centre(at).y);
            at.x = between.x;
            last = between.y;
        }
        vec3 way = direction_of(at), side = vec3(side_of(ea, way), side_of(eb, way), side_of(ec, way));
        float sum = dot(normal, way), z = volume / sum;
        bool drawn = at.x <= last && all(greaterThanEqual(side, vec3(0.0))) && sum > 0.0;
        if (HAS_MASKS != 0) drawn = drawn && is_present(t.mask, side.yz / sum);
        if (drawn) atomicMin(keys[at.y * int(SIZE) + at.x], (depth_key(z, depths) << ID_BITS) | id);
        ++at.x;
    }
}


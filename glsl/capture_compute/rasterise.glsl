// Draws a triangle: row by row of texels between its sides. Wants `keys`, `masks`, Depths and Push.sphere.

struct Texels { vec2 low, high; };  // whole numbers, both ends included; none where low is beyond high

bool is_empty(Texels texels) { return any(greaterThan(texels.low, texels.high)); }

// The face's own rows: of a hemicube's sides those above the horizon.
uint rows(uint face) { return face == 0 ? SIZE : SIDE_ROWS; }

Texels whole(uint face) { return Texels(vec2(0.0), vec2(SIZE, rows(face)) - 1.0); }

// Texels whose centres lie within [least, most] of the plane at distance 1, or a hair beyond: rounding must not lose one.
Texels texels_within(uint face, vec2 least, vec2 most) {
    vec2 from = (vec2(least.x, -most.y) + 1.0) * (0.5 * float(SIZE)) - 0.501;
    vec2 to = (vec2(most.x, -least.y) + 1.0) * (0.5 * float(SIZE)) - 0.499;
    Texels all = whole(face);
    return Texels(max(all.low, ceil(from)), min(all.high, floor(to)));
}

// Whether texels of a face may see a box from the frame's origin. Face coordinates.
bool sees_on_face(uint face, vec3 low, vec3 high) {
    bool ahead = high.z > 0.0 && low.x <= high.z && -high.x <= high.z && low.y <= high.z
        && -high.y <= (rows(face) == SIZE ? high.z : 0.0);
    // Bounds of the box's image, where it lies ahead as a whole: on a face of width 2.
    vec2 inverse = 1.0 / vec2(low.z, high.z);
    vec2 least = low.xy * mix(inverse.yy, inverse.xx, lessThan(low.xy, vec2(0.0)));
    vec2 most = high.xy * mix(inverse.yy, inverse.xx, greaterThan(high.xy, vec2(0.0)));
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

// All that may be seen from a point, but from within the scene no nearer than what records are lifted by.
Depths depths_from(vec3 eye) {
    float away = distance(eye, push.sphere.xyz), radius = push.sphere.w;
    float nearest = max(0.5 * (away - radius), push.nearest), farthest = 1.001 * (away + radius);
    return Depths(nearest, float((1u << DEPTH_BITS) - 1) / float(floatBitsToUint(farthest) - floatBitsToUint(nearest)));
}

// Depth to key: steps of equal ratio, within two, by the float's own bits.
uint depth_key(float z, Depths depths) {
    float bits = float(floatBitsToUint(max(z, depths.nearest)) - floatBitsToUint(depths.nearest));
    return uint(min(bits * depths.steps, float((1u << DEPTH_BITS) - 1)));
}

const float FAR = 1e30;

// On the sphere a triangle's points are those p of the flat one between the corners' directions, divided by |p|. None is
// nearer than the flat one's extent along a direction, so that p/|p| lies between p and p divided by that.
Texels bounds_on_disc(Triangle t) {
    vec3 a = normalize(t.a), b = normalize(t.b), c = normalize(t.c), middle = normalize(a + b + c);
    float nearest = min(dot(middle, a), min(dot(middle, b), dot(middle, c)));
    if (!(nearest > 0.0)) return whole(0);
    vec2 least = min(a.xy, min(b.xy, c.xy)), most = max(a.xy, max(b.xy, c.xy));
    return texels_within(0, min(least, least / nearest), max(most, most / nearest));
}

float least_of(vec3 v) { return min(v.x, min(v.y, v.z)); }

float most_of(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Of a coordinate over the corners, the range of its ratios to z. Where the face's own plane cuts the triangle the image goes
// on without end, to either side that the triangle has corners on.
vec2 range(vec3 x, vec3 inverse_z, bvec3 ahead, bool is_cut) {
    vec3 at = x * inverse_z;
    float least = least_of(mix(vec3(FAR), at, ahead)), most = most_of(mix(vec3(-FAR), at, ahead));
    return vec2(is_cut && least_of(x) < 0.0 ? -FAR : least, is_cut && most_of(x) > 0.0 ? FAR : most);
}

Texels bounds(Triangle t, uint face) {
    if (IS_DISC != 0) return bounds_on_disc(t);
    vec3 z = vec3(t.a.z, t.b.z, t.c.z), inverse = 1.0 / z;
    bvec3 ahead = greaterThan(z, vec3(0.0));
    bool is_cut = any(ahead) && !all(ahead);
    vec2 x = range(vec3(t.a.x, t.b.x, t.c.x), inverse, ahead, is_cut);
    vec2 y = range(vec3(t.a.y, t.b.y, t.c.y), inverse, ahead, is_cut);
    return texels_within(face, vec2(x.x, y.x), vec2(x.y, y.y));
}

// Columns where a triangle's sides cross the rows of texels, as a function of the row's height.
struct Sides { vec3 slope, offset; bvec3 is_left; };

// Of sides as signed volumes (x, y, z), positive within. With a grain to spare: what is within must not be lost.
Sides sides_of(vec3 x, vec3 y, vec3 z) {
    bvec3 is_left = greaterThan(x, vec3(0.0));
    vec3 size = max(abs(x), 1e-6 * (abs(y) + abs(z))), inverse = (-0.5 * float(SIZE)) / mix(-size, size, is_left);
    vec3 slope = y * inverse, offset = z * inverse, spare = 0.01 + 2e-6 * (abs(slope) + abs(offset));
    return Sides(slope, offset + (0.5 * float(SIZE) - 0.5) + mix(spare, -spare, is_left), is_left);
}

// First and last column between the sides. On the disc these are arcs, and nothing but the bounds bounds a row.
vec2 columns(Sides sides, Texels within, float y) {
    if (IS_DISC != 0) return vec2(within.low.x, within.high.x);
    vec3 at = sides.slope * y + sides.offset;
    vec3 left = mix(vec3(-FAR), at, sides.is_left), right = mix(at, vec3(FAR), sides.is_left);
    return vec2(max(within.low.x, ceil(most_of(left))), min(within.high.x, floor(least_of(right))));
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
    Sides sides = sides_of(vec3(ea.x, eb.x, ec.x), vec3(ea.y, eb.y, ec.y), vec3(ea.z, eb.z, ec.z));
    vec2 at = vec2(0.0, within.low.y - 1.0);
    float last = -1.0;  // column of the row
    // Bounds that are no numbers are none: of triangles without extent, on devices that hand such numbers on.
    if (!all(lessThanEqual(within.low, within.high)) || !(volume > 0.0)) within.high.y = -1.0;
    while (at.y < within.high.y || (at.y == within.high.y && at.x <= last)) {
        // No number, which sides without length may give, ends its row: the loop comes to an end.
        if (!(at.x <= last)) {
            ++at.y;
            vec2 between = columns(sides, within, texel_centre(at).y);
            at.x = between.x;
            last = between.y;
        }
        vec3 way = direction_of(at), side = vec3(side_of(ea, way), side_of(eb, way), side_of(ec, way));
        float sum = side.x + side.y + side.z, z = volume / sum;
        bool drawn = at.x <= last && least_of(side) >= 0.0 && sum > 0.0;
        if (HAS_MASKS != 0) drawn = drawn && is_present(t.mask, side.yz / sum);
        if (drawn) atomicMin(keys[uint(at.y * float(SIZE) + at.x)], (depth_key(z, depths) << ID_BITS) | id);
        ++at.x;
    }
}


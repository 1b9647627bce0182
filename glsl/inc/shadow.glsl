// Is a surface point lit by a light sample? Two steps, for the second one is needed at few points and costs more:
//
// `shadow_at` looks at the four texels about the point. Where all show the surface's *tangent plane* or what lies behind
// it, the point is lit; where all show what stands clearly before it, it is dark; else it is close to an edge.
//
// `is_lit` decides there, and exactly: the map only says where to look. The triangles that it shows at these texels are tested against the segment from the point to the light, and so are the triangles that lie between
// them and the point on the same surface, edge by edge. Shadows end where the geometry ends, whatever the size of a texel,
// and what is closed is dark inside.
//
// Wants `frames`, `shadow_depth`, `shadow_identity`, `triangles`, and the constants SHADOW_VIEWS, SHADOW_SIZE,
// SHADOW_COLUMNS, SHADOW_ROWS, SHADOW_OPAQUE.

// Relative depth by which the map tells two surfaces apart: its rounding.
const float SHADOW_GRAIN = 1e-4;
// The same where the map alone decides: neighbours of a curved surface stand over its tangent plane.
const float SHADOW_SLACK = 2e-3;
// Relative depth that single precision does not tell apart.
const float SHADOW_LEAST = 1e-6;
// Triangles that are tested for a point, at most.
const uint SHADOW_STEPS = 32;
// Triangles in a row of their image.
const uint SHADOW_ROW = 1024;

const bool SHADOW_PARALLEL = SHADOW_VIEWS == VIEWS_ORTHOGRAPHIC;
const uint NO_TRIANGLE = 0xffffffffu;

const uint LIT = 0, DARK = 1, CLOSE = 2;

// A point's place in a sample's tile: the corner of four texels that is nearest to it, in the image of all tiles, and the
// tangent plane's depth there, which is linear over the image.
struct ShadowPlace {
    ivec3 corner;
    bool outside;
    vec2 texel;      // of the point, from the corner
    float here;      // depth of the point
    float plane;     // of the tangent plane at the corner
    vec2 step_;      // its change from texel to texel
    float grain;     // what the map cannot tell apart
    float slack;
    float furthest;  // a grazing plane may meet a texel's ray far off: never nearer to the light than this
    vec3 toward;     // to the light: all the way, or a direction
};

ShadowPlace shadow_place(uint tile, vec3 p, vec3 n) {
    Frame frame = frames[tile];
    ShadowPlace s;
    vec3 l = to_local(frame, p - frame.origin.xyz);
    uint view = SHADOW_VIEWS == VIEWS_HEMICUBE || SHADOW_VIEWS == VIEWS_CUBE ? face_of(l) : 0;
    vec3 f = face_coordinates(view, l);
    vec3 nf = face_coordinates(view, to_local(frame, n));
    vec2 scale = vec2(frame.tangent.w, frame.bitangent.w);
    vec2 ndc = f.xy * scale / (SHADOW_PARALLEL ? 1.0 : f.z);
    s.outside = any(greaterThan(abs(ndc), vec2(1.0))) || (!SHADOW_PARALLEL && f.z <= 0.0);

    vec2 texel = (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * float(SHADOW_SIZE);
    vec2 corner = clamp(floor(texel + 0.5), vec2(2.0), vec2(float(SHADOW_SIZE) - 2.0));
    s.texel = texel - corner;
    s.corner = ivec3(ivec2(tile % SHADOW_COLUMNS, tile / SHADOW_COLUMNS) * int(SHADOW_SIZE) + ivec2(corner), int(view));
    // n·(t·(x, y, 1) − p) = 0 gives 1/t, or n·(q − p) = 0 with q = (x, y, z) gives z: both linear in x and y.
    float unit = SHADOW_PARALLEL ? frame.normal.w : frame.origin.w;
    float facing = SHADOW_PARALLEL ? nf.z : dot(nf, f);
    facing = abs(facing) > 1e-20 ? facing : 1e-20;
    s.here = SHADOW_PARALLEL ? -f.z * unit : unit / f.z;
    s.step_ = nf.xy * (unit / facing) * vec2(2.0, -2.0) / (float(SHADOW_SIZE) * scale);
    s.plane = s.here - dot(s.step_, s.texel);
    // Of what a far light sees, the depths differ by a small share of the distance.
    float depths = SHADOW_PARALLEL ? 1.0 : frame.normal.w * s.here, least = SHADOW_PARALLEL ? 0.0 : SHADOW_LEAST * s.here;
    s.grain = max(SHADOW_GRAIN * (SHADOW_PARALLEL ? min(0.1, 0.2 * unit / frame.tangent.w) : depths), least);
    s.slack = max(SHADOW_SLACK * (SHADOW_PARALLEL ? 0.25 * unit / frame.tangent.w : depths), least);
    s.furthest = s.here + (SHADOW_PARALLEL ? 16.0 * unit / (frame.tangent.w * float(SHADOW_SIZE)) : depths);
    s.toward = SHADOW_PARALLEL ? -frame.normal.xyz : frame.origin.xyz - p;
    return s;
}

// Depths of the four texels about a corner, and of the tangent plane there.
vec4 shadow_depths(ivec3 corner) {
    const vec2 texel = 1.0 / vec2(SHADOW_COLUMNS * SHADOW_SIZE, SHADOW_ROWS * SHADOW_SIZE);
    return textureGather(shadow_depth, vec3(vec2(corner.xy) * texel, float(corner.z)));
}

// Where the four lie, in the order of a gather, from the corner.
const vec4 GATHERED_X = vec4(-0.5, 0.5, 0.5, -0.5), GATHERED_Y = vec4(0.5, 0.5, -0.5, -0.5);

vec4 plane_depths(ShadowPlace s) {
    return s.plane + s.step_.x * GATHERED_X + s.step_.y * GATHERED_Y;
}

bvec4 clearly_before(ShadowPlace s, vec4 stored, vec4 plane) {
    return greaterThan(stored, clamp(plane, vec4(s.here), vec4(s.furthest)) + s.slack);
}

// Of depths z_r of a point and z_b of what the map shows nearest to the light about it: z_r/z_b − 1.
float occluder_nearness(ShadowPlace s, vec4 stored) {
    return max(max(stored.x, stored.y), max(stored.z, stored.w)) / s.here - 1.0;
}

// `has_own`: `is_lit` will be told the point's own triangle. Then what the map cannot tell from the tangent plane, beside what
// lies behind that, may be another surface that ends just there, such as the ceiling over a wall.
uint shadow_at(uint tile, vec3 p, vec3 n, bool has_own, out float nearness) {
    ShadowPlace s = shadow_place(tile, p, n);
    vec4 stored = shadow_depths(s.corner), plane = plane_depths(s);
    nearness = occluder_nearness(s, stored);
    bvec4 behind = lessThan(stored, plane - s.grain);
    bool lit = s.outside || all(lessThanEqual(stored, plane + s.grain));
    if (has_own && any(behind) && !all(behind)) lit = s.outside;
    return lit ? LIT : all(clearly_before(s, stored, plane)) ? DARK : CLOSE;
}

// The place moved over the map by `texels`, seen from there as the same tangent plane.
ShadowPlace moved(ShadowPlace s, uint tile, vec2 texels) {
    vec2 tile_corner = vec2(tile % SHADOW_COLUMNS, tile / SHADOW_COLUMNS) * float(SHADOW_SIZE);
    vec2 from = vec2(s.corner.xy) - tile_corner, to = from + s.texel + texels;
    vec2 corner = clamp(floor(to + 0.5), vec2(2.0), vec2(float(SHADOW_SIZE) - 2.0));
    s.plane += dot(s.step_, corner - from);
    s.texel = clamp(to - corner, vec2(-0.5), vec2(0.5));
    s.corner.xy = ivec2(tile_corner + corner);
    return s;
}

// Places of a disc that each sample looks at; samples beside each other are turned.
const uint DISC_PLACES = 3;
const float DISC_RADIUS = 0.7071;  // half of the disc's area lies within
const float GOLDEN_ANGLE = 2.3999632;
// Smaller discs, in texels, are decided by their middle.
const float SMALLEST_DISC = 1.0;

// Share of a disc about a sample that a point sees, from the map alone (Reeves, Salesin and Cook 1987; its size by the occluder's
// distance: Fernando 2005). `nearness`: of what hides it, as `occluder_nearness`. What is much closer to the point hides all of the
// disc or nothing: `middle`, whether its middle is seen, decides.
float seen_share(uint tile, vec3 p, vec3 n, float radius, float nearness, bool middle) {
    ShadowPlace s = shadow_place(tile, p, n);
    // 1/z_r is here/near; a texel is 2/size of tangents over the frame's scale.
    float texels = radius * nearness * s.here / frames[tile].origin.w * frames[tile].tangent.w * 0.5 * float(SHADOW_SIZE);
    if (s.outside || texels < SMALLEST_DISC) return middle ? 1.0 : 0.0;
    float seen = 0.0;
    for (uint i = 0; i < DISC_PLACES; ++i) {
        float turn = GOLDEN_ANGLE * float(tile) + 2.0 * PI / float(DISC_PLACES) * float(i);
        ShadowPlace there = moved(s, tile, DISC_RADIUS * texels * vec2(cos(turn), sin(turn)));
        vec4 stored = shadow_depths(there.corner);
        bvec4 before = clearly_before(there, stored, plane_depths(there));
        bvec4 is_close = lessThan(stored, vec4(s.here * (1.0 + 0.5 * nearness)));
        vec4 weights = (0.5 + 2.0 * GATHERED_X * there.texel.x) * (0.5 + 2.0 * GATHERED_Y * there.texel.y);
        seen += dot(weights, mix(vec4(not(before)), vec4(middle), vec4(before) * vec4(is_close)));
    }
    return seen / float(DISC_PLACES);
}

uint identity_at(ivec3 texel) { return texelFetch(shadow_identity, texel, 0).x - 1; }

// Six times the volumes that the ray from the origin along `d` spans with the edges of a triangle. Two triangles that
// share an edge have exactly opposite volumes there, so that no ray passes between them (Woop, Benthin and Wald 2013).
vec3 edge_volumes(vec3 d, vec3 a, vec3 b, vec3 c) {
    precise vec3 bc = vec3(b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x);
    precise vec3 ca = vec3(c.y * a.z - c.z * a.y, c.z * a.x - c.x * a.z, c.x * a.y - c.y * a.x);
    precise vec3 ab = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    precise vec3 v = vec3(d.x * bc.x + d.y * bc.y + d.z * bc.z, d.x * ca.x + d.y * ca.y + d.z * ca.z,
                          d.x * ab.x + d.y * ab.y + d.z * ab.z);
    return v;
}

// What a triangle does to the segment from p to p + toward: LIT or DARK where the ray meets it, else CLOSE and, in `next`,
// the triangle across the edge that the ray is beyond; NO_TRIANGLE at the surface's border or fold. `from`: whence it came.
uint meet(uint triangle, uint from, vec3 p, vec3 toward, out uint next) {
    ivec2 at = ivec2(triangle % SHADOW_ROW, triangle / SHADOW_ROW) * ivec2(3, 1);
    uvec4 first = texelFetch(triangles, at, 0), second = texelFetch(triangles, at + ivec2(1, 0), 0),
          third = texelFetch(triangles, at + ivec2(2, 0), 0);
    vec3 a = uintBitsToFloat(first.xyz) - p, b = uintBitsToFloat(second.xyz) - p, c = uintBitsToFloat(third.xyz) - p;
    vec3 v = edge_volumes(toward, a, b, c);
    float all_ = v.x + v.y + v.z, height = dot(a, cross(b, c));
    bvec3 beyond = all_ > 0.0 ? lessThan(v, vec3(0.0)) : greaterThan(v, vec3(0.0));
    uvec3 across = uvec3(first.w, second.w, third.w);
    next = beyond.x ? across.x : NO_TRIANGLE;
    if (beyond.y && across.y != NO_TRIANGLE) next = across.y;
    if (beyond.z && across.z != NO_TRIANGLE) next = across.z;
    bool folds = from != NO_TRIANGLE && any(equal(mix(uvec3(NO_TRIANGLE), across, beyond), uvec3(from)));
    if (folds || next >= SHADOW_OPAQUE) next = NO_TRIANGLE;
    // The ray is at the plane at height/all_: behind the point or beyond the light nothing is in the way.
    bool before = all_ > 0.0 ? height > 0.0 : height < 0.0;
    return any(beyond) ? CLOSE : before && (SHADOW_PARALLEL || abs(height) < abs(all_)) ? DARK : LIT;
}

// Decides where `shadow_at` cannot. `own`: the triangle that p lies on, if it is known, else NO_TRIANGLE.
bool is_lit(uint tile, uint own, vec3 p, vec3 n) {
    ShadowPlace s = shadow_place(tile, p, n);
    vec4 stored = shadow_depths(s.corner), plane = plane_depths(s);
    bvec4 before = greaterThan(stored, plane + (own == NO_TRIANGLE ? s.grain : -s.grain)), clear = clearly_before(s, stored, plane);
    uvec4 seen = uvec4(identity_at(s.corner + ivec3(-1, 0, 0)), identity_at(s.corner),
                       identity_at(s.corner + ivec3(0, -1, 0)), identity_at(s.corner + ivec3(-1, -1, 0)));
    // What an alpha mask lets through, and what is too far to walk to, only the map knows: its nearest texel.
    uint nearest = s.texel.y < 0.0 ? (s.texel.x < 0.0 ? 3 : 2) : (s.texel.x < 0.0 ? 0 : 1);
    bool by_map = clear[nearest], masked = seen[nearest] >= SHADOW_OPAQUE;
    seen = mix(uvec4(NO_TRIANGLE), seen, before);
    uint start = NO_TRIANGLE, triangle = NO_TRIANGLE, from = NO_TRIANGLE, found = masked && by_map ? DARK : LIT;
    // One loop over what is seen and the walks from there: a step each.
    for (uint step_ = 0; step_ < SHADOW_STEPS && found != DARK; ++step_) {
        if (triangle == NO_TRIANGLE) {
            seen = mix(seen, uvec4(NO_TRIANGLE), bvec4(equal(seen, uvec4(start))));
            start = min(min(seen.x, seen.y), min(seen.z, seen.w));
            if (start >= SHADOW_OPAQUE) break;
            triangle = start;
            from = NO_TRIANGLE;
        }
        uint next;
        found = triangle == own ? LIT : meet(triangle, from, p, s.toward, next);
        from = triangle;
        triangle = found == CLOSE ? next : NO_TRIANGLE;
    }
    return found != DARK && (triangle == NO_TRIANGLE || !by_map);
}

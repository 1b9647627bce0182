// What texels see, from captures by render passes. Wants what body.glsl declares.
layout(set = 1, binding = 0, std430) readonly buffer Positions { float positions[]; };
layout(set = 1, binding = 1, std430) readonly buffer Indices { uint indices[]; };
layout(set = 1, binding = 2, std430) readonly buffer FirstCell { uint first_cell[]; };
layout(set = 1, binding = 3, std430) readonly buffer CellRadiance { float cell_radiance[]; };
layout(set = 1, binding = 4) uniform utexture2DArray identities;
layout(set = 1, binding = 5, std430) readonly buffer Sky { uvec4 sky_size; vec4 sky[]; };

#include "inc/triangles.glsl"
#include "inc/cells.glsl"
#include "inc/cell_light.glsl"
#include "inc/sky.glsl"
#include "integrate/curved.glsl"

// The cell of a triangle at the point (1−u−v)·p0 + u·p1 + v·p2.
uint cell_of(uint triangle, vec2 uv) {
    uint first = first_cell[triangle], cells = first_cell[triangle + 1] - first;
    return first + cell_at(cell_resolution(cells), uv);
}

// Number plus 1 of the triangle that a texel shows, 0 for none: `place` is layer<<16 | y<<8 | x.
uint look(uvec2 tile, uint place, vec3 origin, vec3 direction) {
    ivec2 at = ivec2(place & 255, place >> 8 & 255);
    if (IS_CURVED != 0) return look_closely(tile, at, origin, direction);
    return texelFetch(identities, ivec3(ivec2(tile) + at, place >> 16), 0).x;
}

// Radiance and 1/distance of a triangle in a direction, and its plane. Side and distance come from the triangle's corners alone: a
// rasteriser tells them by corners that it has clipped and rounded, which turns slivers over and stretches walls that pass by
// the eye. No distance is below the near one.
vec4 surface(uint triangle, Frame frame, vec3 direction, out vec3 plane, out bool front) {
    uvec3 c = corners_of(triangle);
    vec3 a = position_of(c.x) - frame.origin.xyz, e1 = position_of(c.y) - position_of(c.x),
         e2 = position_of(c.z) - position_of(c.x);
    vec2 uv = within(barycentrics(a, e1, e2, direction));
    vec3 at = a + uv.x * e1 + uv.y * e2;
    plane = inverse_plane(a, e1, e2);
    front = dot(a, cross(e1, e2)) < 0.0;
    return vec4(cell_light(cell_of(triangle, uv), front), min(inversesqrt(dot(at, at)), 1.0 / frame.origin.w));
}

// What texel i of a record sees: of surfaces, with 1/distance, and of the sky. Keeps it in `gathered`.
void see(uint record, Frame frame, uint i, out vec4 seen, out vec3 beyond) {
    uvec2 tile = uvec2(record % push.columns, record / push.columns) * push.tile_size;
    vec3 direction = to_world(frame, texel_value(2 * i + 1).xyz);
    vec4 plane = vec4(vec3(0.0), tagged(0));
    uint number = look(tile, floatBitsToUint(texel_value(2 * i).w), frame.origin.xyz, direction);
    bool above = is_above(frame, direction);
    seen = vec4(0.0);
    beyond = vec3(0.0);
    if (number != 0 && above) {
        bool front;
        seen = surface(number - 1, frame, direction, plane.xyz, front);
        if (HAS_TRANSLATION != 0) plane = vec4(to_local(frame, plane.xyz), tagged(number | (front ? 0 : BACK_SEEN)));
    } else if (HAS_SKY != 0 && above) {
        beyond = sky_radiance(direction);
    }
    uint at = STRIDE * (record * push.texel_count + i);
    gathered[at] = seen;
    if (HAS_SKY != 0) gathered[at + 1] = vec4(beyond, 0.0);
    if (HAS_TRANSLATION != 0) gathered[at + STRIDE - 1] = plane;
}

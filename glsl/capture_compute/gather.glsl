// Tells what each texel sees (inc/gathered.glsl).

layout(set = 0, binding = 4, std430) readonly buffer CellRadiance { float cell_radiance[]; };
#include "inc/cell_light.glsl"

// Triangles' numbers are kept in its place meanwhile.
uint meanwhile(uint at) { return untagged(gathered[STRIDE * at].x); }

void keep(uint at, uint triangle) { gathered[STRIDE * at].x = tagged(triangle); }

uint triangle_at(uint i, uint key, uint first);

void tell(View view, uint texels, uint first) {
    mat3 axes = local_axes(view.face);
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        Spot spot = spot_of(i);
        uint key = keys[spot.key], triangle = triangle_at(i, key, first), at = STRIDE * (first + i);
        Sight sight = see(view, key, triangle, spot.way);
        gathered[at] = vec4(sight.light, sight.inverse_distance);
        if (HAS_SKY != 0) gathered[at + 1] = vec4(sight.beyond, 0.0);
        if (HAS_TRANSLATION != 0) gathered[at + STRIDE - 1] = vec4(sight.plane * axes, tagged(triangle | (sight.back ? BACK_SEEN : 0)));
    }
}

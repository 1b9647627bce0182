// Tells what each texel sees (inc/gathered.glsl).

layout(set = 0, binding = 4, std430) readonly buffer CellRadiance { float cell_radiance[]; };
#include "inc/cell_light.glsl"

// Triangles' numbers are kept in its place meanwhile, as the bits of floats that no device takes for a denormal one.
const uint TAG = 0x40000000u;

uint meanwhile(uint at) { return floatBitsToUint(gathered[STRIDE * at].x) ^ TAG; }

void keep(uint at, uint triangle) { gathered[STRIDE * at].x = uintBitsToFloat(triangle | TAG); }

uint triangle_at(uint i, uint key, uint first);

void tell(View view, uint texels, uint first) {
    mat3 axes = local_axes(view.face);
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        Spot spot = spot_of(i);
        uint key = keys[spot.key], triangle = triangle_at(i, key, first), at = STRIDE * (first + i);
        vec3 light = vec3(0.0), plane = vec3(0.0);
        if (triangle != 0) look(view, triangle - 1, spot.way, light, plane);
        gathered[at] = vec4(light, max(dot(plane, spot.way) * inversesqrt(dot(spot.way, spot.way)), 0.0));
        if (HAS_SKY != 0) {
            vec3 beyond = vec3(0.0);
            if (key == NOTHING) beyond = sky_radiance(spot.way * view.axes);
            gathered[at + 1] = vec4(beyond, 0.0);
        }
        if (HAS_TRANSLATION != 0) gathered[at + STRIDE - 1] = vec4(plane * axes, 0.0);
    }
}

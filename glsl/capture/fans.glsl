// A corner of what a view sees of a triangle (inc/fan.glsl). Wants frames.glsl, scene.glsl and triangles.glsl.
#include "inc/fan.glsl"

struct FanCorner { uint triangle; uvec3 vertices; mat3 positions; vec3 weights; vec4 clip; };

FanCorner corner_of_fan(Frame frame) {
    FanCorner corner;
    corner.triangle = gl_VertexIndex / (3 * FAN);
    corner.vertices = corners_of(corner.triangle);
    corner.positions = mat3(position_of(corner.vertices.x), position_of(corner.vertices.y), position_of(corner.vertices.z));
    vec4 a = projected(frame, corner.positions[0]), b = projected(frame, corner.positions[1]),
         c = projected(frame, corner.positions[2]);
    corner.weights = fan_corner(a, b, c, gl_VertexIndex % (3 * FAN));
    corner.clip = fan_position(a, b, c, corner.weights);
    return corner;
}

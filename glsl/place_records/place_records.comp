// Puts a record and its capture frame on each chosen pixel.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/hash.glsl"
#include "inc/lift.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform texture2D gbuffer_position;
layout(set = 0, binding = 1) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 2, std430) readonly buffer Found { uint found_count; uint pixels[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Records { Record records[]; };
layout(push_constant) uniform Push {
    uint first;        // of the found pixels
    uint count;
    uint width;
    uint seed;
    float near;
    float lift;        // how far a capture's origin stands off its surface, as `lift_at`
    float scale;       // of a capture's axes
    float grain;       // edge of the cubes of space that have one turn each
    vec4 core;
} push;

// Cosine and sine of so many whole turns, by their series within an eighth of one (errors below 4e-7): Vulkan lets a device's own be
// off by 2^-11, which would shear captures.
vec2 direction_of(float turns) {
    float quarter = floor(4.0 * turns + 0.5), r = 2.0 * PI * (turns - 0.25 * quarter), q = r * r;
    float c = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0)));
    float s = r * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0)));
    switch (uint(quarter) % 4) {
        case 0: return vec2(c, s);
        case 1: return vec2(-s, c);
        case 2: return vec2(-c, -s);
        default: return vec2(s, -c);
    }
}

uint hash_of_place(ivec3 cube) { return pcg(uint(cube.x) ^ pcg(uint(cube.y) ^ pcg(uint(cube.z) ^ pcg(push.seed)))); }

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= push.count) return;
    uint pixel = pixels[push.first + at];
    ivec2 xy = ivec2(pixel % push.width, pixel / push.width);
    vec3 p = texelFetch(gbuffer_position, xy, 0).xyz;
    uvec2 codes = texelFetch(gbuffer_normals, xy, 0).xy;
    vec3 n = oct_decode(codes.x), ng = oct_decode(codes.y);

    // A random turn about the normal makes the hemicube's aliasing noise between records instead of a pattern. It depends on
    // the place alone, so that every view and every tile of an image captures the same record there.
    vec2 turn = direction_of(unit_float(hash_of_place(ivec3(floor(p / push.grain)))));
    float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), b = n.x * n.y * a;  // Duff et al. 2017
    vec3 t0 = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), b0 = vec3(b, s + n.y * n.y * a, -n.y);
    vec3 t = turn.x * t0 + turn.y * b0;
    vec3 origin = p + ng * lift_at(p, push.core, push.lift);

    Frame frame;
    frame.origin = vec4(origin, push.near);
    frame.tangent = vec4(t, push.scale);
    frame.bitangent = vec4(cross(n, t), push.scale);
    frame.normal = vec4(n, 1.0);
    frame.horizon = vec4(ng, -dot(ng, origin));
    frames[at] = frame;

    Record record;
    record.position = vec4(p, 0.0);
    record.normal = vec4(n, 0.0);
    record.geometric = vec4(ng, 0.0);
    records[at] = record;
}

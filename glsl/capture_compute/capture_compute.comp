// A hemicube's faces rasterised in shared memory, after micro-rendering (Ritschel et al. 2009): no image is written, only
// what each texel sees. One workgroup a (record, face): it walks the clusters, and each invocation takes one triangle of a
// cluster that the face sees. Triangles are tested as directions, in homogeneous coordinates (Olano and Greer 1997): what
// crosses the face's plane needs no clipping, and a triangle that covers no texel's centre is dropped after its bounds.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/views.glsl"
const uint THREADS = 64;  // triangles of a cluster
layout(local_size_x = THREADS) in;

layout(constant_id = 0) const uint SIZE = 32;
layout(constant_id = 1) const uint ID_BITS = 18;

layout(set = 0, binding = 0, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 1, std430) readonly buffer Clusters { vec4 clusters[]; };
layout(set = 0, binding = 2, std430) readonly buffer Corners { float corners[]; };  // nine floats a triangle
layout(set = 0, binding = 3, std430) writeonly buffer Seen { uvec2 seen[]; };  // identity, 1/distance
layout(push_constant) uniform Push { uint cluster_count; uint triangle_count; float nearest; uint texel_count; } push;

const uint NOTHING = 0xffffffffu;
// Nearest depth and triangle of each texel: the logarithm of depth in the upper bits, the triangle in the lower ones.
shared uint keys[SIZE * SIZE];
shared uint visible[2];

struct Triangle { vec3 a, b, c; };  // corners, in face coordinates

// Axes of a face: right, up, forward, as rows.
mat3 face_axes(uint view, Frame frame) {
    mat3 columns = mat3(face_coordinates(view, vec3(1.0, 0.0, 0.0)), face_coordinates(view, vec3(0.0, 1.0, 0.0)),
                        face_coordinates(view, vec3(0.0, 0.0, 1.0)));
    return columns * transpose(mat3(frame.tangent.xyz, frame.bitangent.xyz, frame.normal.xyz));
}

Triangle load(mat3 axes, vec3 origin, uint triangle) {
    uint at = 9 * triangle;
    return Triangle(axes * (vec3(corners[at], corners[at + 1], corners[at + 2]) - origin),
                    axes * (vec3(corners[at + 3], corners[at + 4], corners[at + 5]) - origin),
                    axes * (vec3(corners[at + 6], corners[at + 7], corners[at + 8]) - origin));
}

vec2 texel_centre(ivec2 at) { return (vec2(at) + 0.5) * (2.0 / float(SIZE)) - 1.0; }

// The face's own rows: above the horizon on the sides. Row 0 is at the top.
int rows(uint view) { return int(view == 0 ? SIZE : SIZE / 2); }

// Depth to key: steps of equal ratio over the range that matters, by the float's own bits.
uint depth_key(float z) {
    uint bits = floatBitsToUint(max(z, push.nearest)) - floatBitsToUint(push.nearest);
    // 16 octaves of 2²³ steps: 27 bits.
    return min(bits, (1u << 27) - 1) >> (ID_BITS - 5);
}

bool outside(Triangle t, uint view) {
    vec3 x = vec3(t.a.x, t.b.x, t.c.x), y = vec3(t.a.y, t.b.y, t.c.y), z = vec3(t.a.z, t.b.z, t.c.z);
    bool below = view > 0 && all(lessThan(y, vec3(0.0)));
    return below || all(lessThanEqual(z, vec3(0.0))) || all(greaterThan(x, z)) || all(lessThan(x, -z))
        || all(greaterThan(y, z)) || all(lessThan(y, -z));
}

void rasterise(uint view, Triangle t, uint triangle) {
    if (outside(t, view)) return;
    ivec2 low = ivec2(0), high = ivec2(int(SIZE), rows(view)) - 1;
    if (min(t.a.z, min(t.b.z, t.c.z)) > 0.0) {
        vec2 a = t.a.xy / t.a.z, b = t.b.xy / t.b.z, c = t.c.xy / t.c.z;
        vec2 least = min(a, min(b, c)), most = max(a, max(b, c));
        // Row 0 is at y = +1. A hair wider than the bounds: rounding must not lose a centre.
        vec2 from = (vec2(least.x, -most.y) + 1.0) * (0.5 * float(SIZE)) - 0.501;
        vec2 to = (vec2(most.x, -least.y) + 1.0) * (0.5 * float(SIZE)) - 0.499;
        low = max(low, ivec2(ceil(clamp(from, vec2(-1.0), vec2(float(SIZE))))));
        high = min(high, ivec2(floor(clamp(to, vec2(-1.0), vec2(float(SIZE))))));
    }
    if (any(greaterThan(low, high))) return;
    // Signed volumes of the direction with each edge; each is exactly the negative of its neighbour's.
    precise vec3 ea = cross(t.b, t.c), eb = cross(t.c, t.a), ec = cross(t.a, t.b);
    vec3 normal = ea + eb + ec;
    float volume = dot(t.a, ea);
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            vec2 p = texel_centre(ivec2(x, y)) * vec2(1.0, -1.0);
            precise vec3 side = vec3(ea.x * p.x + ea.y * p.y + ea.z, eb.x * p.x + eb.y * p.y + eb.z,
                                     ec.x * p.x + ec.y * p.y + ec.z);
            bool inside = all(greaterThanEqual(side, vec3(0.0))) || all(lessThanEqual(side, vec3(0.0)));
            if (!inside) continue;
            float z = volume / dot(normal, vec3(p, 1.0));
            if (z > 0.0) atomicMin(keys[y * int(SIZE) + x], (depth_key(z) << ID_BITS) | triangle);
        }
    }
}

bool sees(uint view, mat3 axes, Frame frame, vec4 sphere) {
    float r = sphere.w;
    if (dot(frame.horizon.xyz, sphere.xyz) + frame.horizon.w < -r) return false;
    vec3 f = axes * (sphere.xyz - frame.origin.xyz);
    return (view == 0 || f.y >= -r) && f.z - max(abs(f.x), abs(f.y)) >= -1.41421357 * r;
}

void write_seen(uint record, uint view, mat3 axes, Frame frame) {
    uint texels = SIZE * rows(view);
    uint first = record * push.texel_count + (view == 0 ? 0 : SIZE * SIZE + (view - 1) * (SIZE * SIZE / 2));
    for (uint i = gl_LocalInvocationID.x; i < texels; i += THREADS) {
        uint key = keys[i];
        vec2 p = texel_centre(ivec2(i % SIZE, i / SIZE)) * vec2(1.0, -1.0);
        vec3 direction = to_world(frame, face_direction(view, p));
        uvec2 result = uvec2(0);
        if (key != NOTHING && dot(direction, frame.horizon.xyz) > 0.0) {
            uint triangle = key & ((1u << ID_BITS) - 1);
            Triangle t = load(axes, frame.origin.xyz, triangle);
            vec3 normal = cross(t.b - t.a, t.c - t.a);
            float volume = dot(t.a, normal);
            float inverse_z = dot(normal, vec3(p, 1.0)) / volume;
            // Faces are mirrored: what shows its front has a positive volume in the world and a negative one here.
            result = uvec2((triangle + 1) | (volume < 0.0 ? 0x80000000u : 0),
                           floatBitsToUint(max(inverse_z, 0.0) * inversesqrt(1.0 + dot(p, p))));
        }
        seen[first + i] = result;
    }
}

void main() {
    uint me = gl_LocalInvocationID.x;
    uint record = gl_WorkGroupID.x / 5, view = gl_WorkGroupID.x % 5;
    Frame frame = frames[record];
    mat3 axes = face_axes(view, frame);
    for (uint i = me; i < SIZE * SIZE; i += THREADS) keys[i] = NOTHING;
    for (uint start = 0; start < push.cluster_count; start += THREADS) {
        barrier();
        if (me < 2) visible[me] = 0;
        barrier();
        if (start + me < push.cluster_count && sees(view, axes, frame, clusters[start + me]))
            atomicOr(visible[me / 32], 1u << (me % 32));
        barrier();
        for (uint half_ = 0; half_ < 2; ++half_) {
            for (uint bits = visible[half_]; bits != 0; bits &= bits - 1) {
                uint triangle = (start + 32 * half_ + findLSB(bits)) * THREADS + me;
                if (triangle < push.triangle_count) rasterise(view, load(axes, frame.origin.xyz, triangle), triangle);
            }
        }
    }
    barrier();
    write_seen(record, view, axes, frame);
}

// Neighbour clamping (Křivánek, Bouatouch, Pattanaik and Žára 2006): a new record reaches no further beyond an older one
// than that reaches itself, r ≤ r_i + ‖P − P_i‖, for what shortens one zone is near the other. Radii as they were before
// limits in pixels; those of splatted records stay as they are. Two dispatches share this shader: enlist the batch in
// screen tiles, then clamp it. Lists have any order, but a minimum has none: the same radii every time.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PHASE = 0;  // 0 enlist, 1 clamp
layout(constant_id = 1) const uint HAS_SKY = 0;

layout(set = 0, binding = 0) uniform texture2D gbuffer_position;
layout(set = 0, binding = 1) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 2, std430) readonly buffer Found { uint found_count; uint pixels[]; };
layout(set = 0, binding = 3, std430) readonly buffer Payloads { Payload payloads[]; };
layout(set = 0, binding = 4, std430) buffer Records { Record records[]; };
layout(set = 0, binding = 5, std430) buffer Heads { uint heads[]; };  // of each tile's list: a pixel + 1, or 0
layout(set = 0, binding = 6, std430) buffer Nodes { uvec2 nodes[]; };  // of each pixel with a record: its radius, the next
layout(push_constant) uniform Push { uint first; uint count; uint width; uint tile; uvec2 tiles; float min_radius; } push;

const float SAME_SURFACE = 0.5;  // least n·n_i of records that concern each other

ivec2 place_of(uint pixel) { return ivec2(pixel % push.width, pixel / push.width); }

float clamped(uint me, ivec2 xy, float radius) {
    vec3 p = records[me].position.xyz, n = records[me].normal.xyz;
    ivec2 tile = xy / int(push.tile);
    ivec2 low = max(tile - 1, ivec2(0)), high = min(tile + 1, ivec2(push.tiles) - 1);
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            for (uint node = heads[uint(y) * push.tiles.x + uint(x)]; node != 0; node = nodes[node - 1].y) {
                float reach = uintBitsToFloat(nodes[node - 1].x);
                if (reach >= radius) continue;
                ivec2 other = place_of(node - 1);
                if (dot(n, oct_decode(texelFetch(gbuffer_normals, other, 0).x)) < SAME_SURFACE) continue;
                radius = min(radius, reach + distance(p, texelFetch(gbuffer_position, other, 0).xyz));
            }
        }
    }
    return radius;
}

void main() {
    uint me = gl_GlobalInvocationID.x;
    if (me >= push.count) return;
    uint pixel = pixels[push.first + me];
    ivec2 xy = place_of(pixel);
    float radius = records[me].position.w;
    if (PHASE == 0) {
        // The payload's share tells the radius below the limit.
        float reach = radius * payloads[(HAS_SKY + 1) * me].translation[0].w;
        ivec2 tile = xy / int(push.tile);
        uint before = atomicExchange(heads[uint(tile.y) * push.tiles.x + uint(tile.x)], pixel + 1);
        nodes[pixel] = uvec2(floatBitsToUint(reach), before);
    } else {
        float least = min(radius, push.min_radius * records[me].geometric.w);
        records[me].position.w = max(clamped(me, xy, radius), least);
    }
}

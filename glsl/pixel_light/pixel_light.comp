// Direct irradiance of each pixel: adds the light samples of the current batch of shadow views.
#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/views.glsl"
layout(local_size_x = 64) in;
#include "inc/invocation.glsl"
layout(constant_id = 0) const uint LIGHT_KIND = 0;
layout(constant_id = 1) const uint SHADOW_VIEWS = 0;
layout(constant_id = 2) const uint SHADOW_SIZE = 256;
layout(constant_id = 3) const uint SHADOW_COLUMNS = 1;
layout(constant_id = 4) const uint SHADOW_ROWS = 1;
layout(constant_id = 5) const uint SHADOW_OPAQUE = 0;
layout(constant_id = 6) const uint HAS_FACES = 0;  // the samples of each emissive triangle stand together

layout(set = 0, binding = 0, std430) readonly buffer Lights { LightSample lights[]; };
layout(set = 0, binding = 1, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 2) uniform sampler2DArray shadow_depth;
layout(set = 0, binding = 3) uniform utexture2DArray shadow_identity;
layout(set = 0, binding = 4) uniform utexture2D triangles;
layout(set = 0, binding = 5) uniform texture2D gbuffer_position;
layout(set = 0, binding = 6) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 7, rgba32f) uniform image2D direct;
layout(set = 0, binding = 8, std430) readonly buffer Faces { EmitterFace faces[]; };
layout(push_constant) uniform Push { uint width; uint height; uint count; float lift; vec4 core; } push;  // count: of faces or samples

#include "inc/light.glsl"
#include "inc/polygon.glsl"
#include "inc/lift.glsl"
#include "inc/shadow.glsl"

struct Receiver { vec3 position; vec3 normal; vec3 geometric; };

// Irradiance by a sample before its shadow, and by the same sample of radiance 1.
struct Unshadowed { vec3 irradiance; float unit; };

Unshadowed sample_light(uint l, Receiver at) {
    if (!is_in_shell(lights[l], at.position, push.core.xyz)) return Unshadowed(vec3(0.0), 0.0);
    // Power is radiance times area, and the area π times the disc's radius squared.
    float area = HAS_FACES != 0 ? PI * lights[l].position.w : 1.0;
    Arriving light = HAS_FACES != 0 ? light_from_disc(lights[l], at.position, vec3(area))
                                    : light_arriving(lights[l], at.position);
    float unit = light.irradiance.x * max(dot(at.normal, light.direction), 0.0);
    vec3 irradiance = HAS_FACES != 0 ? unit * lights[l].power.rgb / area
                                     : light.irradiance * max(dot(at.normal, light.direction), 0.0);
    return Unshadowed(dot(at.geometric, light.direction) > 0.0 ? irradiance : vec3(0.0), unit);
}

// `occluder_nearness` of each sample of a group.
float near[32];

// In a penumbra each sample stands for a disc of the emitter, of which the receiver sees a share: without it the shadow's edge
// would be as many steps as there are samples. `lit`, `dark`: what the samples' middles are, a bit each.
vec3 penumbra_light(uint first, uint lit, uint dark, Receiver at) {
    vec3 lifted = at.position + at.geometric * lift_at(at.position, push.core, push.lift), sum = vec3(0.0);
    float mean = 0.0;
    for (uint rest = dark; rest != 0; rest &= rest - 1) mean += near[findLSB(rest)] / float(bitCount(dark));
    for (uint rest = lit | dark; rest != 0; rest &= rest - 1) {
        uint i = findLSB(rest), l = first + i;
        vec3 d = lights[l].position.xyz - at.position;
        float facing = max(-dot(normalize(d), lights[l].direction.xyz), 0.0);
        bool middle = (lit >> i & 1u) != 0;
        float radius = sqrt(lights[l].position.w * facing);
        sum += sample_light(l, at).irradiance
             * seen_share(l, lifted, at.geometric, radius, middle ? mean : near[i], middle);
    }
    return sum;
}

// Sum over the samples from `first` to `end`; `open`: over samples of radiance 1 without shadows.
vec3 samples_light(uint first, uint end, Receiver at, out float open) {
    vec3 lifted = at.position + at.geometric * lift_at(at.position, push.core, push.lift), sum = vec3(0.0);
    open = 0.0;
    for (; first < end; first += 32) {
        uint close = 0, lit = 0, dark = 0, count = min(32, end - first);
        vec3 part = vec3(0.0);
        for (uint i = 0; i < count; ++i) {
            Unshadowed light = sample_light(first + i, at);
            open += light.unit;
            if (light.irradiance == vec3(0.0)) continue;
            uint shadow = shadow_at(first + i, lifted, at.geometric, false, near[i]);
            if (shadow == LIT) {
                part += light.irradiance;
                lit |= 1u << i;
            } else if (shadow == CLOSE) {
                close |= 1u << i;
            } else {
                dark |= 1u << i;
            }
        }
        for (; close != 0; close &= close - 1) {
            uint i = findLSB(close);
            if (is_lit(first + i, NO_TRIANGLE, lifted, at.geometric)) {
                part += sample_light(first + i, at).irradiance;
                lit |= 1u << i;
            } else {
                dark |= 1u << i;
            }
        }
        sum += LIGHT_KIND == LIGHT_AREA && lit != 0 && dark != 0 ? penumbra_light(first, lit, dark, at) : part;
    }
    return sum;
}

// Below this angle of the triangle's longest side, squared, its samples are as good as its outline.
const float SMALL = 1e-5;

// Irradiance from an emissive triangle: in closed form without occlusion, times the share of it that its samples see
// (Heitz, Hill and McGuire 2018): exact where nothing is in between, with noise in penumbrae only.
vec3 face_light(EmitterFace face, Receiver at) {
    vec3 a = face.a.xyz - at.position, b = face.b.xyz - at.position, c = face.c.xyz - at.position;
    if (dot(cross(b - a, c - a), a) >= 0.0) return vec3(0.0);  // behind it
    float open;
    uint first = floatBitsToUint(face.b.w);
    vec3 lit = samples_light(first, first + floatBitsToUint(face.c.w), at, open);
    float nearest = min(dot(a, a), min(dot(b, b), dot(c, c)));
    float longest = max(dot(b - a, b - a), max(dot(c - b, c - b), dot(a - c, a - c)));
    if (longest < SMALL * nearest || open <= 0.0) return lit;
    return lit * (face.a.w * triangle_irradiance(at.normal, a, b, c) / open);
}

void main() {
    uint pixel = invocation();
    if (pixel >= push.width * push.height) return;
    ivec2 xy = ivec2(pixel % push.width, pixel / push.width);
    vec4 surface = texelFetch(gbuffer_position, xy, 0);
    if (surface.w != 1.0) return;
    uvec2 codes = texelFetch(gbuffer_normals, xy, 0).xy;
    Receiver at = Receiver(surface.xyz, oct_decode(codes.x), oct_decode(codes.y));
    vec3 sum = vec3(0.0);
    float open;
    if (HAS_FACES == 0) sum = samples_light(0, push.count, at, open);
    for (uint i = 0; i < HAS_FACES * push.count; ++i) {
        sum += face_light(faces[i], at);
    }
    imageStore(direct, xy, imageLoad(direct, xy) + vec4(sum, 0.0));
}

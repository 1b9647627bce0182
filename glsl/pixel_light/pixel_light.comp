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
layout(constant_id = 4) const uint HAS_FACES = 0;  // the samples of each emissive triangle stand together

layout(set = 0, binding = 0, std430) readonly buffer Lights { LightSample lights[]; };
layout(set = 0, binding = 1, std430) readonly buffer Frames { Frame frames[]; };
layout(set = 0, binding = 2) uniform texture2DArray shadow_depth;
layout(set = 0, binding = 3) uniform texture2D gbuffer_position;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_normals;
layout(set = 0, binding = 5, std430) buffer Direct { vec4 direct[]; };
layout(set = 0, binding = 6, std430) readonly buffer Faces { EmitterFace faces[]; };
layout(push_constant) uniform Push { uint width; uint height; uint count; float lift; } push;  // count: of faces or samples

#include "inc/light.glsl"
#include "inc/polygon.glsl"
#include "inc/shadow.glsl"

struct Receiver { vec3 position; vec3 normal; vec3 geometric; };

bool reaches(uint l, Receiver at, vec3 direction) {
    return dot(at.geometric, direction) > 0.0 && is_lit(l, at.position + at.geometric * push.lift, at.geometric);
}

vec3 sample_light(uint l, Receiver at) {
    Arriving light = light_arriving(lights[l], at.position);
    float cosine = dot(at.normal, light.direction);
    bool dark = cosine <= 0.0 || !any(greaterThan(light.irradiance, vec3(0.0)));
    return dark || !reaches(l, at, light.direction) ? vec3(0.0) : light.irradiance * cosine;
}

// Below this angle of the triangle's longest side, squared, its samples are as good as its outline.
const float SMALL = 1e-5;

// Irradiance from an emissive triangle: in closed form without occlusion, times the share of it that its samples see
// (Heitz, Hill and McGuire 2018): exact where nothing is in between, with noise in penumbrae only.
vec3 face_light(EmitterFace face, Receiver at) {
    vec3 a = face.a.xyz - at.position, b = face.b.xyz - at.position, c = face.c.xyz - at.position;
    if (dot(cross(b - a, c - a), a) >= 0.0) return vec3(0.0);  // behind it
    vec3 lit = vec3(0.0);
    float open = 0.0;
    uint first = floatBitsToUint(face.b.w), end = first + floatBitsToUint(face.c.w);
    for (uint l = first; l < end; ++l) {
        // Irradiance for radiance 1: power is radiance times area, and the area π times the disc's radius squared.
        float area = PI * lights[l].position.w;
        Arriving light = light_from_disc(lights[l], at.position, vec3(area));
        float unit = light.irradiance.x * max(dot(at.normal, light.direction), 0.0);
        open += unit;
        if (unit > 0.0 && reaches(l, at, light.direction)) lit += unit * lights[l].power.rgb / area;
    }
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
    for (uint i = 0; i < push.count; ++i) {
        sum += HAS_FACES != 0 ? face_light(faces[i], at) : sample_light(i, at);
    }
    direct[pixel] += vec4(sum, 0.0);
}

// What a record contributes to a pixel: its irradiance, extrapolated by the gradients, times its weight; summed by
// additive blending (Gautron et al. 2005).
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/views.glsl"

layout(constant_id = 0) const uint HAS_SKY = 0;
layout(constant_id = 1) const uint HAS_GRADIENTS = 1;
layout(constant_id = 2) const uint WEIGHT = 0;        // 0 bounded (Tabellion and Lamorlette 2004), 1 Ward 1988
layout(constant_id = 3) const uint SIZE = 0;          // texels a side of the hemicubes whose horizons are kept; 0: none are
layout(constant_id = 4) const uint COLUMNS = 2;       // of a side face that are kept
layout(constant_id = 5) const uint COUNTS_FRAGMENTS = 0;  // in the tally, those too that add nothing

layout(set = 0, binding = 0, std430) readonly buffer Records { Kept records[]; };
layout(set = 0, binding = 1, std430) readonly buffer Payloads { KeptPayload payloads[]; };
layout(set = 0, binding = 2, std430) readonly buffer Horizons { uint horizons[]; };
layout(set = 0, binding = 3, std430) readonly buffer Zones { float zones[]; };  // radius of each record of the whole store
layout(set = 0, binding = 4) uniform texture2D gbuffer_position;
layout(set = 0, binding = 5) uniform utexture2D gbuffer_normals;
layout(push_constant) uniform Push { mat4 world_to_view; vec4 scale; float accuracy; float normal_limit; float share; uint first_zone; } push;
#include "splat/hidden.glsl"
layout(location = 0) flat in uint record_index;
layout(location = 0) out vec4 sum;
#ifdef SKY
layout(location = 1) out vec4 sky_sum;
#endif
#ifdef COUNTED
layout(location = COUNTED) out vec4 tally;  // number of records, Σ w·L and Σ w·L² of what they say, L its luminance; fragments
#endif

// `damping`: a linear change is good for something up to R, where what it leaves out is half of E. In a zone that is wider still,
// the change by the offset is damped to stay bounded.
// `move` holds both along the record's axes: the turn (xy) and the offset, damped (zw).
vec3 extrapolated(KeptPayload p, vec4 move) {
    vec3 e = p.irradiance.rgb;
    if (HAS_GRADIENTS != 0) {
        vec3 change = vec3(dot(move, p.change[0]), dot(move, p.change[1]), dot(move, p.change[2]));
        vec3 most = vec3(p.irradiance.w, p.most.xy);
        // Within what the record has evidence for: at least 0; at most a hemisphere full of the brightest thing that it
        // sees, π·L_max; and, for linear growth tells of no more, twice itself. CPU twin: math::ward::extrapolated.
        e = clamp(e + change, vec3(0.0), min(2.0 * e, max(e, most)));
    }
    return e;
}

// The weight of what is rejected: such a fragment is done, but where it counts.
float rejected() {
    if (COUNTS_FRAGMENTS == 0) discard;
    return 0.0;
}

// Weight of a record at the fragment's surface, whose normal is n.
float weight(Kept record, float radius, vec4 surface, vec3 offset, out vec3 n) {
    float distance2 = dot(offset, offset);
    // Every test rejects what is not a number: an additive sum would keep it.
    if (surface.w != 1.0 || !(distance2 < radius * radius)) return rejected();

    n = oct_decode(texelFetch(gbuffer_normals, ivec2(gl_FragCoord.xy), 0).x);
    vec3 nk = record.normal.xyz;
    if (push.normal_limit == 0.0) {  // it stands in on any surface, as it is
        n = nk;
        return push.share * (1.0 - sqrt(distance2) / radius);
    }
    if (!(dot(n, nk) > 0.0)) return rejected();
    // 1 − n·n_k = ½‖n − n_k‖², without the cancellation.
    float bend = length(n - nk) * 0.70710678;
    // In front of the record's surface the record may not see what lights the pixel (Ward 1988).
    if (!(dot(offset, n + nk) * 0.5 >= -0.1 * radius)) return rejected();

    float w;
    if (WEIGHT == 0) {
        w = 1.0 - max(sqrt(distance2) / radius, bend / push.normal_limit);
    } else {
        w = 1.0 / max(sqrt(distance2) / radius * push.accuracy + bend, 1e-6) - 1.0 / push.accuracy;
    }
    if (!(w > 0.0)) return rejected();
    if (SIZE != 0 && hidden(record_index, record, offset)) return rejected();
    return push.share * w;
}

void main() {
    vec4 surface = texelFetch(gbuffer_position, ivec2(gl_FragCoord.xy), 0);
    Kept record = records[record_index];
    vec3 offset = surface.xyz - record.position.xyz, n;
    float radius = zones[push.first_zone + record_index], damping = min(1.0, record.position.w / radius);
    float w = weight(record, radius, surface, offset, n);
    if (COUNTS_FRAGMENTS != 0 && w == 0.0) {
        sum = vec4(0.0);
#ifdef SKY
        sky_sum = vec4(0.0);
#endif
#ifdef COUNTED
        tally = vec4(0.0, 0.0, 0.0, 1.0);
#endif
        return;
    }
    vec3 turn = cross(record.normal.xyz, n), t = record.tangent.xyz, b = cross(record.normal.xyz, t);
    vec4 move = vec4(dot(turn, t), dot(turn, b), damping * dot(offset, t), damping * dot(offset, b));
    sum = vec4(w * extrapolated(payloads[(HAS_SKY + 1) * record_index], move), w);
#ifdef SKY
    sky_sum = vec4(w * extrapolated(payloads[2 * record_index + 1], move), w);
#endif
#ifdef COUNTED
    vec3 said = sum.rgb;
#ifdef SKY
    said += sky_sum.rgb;
#endif
    float luminance = dot(said, vec3(0.2126, 0.7152, 0.0722));  // times w
    tally = vec4(1.0, luminance, luminance * (luminance / w), 1.0);
#endif
}

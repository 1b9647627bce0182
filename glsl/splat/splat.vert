// Splat of a record: a quad on the screen that holds its zone of influence, what of a sphere does not lie far below the record's
// own surface. The eye sees the sphere's outline as a circle before its middle; a rectangle about that, turned so that one side
// is where the zone is cut, holds it. CPU twin: math::zone.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(constant_id = 2) const uint WEIGHT = 0;  // as in the fragment shader

layout(set = 0, binding = 0, std430) readonly buffer Records { Kept records[]; };
layout(set = 0, binding = 3, std430) readonly buffer Zones { float zones[]; };
layout(push_constant) uniform Push {
    mat4 world_to_view;
    vec4 scale;  // ndc = scale.xy·(x, y)/depth; w: 0 parallel
    float accuracy;
    float normal_limit;  // 0: any surface
    float share;  // of the weight that counts
    uint first_zone;
} push;
layout(location = 0) flat out uint record_index;

const float SPARE = 1.001;  // of the rectangle, for rounding

// Bounds on x/depth of a circle around (x, depth).
vec2 tangents(float x, float depth, float r) {
    float root = r * sqrt(max(x * x + depth * depth - r * r, 0.0));
    return (vec2(x * depth) + vec2(-root, root)) / (depth * depth - r * r);
}

// The smallest upright rectangle on the screen that holds a sphere: exact where that is wholly before the eye (EQUATIONS §4;
// tangents from the eye to a circle, an axis at a time), the whole screen where the eye may be in it.
vec2 upright(vec2 corner, vec3 c, float r) {
    float depth = -c.z;
    vec4 bounds = vec4(-1.0, -1.0, 1.0, 1.0);  // left, top, right, bottom in ndc
    if (depth > r) {
        vec2 x = tangents(c.x, depth, r) * push.scale.x, y = tangents(c.y, depth, r) * push.scale.y;
        bounds = vec4(x.x, y.x, x.y, y.y);
    }
    return clamp(mix(bounds.xy, bounds.zw, corner), -1.5, 1.5);
}

// How far below its plane, in radii, a record lights anything.
float depth_below() {
    if (push.normal_limit == 0.0) return 1.0;
    float limit = min(WEIGHT == 0 ? push.normal_limit : push.accuracy, 1.0);
    float half_cos = sqrt(1.0 - 0.5 * limit * limit);
    return sin(asin(0.1 / half_cos) + acos(half_cos));
}

void main() {
    record_index = gl_InstanceIndex;
    vec3 c = (push.world_to_view * vec4(records[gl_InstanceIndex].position.xyz, 1.0)).xyz, n = mat3(push.world_to_view) * records[gl_InstanceIndex].normal.xyz;
    float r = zones[push.first_zone + gl_InstanceIndex];
    bool parallel = push.scale.w == 0.0;
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    if (!(r > 0.0) || (!parallel && !(-c.z >= -r))) {  // not a record, or behind the eye
        gl_Position = vec4(2.0, 2.0, 0.5, 1.0);
        return;
    }
    // A parallel view is one from far away.
    float d = length(c), towards = parallel ? 0.0 : r / d, k = 1.0 - towards * towards, rho = r * sqrt(max(k, 0.0));
    vec3 way = parallel ? vec3(0.0, 0.0, -1.0) : c / d, middle = parallel ? c : c * k;
    // Beside the eye the rectangle may reach behind it.
    if (!parallel && !(-middle.z > 1.5 * rho)) {
        gl_Position = vec4(upright(corner, c, r), 0.5, 1.0);
        return;
    }
    float cosine = -dot(n, way), sine = length(n + cosine * way), below = depth_below(), border = sqrt(1.0 - below * below);
    vec3 any = abs(way.y) < 0.9 ? vec3(way.z, 0.0, -way.x) : vec3(0.0, way.z, -way.y);
    vec3 up = normalize(sine > 1e-3 ? n + cosine * way : any), side = cross(way, up);
    float lower = rho;
    if (towards * r * cosine - rho * sine < -below * r) {
        vec2 borders = vec2(border, -border);
        vec2 reach = r * k * (below * sine - borders * cosine) / (1.0 + towards * (below * cosine + borders * sine));
        lower = clamp(max(reach.x, reach.y), 0.0, rho);
    }
    vec3 p = middle + SPARE * (mix(-lower, rho, corner.x) * up + mix(-rho, rho, corner.y) * side);
    gl_Position = vec4(p.xy * push.scale.xy / (parallel ? 1.0 : -p.z), 0.5, 1.0);
}

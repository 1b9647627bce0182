// Splat of a record: the smallest axis-aligned quad on the screen that holds its zone of influence, a sphere. The bounds
// are exact for a perspective sphere (EQUATIONS §4; tangents from the eye to a circle, an axis at a time).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Records { Record records[]; };
layout(push_constant) uniform Push { mat4 world_to_view; vec4 scale; } push;  // ndc = scale.xy·(x, y)/depth; w: 0 parallel
layout(location = 0) flat out uint record_index;

// Bounds on x/depth of a circle around (x, depth).
vec2 tangents(float x, float depth, float r) {
    float root = r * sqrt(max(x * x + depth * depth - r * r, 0.0));
    return (vec2(x * depth) + vec2(-root, root)) / (depth * depth - r * r);
}

void main() {
    record_index = gl_InstanceIndex;
    vec4 sphere = records[gl_InstanceIndex].position;
    vec3 c = (push.world_to_view * vec4(sphere.xyz, 1.0)).xyz;
    float depth = -c.z, r = sphere.w;
    vec4 bounds = vec4(-1.0, -1.0, 1.0, 1.0);  // left, top, right, bottom in ndc; whole screen for a sphere at the eye
    if (push.scale.w == 0.0) {
        bounds = vec4(c.xy - r, c.xy + r) * push.scale.xyxy;
    } else if (depth > r) {
        vec2 x = tangents(c.x, depth, r) * push.scale.x, y = tangents(c.y, depth, r) * push.scale.y;
        bounds = vec4(x.x, y.x, x.y, y.y);
    }
    bounds = vec4(min(bounds.xy, bounds.zw), max(bounds.xy, bounds.zw));
    if (r <= 0.0 || depth < -r) bounds = vec4(2.0);  // not a record, or behind the eye
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(clamp(mix(bounds.xy, bounds.zw, corner), -1.5, 1.5), 0.5, 1.0);
}

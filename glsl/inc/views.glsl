// The views of a frame: which way each face looks, and which face sees a direction. On every face right × up = forward,
// which shows the world mirrored: a triangle seen from its front winds clockwise. Face 0 looks along the axis.

vec3 to_local(Frame frame, vec3 d) {
    return vec3(dot(frame.tangent.xyz, d), dot(frame.bitangent.xyz, d), dot(frame.normal.xyz, d));
}

vec3 to_world(Frame frame, vec3 d) {
    return d.x * frame.tangent.xyz + d.y * frame.bitangent.xyz + d.z * frame.normal.xyz;
}

// (right, up, forward) of a local direction on face `view`.
vec3 face_coordinates(uint view, vec3 l) {
    switch (view) {
        case 0: return l;
        case 1: return vec3(l.y, l.z, l.x);
        case 2: return vec3(-l.y, l.z, -l.x);
        case 3: return vec3(-l.x, l.z, l.y);
        case 4: return vec3(l.x, l.z, -l.y);
        default: return vec3(l.x, -l.y, -l.z);
    }
}

// The face of a cube that sees the local direction.
uint face_of(vec3 l) {
    vec3 a = abs(l);
    if (a.z >= a.x && a.z >= a.y) return l.z >= 0.0 ? 0 : 5;
    if (a.x >= a.y) return l.x >= 0.0 ? 1 : 2;
    return l.y >= 0.0 ? 3 : 4;
}

// Positive above the plane that a view is cut at: the surface's own, or that of the axis where what is below it would be
// folded over.
float above_horizon(uint views, Frame frame, vec3 p) {
    if (views == VIEWS_HEMISPHERE) return dot(frame.normal.xyz, p - frame.origin.xyz);
    return dot(frame.horizon.xyz, p) + frame.horizon.w;
}

// Whether a direction leads above the frame's horizon; a frame without one sees all directions.
bool is_above(Frame frame, vec3 direction) {
    return frame.horizon.xyz == vec3(0.0) || dot(direction, frame.horizon.xyz) > 0.0;
}

// Clip-space position. Reversed depth: near/forward, so that single precision keeps its relative accuracy at any range.
vec4 project(uint views, uint view, Frame frame, vec3 p) {
    vec3 l = to_local(frame, p - frame.origin.xyz);
    if (views == VIEWS_ORTHOGRAPHIC)
        return vec4(l.x * frame.tangent.w, -l.y * frame.bitangent.w, -l.z * frame.normal.w, 1.0);
    // The direction's xy by way of the division by w. A point between two vertices is not where their chord has it, but
    // straight sides stay shared, and w is never less than the distance: nothing leaves the disc, and what is clipped at
    // the horizon keeps its azimuth.
    if (views == VIEWS_HEMISPHERE) return vec4(l.x, -l.y, frame.origin.w, length(l));
    vec3 f = face_coordinates(view, l);
    f.xy *= vec2(frame.tangent.w, frame.bitangent.w);
    return vec4(f.x, -f.y, frame.origin.w, f.z);
}

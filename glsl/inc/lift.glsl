// How far a point stands off its surface: a share of the size of what is near, which is the radius of the scene's core within it and the
// distance from its centre beyond. `core`: its centre and radius.
float lift_at(vec3 p, vec4 core, float share) { return share * max(core.w, distance(p, core.xyz)); }

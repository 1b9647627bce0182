// What lies beyond what was drawn: slices of voxels (passes/slices.rs).

layout(set = 0, binding = 12) uniform textureBuffer slices;

// What a texel's line of sight meets: light of surfaces, their plane and 1/distance; light of the sky.
struct Sight { vec3 light, plane; float inverse_distance; vec3 beyond; bool back; };

// In voxels: what rounding must not lose at the scene's bounds, where the middles of the outermost slices lie.
const float SPARE = 1e-3;

float least(vec3 v) { return min(v.x, min(v.y, v.z)); }
float most(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Passes the middles of all three axes' slices in the order in which a line meets them (Fournier and Péroche 2005, 5.4). What is
// nearer than `near` was drawn, so that a side counts where what it shows lies beyond that, and half a voxel before what the
// line hits of what was drawn, which has voxels as well. What a side covers of its face it hides of what is behind, as much as is
// not hidden yet: where a surface passes from one slice to the next, one covers what the other leaves free. Sides of two axes may
// hide a line twice, so that edges of what is oblique are seen up to a voxel thicker.
void see_slices(View view, vec3 way, bool hit, inout Sight sight) {
    vec3 d = normalize(way * view.axes), across = max(abs(d), vec3(1e-6));
    vec3 per_length = vec3(push.per_length[0], push.per_length[1], push.per_length[2]);
    vec3 dims = vec3(push.dims[0], push.dims[1], push.dims[2]), strides = vec3(1.0, dims.x, dims.x * dims.y);
    bvec3 up = greaterThan(d, vec3(0.0));
    vec3 sense = mix(vec3(-1.0), vec3(1.0), up);
    // In voxels, and distances along the line from one slice to the next.
    vec3 eye = (view.frame.origin.xyz - vec3(push.low[0], push.low[1], push.low[2])) * per_length, e = d * per_length;
    vec3 steps = 1.0 / (across * per_length), slope = sense * steps;
    vec3 low = vec3(0.5 - SPARE), high = dims - 0.5 + SPARE;
    float enters = most((mix(high, low, up) - eye) * slope), leaves = least((mix(low, high, up) - eye) * slope);
    float farthest = hit ? 1.0 / sight.inverse_distance - 0.5 * push.voxel : 1e30;
    // What a slice shows is half of one from its middle at most.
    vec3 begin = eye + e * max(vec3(enters), push.near - 0.5 * steps) - 0.5;
    vec3 t = (mix(floor(begin), ceil(begin), up) + 0.5 - eye) * slope;
    vec3 side = mix(vec3(1.0, 3.0, 5.0), vec3(0.0, 2.0, 4.0), up) * (dims.x * dims.y * dims.z);
    float free = farthest > push.near ? 1.0 : 0.0, inverse_distance = 0.0, now = least(t);
    vec3 light = vec3(0.0), planes = vec3(0.0);
    if (free == 0.0) return;
    while (now <= leaves && free > 0.0) {
        vec3 axis = t.x == now ? vec3(1.0, 0.0, 0.0) : t.y == now ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
        vec4 shown = texelFetch(slices, int(dot(side, axis) + dot(floor(eye + e * now), strides)));
        float covered = floor(shown.w) / 16.0, there = now + (fract(shown.w) - 0.5) * dot(slope, axis);
        float share = there >= push.near && there < farthest ? min(covered, free) : 0.0;
        float nearness = share / max(there, push.near);
        light += shown.rgb * (share / max(covered, 0.01));
        inverse_distance += nearness;
        planes += axis * nearness;
        free -= share;
        t += axis * steps;
        now = least(t);
    }
    sight.light = light + free * sight.light;
    // The plane of a side, along any unit direction 1/distance.
    sight.plane = view.axes * (planes * sense / across) + free * sight.plane;
    sight.inverse_distance = inverse_distance + free * sight.inverse_distance;
    sight.beyond *= free;
}

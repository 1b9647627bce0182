// Types and constants shared with src/vk/gpu_types.rs, which asserts the same sizes.

const float PI = 3.14159265358979;

// A place to look from: an orthonormal frame, the near distance and the plane below which nothing is seen.
struct Frame {
    vec4 origin;     // xyz, of an orthographic view at its far end; w: near distance
    vec4 tangent;    // xyz; w: 1/tan(half aperture), 1/half width for an orthographic view
    vec4 bitangent;  // xyz; w: the same along the other axis
    vec4 normal;     // xyz: axis; w: 1/depth range of an orthographic view; of a perspective one the share of its depth that matters
    vec4 horizon;    // plane (n, -n·origin): only points with a positive distance are seen; (0, 0, 0, 1) sees all
};

// A record of a batch: its place and validity.
struct Record {
    vec4 position;   // xyz; w: R, in world units, without any limit
    vec4 normal;     // shading normal; w: 1/R, harmonic mean distance, cosine-weighted, not clamped
    vec4 geometric;  // geometric normal on the viewer's side
};

// A record that is kept for any view: where it is, how far it is good for and what its capture saw of its horizon.
struct Kept {
    vec4 position;   // xyz; w: R, in world units, without any limit
    vec4 normal;     // shading normal; w: largest 1/(forward distance) of the horizon (inc/horizon.glsl), 0 without one
    vec4 tangent;    // first axis of the capture; the second is normal × tangent
};

// What an index of kept records holds of each: enough to clamp its neighbours.
struct Entry {
    vec4 place;   // xyz; w: R; negative: the record is not a number and serves nothing
    uvec4 about;  // shading normal, octahedral; the record's number; its reach in world units, as its neighbours clamp it (bits)
};

// What a record carries, once for the light by one reflection and, where there is a sky, once for the sky's own.
struct Payload {
    vec4 irradiance;      // W·m⁻²
    vec4 rotation[3];     // rotation gradient, a world-space vector a colour channel; w: most that the channel can be, π·L_max
    vec4 translation[3];  // translation gradient, likewise
};

// The same of a record that is kept. Gradients lie in its surface: along the axes of its capture, x and y.
struct KeptPayload {
    vec4 irradiance;  // W·m⁻²; w: most that red can be, π·L_max
    vec4 change[3];   // a colour channel: rotation gradient (xy), translation gradient (zw)
    vec4 most;        // most that green and blue can be
};

// One sample of a light: a punctual light, or a point on an emissive triangle.
struct LightSample {
    vec4 position;   // xyz; w: disc radius² of an area sample (its area / π)
    vec4 direction;  // axis: where a directional light goes, a spot points, an emitter faces; w: 1 − cos of a spot's outer angle
    vec4 power;      // irradiance (directional), intensity (point, spot), radiance × area (area sample); w: 1/(cos inner − cos outer)
    vec4 shell;      // about the scene's core, for which its shadow view is: inner and outer radius, 0 where there is no end; 0, 0
};

// An emissive triangle, counter-clockwise seen from where it shines, and its samples in the batch.
struct EmitterFace {
    vec4 a;  // corner; w: share of the triangle's samples that the batch holds
    vec4 b;  // corner; w: first of its samples in the batch, as bits
    vec4 c;  // corner; w: number of them, as bits
};

struct Material {
    vec4 base_color;
    vec4 emission;            // radiance; w: normal map scale
    vec4 base_uv[2];          // rows of the texture transform for (u, v, 1); [0].w: texture coordinate set
    vec4 normal_uv[2];
    vec4 emission_uv[2];
    vec4 alpha;               // x: cutoff
};

// Kinds of views of a frame.
const uint VIEWS_HEMICUBE = 0;      // five faces, the sides cut at the frame's horizon
const uint VIEWS_CUBE = 1;          // six faces
const uint VIEWS_PLANE = 2;         // one perspective view along the axis
const uint VIEWS_ORTHOGRAPHIC = 3;  // one parallel view along the axis
const uint VIEWS_HEMISPHERE = 4;    // all that lies above the axis's own horizon, projected onto the disc below it

// Kinds of light samples.
const uint LIGHT_DIRECTIONAL = 0;
const uint LIGHT_POINT = 1;
const uint LIGHT_SPOT = 2;
const uint LIGHT_AREA = 3;

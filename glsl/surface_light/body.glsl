// Lights the surface cells of one material: adds, for each light sample of the current batch of shadow views, the
// radiance that a cell reflects to its front and to its back. Each pair of cell and light sample uses a point of its own
// in the cell, so that the cell's mean over many samples is a mean over its area too.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "inc/oct.glsl"
#include "inc/hash.glsl"
#include "inc/views.glsl"
layout(local_size_x = 64) in;
#include "inc/invocation.glsl"
#include "inc/scene.glsl"
#include "inc/material_constants.glsl"
#include "inc/material_textures.glsl"
#include "inc/vertex_streams.glsl"
#include "inc/surface.glsl"
layout(constant_id = 8) const uint LIGHT_KIND = 0;
layout(constant_id = 9) const uint SHADOW_VIEWS = 0;
layout(constant_id = 10) const uint SHADOW_SIZE = 256;
layout(constant_id = 11) const uint SHADOW_COLUMNS = 1;

layout(set = LIGHT_SET, binding = 0, std430) readonly buffer Lights { LightSample lights[]; };
layout(set = LIGHT_SET, binding = 1, std430) readonly buffer Frames { Frame frames[]; };
layout(set = LIGHT_SET, binding = 2) uniform texture2DArray shadow_depth;
layout(set = LIGHT_SET, binding = 3, std430) readonly buffer FirstCell { uint first_cell[]; };
layout(set = LIGHT_SET, binding = 4, std430) readonly buffer CellTriangle { uint cell_triangle[]; };
layout(set = LIGHT_SET, binding = 5, std430) buffer CellRadiance { float cell_radiance[]; };
layout(push_constant) uniform Push {
    uint material;
    uint first;        // cell
    uint count;
    uint first_light;  // of the batch
    uint light_count;
    uint points;       // points in a cell for each light sample
    float lift;
} push;

#include "inc/cells.glsl"
#include "inc/light.glsl"
#include "inc/shadow.glsl"

// The s-th point of a cell's triangle: R2 sequence (Roberts 2018), turned by the cell, folded.
vec2 point_in_cell(uint cell, uint s) {
    vec2 turn = vec2(unit_float(pcg(cell)), unit_float(pcg(cell ^ 0x9e3779b9u)));
    vec2 p = fract(turn + vec2(0.7548776662466927, 0.5698402909980532) * float(s + 1));
    return p.x + p.y > 1.0 ? 1.0 - p : p;
}

void main() {
    uint at = invocation();
    if (at >= push.count) return;
    uint cell = push.first + at;
    uint triangle = cell_triangle[cell];
    uint first = first_cell[triangle], r = cell_resolution(first_cell[triangle + 1] - first);
    uvec3 c = corners_of(triangle);
    vec3 p0 = position_of(c.x), e1 = position_of(c.y) - p0, e2 = position_of(c.z) - p0;
    vec3 geometric = normalize(cross(e1, e2));
    Material material = materials[push.material];

    vec3 front = vec3(0.0), back = vec3(0.0);
    for (uint l = 0; l < push.light_count; ++l) {
        for (uint s = 0; s < push.points; ++s) {
            vec2 uv = cell_point(r, cell - first, point_in_cell(cell, (push.first_light + l) * push.points + s));
            vec3 p = p0 + uv.x * e1 + uv.y * e2;
            Arriving light = light_arriving(lights[l], p);
            float side = dot(geometric, light.direction);
            vec3 lifted = p + geometric * (side >= 0.0 ? push.lift : -push.lift);
            if (!any(greaterThan(light.irradiance, vec3(0.0))) || !is_lit(l, lifted, geometric)) continue;
            vec3 b = vec3(1.0 - uv.x - uv.y, uv);
            vec3 normal = b.x * oct_decode(normals[c.x]) + b.y * oct_decode(normals[c.y]) + b.z * oct_decode(normals[c.z]);
            float length2 = dot(normal, normal);
            normal = length2 > 1e-12 ? normal * inversesqrt(length2) : geometric;
            Surface surface = surface_at(material,
                b.x * uv0_of(c.x) + b.y * uv0_of(c.y) + b.z * uv0_of(c.z),
                b.x * uv1_of(c.x) + b.y * uv1_of(c.y) + b.z * uv1_of(c.z),
                b.x * color_of(c.x) + b.y * color_of(c.y) + b.z * color_of(c.z), normal,
                b.x * tangent_of(c.x) + b.y * tangent_of(c.y) + b.z * tangent_of(c.z));
            if (dot(surface.normal, geometric) < 0.0) surface.normal = -surface.normal;
            vec3 leaving = surface.albedo.rgb * light.irradiance / (PI * float(push.points));
            float cosine = dot(surface.normal, light.direction);
            if (side > 0.0) front += leaving * max(cosine, 0.0);
            else back += leaving * max(-cosine, 0.0);
        }
    }
    for (int k = 0; k < 3; ++k) {
        cell_radiance[6 * cell + k] += front[k];
        cell_radiance[6 * cell + 3 + k] += back[k];
    }
}

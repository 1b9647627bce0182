// The slices along one axis: places turned so that z leads along it. Wants Push.
const uint SAMPLES = 4;  // a side of a voxel's face; src/math/slices.rs

layout(push_constant) uniform Push {
    float low[3];
    float per_length[3];  // voxels
    uint dims[3];
    uint axis;
    uint phase;  // of rasterise.comp: 0 finds the outermost surface of each sample, 1 its cell
    uint triangles;
    uint first_coarse_cell;
} push;

vec3 turned(vec3 p) { return push.axis == 0 ? p.yzx : push.axis == 1 ? p.zxy : p; }

uvec3 turned(uvec3 p) { return push.axis == 0 ? p.yzx : push.axis == 1 ? p.zxy : p; }

uvec3 turned_back(uvec3 p) { return push.axis == 0 ? p.zxy : push.axis == 1 ? p.yzx : p; }

uvec3 dims() { return uvec3(push.dims[0], push.dims[1], push.dims[2]); }

uint sample_at(uvec3 at) {
    uvec2 across = turned(dims()).xy * SAMPLES;
    return (at.z * across.y + at.y) * across.x + at.x;
}

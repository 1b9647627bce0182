// Reads an irradiance volume: the twin of hemicube::volume::Reader, but for the cubic interpolation. Wants ORDER (of the harmonics),
// HAS_GRADIENTS and HAS_MOMENTS as constants, and as arrays
//   uint volume_nodes[];      nine a cell: its first child or 0, and the points at its corners
//   uvec2 volume_points[];    of each point the first of its shares, and how many it has
//   uvec2 volume_shares[];    sample, weight (bits)
//   float volume_samples[];   volume_stride() a sample: position, 1 where it is inside of geometry, moments of the distance (two for
//                             each of 8 x 8 cells of an octahedron), coefficients (rgb), gradients (of each coefficient x: rgb, y, z)
struct Volume {
    vec3 low, high;    // the box
    uvec3 divisions;   // cells of level 0
};

// Ways to interpolate.
const uint VOLUME_TRILINEAR = 0, VOLUME_INVERSE_DISTANCE = 1, VOLUME_BY_GRADIENTS = 2;

const uint VOLUME_COUNT = ORDER * ORDER, VOLUME_SIDE = 8;
const uint VOLUME_COEFFICIENTS = 4 + (HAS_MOMENTS != 0 ? 2 * VOLUME_SIDE * VOLUME_SIDE : 0);

uint volume_stride() { return VOLUME_COEFFICIENTS + (HAS_GRADIENTS != 0 ? 12 : 3) * VOLUME_COUNT; }

vec3 volume_rgb(uint at) { return vec3(volume_samples[at], volume_samples[at + 1], volume_samples[at + 2]); }

// A cell of the map one outside of it at most: across a side the map goes on turned by half about the side's middle.
uint volume_cell(ivec2 at) {
    const int side = int(VOLUME_SIDE);
    if (at.x < 0 || at.x >= side) at = ivec2(clamp(at.x, 0, side - 1), side - 1 - at.y);
    if (at.y < 0 || at.y >= side) at = ivec2(side - 1 - at.x, clamp(at.y, 0, side - 1));
    return uint(at.y * side + at.x);
}

// How much of the distances with these moments reaches as far as `distance_` (hemicube::volume::visibility).
float volume_reaching(float distance_, vec2 moments) {
    if (distance_ <= moments.x) return 1.0;
    float variance = max(moments.y - moments.x * moments.x, 1e-6 * moments.x * moments.x), beyond = distance_ - moments.x;
    float share = variance / (variance + beyond * beyond), weight = share * share * share;
    return weight < 0.2 ? weight * weight * weight / 0.04 : weight;
}

const float VOLUME_HIDDEN = 1e-9;

// Geometric mean over the cells of directions around that of `offset`.
float volume_open(uint moments, vec3 offset, float distance_) {
    vec2 p = offset.xy / (abs(offset.x) + abs(offset.y) + abs(offset.z));
    if (offset.z < 0.0) p = (1.0 - abs(p.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0)));
    vec2 at = (p + 1.0) * (0.5 * float(VOLUME_SIDE)) - 0.5, low = floor(at), f = at - low;
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 upper = ivec2(i & 1, i >> 1);
        vec2 share = mix(1.0 - f, f, vec2(upper));
        uint cell = moments + 2 * volume_cell(ivec2(low) + upper);
        float reaching = volume_reaching(distance_, vec2(volume_samples[cell], volume_samples[cell + 1]));
        sum += share.x * share.y * log(max(reaching, VOLUME_HIDDEN));
    }
    return exp(sum);
}

float volume_visibility(uint first, vec3 offset, bool guarded) {
    if (volume_samples[first + 3] != 0.0) return 1e-14;
    float distance_ = length(offset);
    if (!guarded || HAS_MOMENTS == 0 || distance_ == 0.0) return 1.0;
    return volume_open(first + 4, offset, distance_);
}

// Radiance coefficients at a point of the box.
void read_volume(Volume volume, vec3 point, uint way, bool guarded, out vec3 coefficients[VOLUME_COUNT]) {
    vec3 cells = vec3(volume.divisions);
    vec3 at = clamp((point - volume.low) / (volume.high - volume.low) * cells, vec3(0.0), cells);
    vec3 whole = min(floor(at), cells - 1.0), t = at - whole;
    uvec3 root = uvec3(whole);
    uint node = root.x + volume.divisions.x * (root.y + volume.divisions.y * root.z);
    while (volume_nodes[9 * node] != 0) {
        bvec3 upper = greaterThanEqual(t, vec3(0.5));
        t = 2.0 * t - vec3(upper);
        node = volume_nodes[9 * node] + uint(upper.x) + 2 * uint(upper.y) + 4 * uint(upper.z);
    }
    for (uint c = 0; c < VOLUME_COUNT; ++c) coefficients[c] = vec3(0.0);
    float all = 0.0, nearest = 1e-6 * length(volume.high - volume.low);
    for (uint corner = 0; corner < 8; ++corner) {
        vec3 sides = mix(1.0 - t, t, vec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1));
        float of_corner = sides.x * sides.y * sides.z;
        if (of_corner == 0.0) continue;
        uvec2 shares = volume_points[volume_nodes[9 * node + 1 + corner]];
        for (uint i = shares.x; i < shares.x + shares.y; ++i) {
            uint first = volume_shares[i].x * volume_stride();
            vec3 offset = point - volume_rgb(first);
            float weight = of_corner * uintBitsToFloat(volume_shares[i].y) * volume_visibility(first, offset, guarded);
            if (way == VOLUME_INVERSE_DISTANCE) weight /= max(length(offset), nearest);
            all += weight;
            for (uint c = 0; c < VOLUME_COUNT; ++c) {
                vec3 value = volume_rgb(first + VOLUME_COEFFICIENTS + 3 * c);
                if (HAS_GRADIENTS != 0 && way == VOLUME_BY_GRADIENTS) {
                    uint slopes = first + VOLUME_COEFFICIENTS + 3 * VOLUME_COUNT + 9 * c;
                    value += mat3(volume_rgb(slopes), volume_rgb(slopes + 3), volume_rgb(slopes + 6)) * offset;
                }
                coefficients[c] += weight * value;
            }
        }
    }
    for (uint c = 0; c < VOLUME_COUNT; ++c) coefficients[c] /= all;
}

// Whether something stands between a record and a point, by the horizon that it keeps: light must not pass a thin wall, nor reach
// around an edge, from a record on the other side. CPU twin: math::visibility. Wants `horizons`, COLUMNS and SIZE.
#include "inc/horizon.glsl"

const float HIDDEN_TOLERANCE = 0.1;  // of the distance
const float LARGEST_INVERSE = 3e38;

// Slope of a kept row: height over forward distance.
float slope_of(uint row) { return (2.0 * float(horizon_row(row, int(SIZE))) + 1.0) / float(SIZE); }

bool hidden(uint number, Kept record, vec3 offset) {
    vec3 n = record.normal.xyz, t = record.tangent.xyz;
    vec3 l = vec3(dot(t, offset), dot(cross(n, t), offset), dot(n, offset));
    float reach = max(abs(l.x), abs(l.y));
    if (l.z >= reach) return false;  // above the sides: no thin wall stands so
    uint view = face_of(vec3(l.xy, 0.0));
    vec3 f = face_coordinates(view, l);
    float slope = f.y / f.z, x = (f.x / f.z * 0.5 + 0.5) * float(COLUMNS) - 0.5;
    // Before a face's first centre and past its last the line goes on.
    uint column = uint(clamp(int(floor(x)), 0, int(COLUMNS) - 2)), at = 4 * COLUMNS * number + COLUMNS * (view - 1) + column;
    x -= float(column);
    // The further of two rows: on a concave surface the lower one sees the surface before the point. What lies below the lowest
    // row is taken for seen along it.
    uint row = 0;
    while (row < HORIZON_ROWS - 1 && slope >= slope_of(row)) ++row;
    float nearest = LARGEST_INVERSE;
    for (uint k = slope >= slope_of(0) ? row - 1 : row; k <= row; ++k) {
        uint word = HORIZON_WORDS * at + k / 4;
        uvec2 here = uvec2(horizons[word], horizons[word + HORIZON_WORDS]) >> (8 * (k % 4)) & 255u;
        float largest = record.normal.w;
        nearest = min(nearest, mix(horizon_value(here.x, largest), horizon_value(here.y, largest), x));
    }
    return f.z * nearest > 1.0 + HIDDEN_TOLERANCE;
}

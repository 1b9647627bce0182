// Radiance that leaves a cell. Wants `cell_radiance`.
vec3 cell_light(uint cell, bool front) {
    uint at = 6 * cell + (front ? 0 : 3);
    return vec3(cell_radiance[at], cell_radiance[at + 1], cell_radiance[at + 2]);
}

// Corners of a triangle. Wants `positions` and `indices`.

vec3 position_of(uint vertex) {
    return vec3(positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]);
}

uvec3 corners_of(uint triangle) {
    return uvec3(indices[3 * triangle], indices[3 * triangle + 1], indices[3 * triangle + 2]);
}

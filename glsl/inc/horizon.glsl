// What a record keeps of the distances that its hemicube saw, to tell what is hidden from it: of each column of the side faces
// 1/(forward distance) in eight rows, a byte each. A byte is the logarithm of its value relative to the record's largest, rounded up;
// 0: nothing is seen there, or nothing that near. CPU twin: math::visibility.

const uint HORIZON_ROWS = 8;
const uint HORIZON_WORDS = HORIZON_ROWS / 4;  // of a column
const float HORIZON_OCTAVES = 16.0;  // range of the values

// Row of the table's kept rows, counted upwards from the lowest, of faces of `size` texels.
int horizon_row(uint kept, int size) {
    const uint rows[HORIZON_ROWS] = uint[](0, 1, 2, 3, 5, 8, 11, 15);  // of 32 texels
    return min(max(int(kept), int(rows[kept]) * size / 32), size / 2 - 1);
}

uint horizon_byte(float value, float largest) {
    if (!(value > 0.0)) return 0;
    return uint(clamp(ceil(255.0 + log2(value / largest) * (255.0 / HORIZON_OCTAVES)), 0.0, 255.0));
}

float horizon_value(uint byte, float largest) {
    return byte == 0 ? 0.0 : largest * exp2((float(byte) - 255.0) * (HORIZON_OCTAVES / 255.0));
}

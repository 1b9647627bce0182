// Hashing: pcg3d-like scalar PCG (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").

uint pcg(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

float unit_float(uint v) { return float(v >> 8) * (1.0 / 16777216.0); }

// The index of kept records: their entries sorted by place, and a box about every group of them.

const uint GROUP = 64;
const float LARGEST = 3e38;

struct Group {
    vec4 low;   // least coordinates; w: least R
    vec4 high;  // greatest coordinates
};

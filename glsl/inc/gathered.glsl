// What each texel of a capture sees, one or more values after each other: radiance and 1/distance; the sky's radiance, where
// there is one; for the translation gradient the plane of what is seen, local: along any unit direction its dot product is
// 1/distance from the frame's origin; w: the number of the triangle that it is of, plus 1, 0 for none, tagged, with BACK_SEEN where the
// triangle's back is seen. Wants HAS_SKY and HAS_TRANSLATION.
const uint STRIDE = 1 + HAS_SKY + HAS_TRANSLATION;

// Numbers as bits of floats that no device takes for a denormal one.
const uint TAG = 0x40000000u;
const uint BACK_SEEN = 0x20000000u;  // above every number

float tagged(uint number) { return uintBitsToFloat(number | TAG); }
uint untagged(float number) { return floatBitsToUint(number) & ~(TAG | BACK_SEEN); }
bool is_back(float number) { return (floatBitsToUint(number) & BACK_SEEN) != 0; }

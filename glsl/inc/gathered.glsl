// What each texel of a capture sees, one or more values after each other: radiance and 1/distance; the sky's radiance, where
// there is one; for the translation gradient the plane of what is seen, local: along any unit direction its dot product is
// 1/distance from the frame's origin. Wants HAS_SKY and HAS_TRANSLATION.
const uint STRIDE = 1 + HAS_SKY + HAS_TRANSLATION;

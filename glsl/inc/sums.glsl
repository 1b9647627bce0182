// Sums over what a record sees, one float each: of each kind of light E and Σ w/d, ∇_r E and ∇_t E channel by channel, and
// the largest radiance; then the second derivatives of E of all light: xx, xy, yy. Wants HAS_SKY and HAS_TRANSLATION.
const uint ROTATION = 4, TRANSLATION = 10, PEAK = 16, LIGHT = 19, BEND = LIGHT * (1 + HAS_SKY);
const uint SUMS = BEND + 9 * HAS_TRANSLATION;

// What edges between texels add: ∇_t E = −Σ (L_i − L_j)·tan(γ/2)·n·(a+b)·m / r over all of them, in x and y, and
// H = −4 Σ (L_i − L_j) sym(step ⊗ ω) / r².
//
// H is the derivative of ∇_t E, an edge in the direction ω staying where it is in space: with w = M − x from the point to an
// edge's middle M, D along it, the step over r is (n·w)(D×w)/|w|⁴; x in the tangent plane leaves n·w as it is, D×w changes
// by an antisymmetric part alone, and |w|⁻⁴ by 4w/|w|⁶. The light of the sky and of surfaces together.
struct Slide { vec3 lit_x, lit_y, open_x, open_y, xx, xy, yy; };

Slide no_slide() {
    return Slide(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
}

// 1/distance where a plane meets an edge, by the nearest that is seen: planes seen edge-on are extrapolated to three times the
// distance's inverse at most, evenly both ways.
float bounded(float at_edge, float nearest) { return clamp(at_edge, -nearest, 3.0 * nearest); }

// An edge over which light grows by `lit` and the sky's by `open`. `at_edge` is 1/distance of what moves there: the nearer
// surface, where its plane meets the edge, not at the texel's centre. An outline lies within half a texel of the edge that
// stands for it, on either side alike, so that the error is of second order in the texel's width; with the centre's
// distance, which is always further inside, it is of first. H is by the texels' own distances: what is extrapolated would be
// squared.
void slide_over(inout Slide slide, vec3 lit, vec3 open, vec2 step_, vec3 bend, float at_edge, float nearest) {
    vec2 moved = step_ * bounded(at_edge, nearest);
    slide.lit_x += lit * moved.x;
    slide.lit_y += lit * moved.y;
    if (HAS_SKY != 0) {
        slide.open_x += open * moved.x;
        slide.open_y += open * moved.y;
        lit += open;
    }
    bend *= nearest * nearest;
    slide.xx += lit * bend.x;
    slide.xy += lit * bend.y;
    slide.yy += lit * bend.z;
}

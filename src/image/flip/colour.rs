//! The colour spaces of FLIP: opponent space for filtering, CIELAB with the Hunt effect for distances.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", sections 4.1 and 4.1.1.

use crate::image::tone::srgb_decode;

/// Linear sRGB to CIE XYZ as the quotients of integers that the sRGB primaries and D65 lead to. Rows.
const TO_XYZ: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// Its inverse. Rows.
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

/// XYZ of white, which is the sum of each row of [`TO_XYZ`].
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

fn multiply(rows: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ of a linear colour, each relative to white.
fn relative_xyz(linear: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = multiply(&TO_XYZ, linear);
    [x / WHITE[0], y / WHITE[1], z / WHITE[2]]
}

/// sRGB code values to the linear opponent space YCxCz (Flohr et al. 1993).
pub fn ycxcz(coded: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(coded.map(srgb_decode));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// YCxCz to linear sRGB, cut to what a screen can show.
pub fn linear_of_ycxcz([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
    multiply(&FROM_XYZ, xyz).map(|value| value.clamp(0.0, 1.0))
}

/// Linear sRGB to CIELAB whose chroma shrinks with the lightness (Hunt 1952).
pub fn hunt_lab(linear: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let root = |t: f32| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(linear).map(root);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Distance for large differences (Abasi et al. 2020): city block in lightness, Euclidean in chroma.
pub fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Exponent of the distance, and the two points of its map to 0…1 (section 4.1.1).
const QC: f32 = 0.7;
const PC: f32 = 0.4;
const PT: f32 = 0.95;

/// Largest distance between two colours of a screen, pure green and pure blue, to the power of [`QC`].
pub fn largest_distance() -> f32 {
    hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC)
}

/// Colour difference from 0 to 1 of two linear colours; `largest` is [`largest_distance`].
pub fn difference(a: [f32; 3], b: [f32; 3], largest: f32) -> f32 {
    let distance = hyab(hunt_lab(a), hunt_lab(b)).powf(QC);
    let knee = PC * largest;
    if distance < knee { PT / knee * distance } else { PT + (distance - knee) / (largest - knee) * (1.0 - PT) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opponent_space_inverts() {
        for coded in [[0.0; 3], [1.0; 3], [0.2, 0.7, 0.4], [0.9, 0.05, 0.5]] {
            let back = linear_of_ycxcz(ycxcz(coded));
            assert!((0..3).all(|k| (back[k] - srgb_decode(coded[k])).abs() < 1e-5), "{coded:?}: {back:?}");
        }
    }

    #[test]
    fn differences_run_from_0_to_1() {
        let largest = largest_distance();
        assert_eq!(difference([0.3; 3], [0.3; 3], largest), 0.0);
        assert!((difference([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], largest) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn white_has_lightness_100_and_no_chroma() {
        let [l, a, b] = hunt_lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-3 && a.abs() < 1e-2 && b.abs() < 1e-2, "{l} {a} {b}");
    }
}

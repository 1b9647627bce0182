//! Coefficients of the radiance in the units of engines.

use super::Light;
use crate::math::sh;
use glam::DVec3;
use std::f64::consts::PI;

/// Godot's coefficients: those of the radiance over π.
pub fn godot(light: &Light) -> Light {
    light.map(|c| c / PI)
}

/// Unity's coefficients: E/π is their sum times 1; y, z, x; xy, yz, 3z² − 1, xz, x² − y². The x axis is flipped as glTFast flips it,
/// which changes the signs of x, xy and xz.
pub fn unity(light: &Light) -> Light {
    let factors = polynomial_factors();
    let sign = |i: usize| if matches!(i, 3 | 4 | 7) { -1.0 } else { 1.0 };
    std::array::from_fn(|i| sign(i) * sh::cosine_factor(i.isqrt() as u32) / PI * factors[i] * light[i])
}

/// The factors that make the polynomials orthonormal.
fn polynomial_factors() -> [f64; 9] {
    let [zero, one, two] = [1.0, 3.0, 15.0].map(|n: f64| (n / (4.0 * PI)).sqrt());
    [zero, one, one, one, two, two, (5.0 / (16.0 * PI)).sqrt(), two, 0.5 * two]
}

/// Bevy's ambient cube: the faces +x, −x, +y, −y, +z, −z. Bevy's shader returns Σ nᵢ² · face(sign nᵢ). These faces are the least-squares
/// fit of that to E/π over all directions. The exact values on the axes ([`bevy_exact`]) are a worse choice: the guide has both errors
/// ([`crate::guide::volumes`]).
pub fn bevy(light: &Light) -> [DVec3; 6] {
    let mut sums = [DVec3::ZERO; 6];
    for (n, weight) in sh::sphere_rule(6) {
        let value = super::e_over_pi(light, n);
        squares(n).iter().zip(&mut sums).for_each(|(square, sum)| *sum += weight * *square * value);
    }
    solved(sums)
}

/// E/π along the six axes.
pub fn bevy_exact(light: &Light) -> [DVec3; 6] {
    let [x, y, z] = DVec3::AXES;
    [x, -x, y, -y, z, -z].map(|n| super::e_over_pi(light, n))
}

/// The weights that Bevy's shader gives the faces for the normal `n`.
pub fn squares(n: DVec3) -> [f64; 6] {
    let of = |axis: usize, sign: f64| if sign * n[axis] > 0.0 { n[axis] * n[axis] } else { 0.0 };
    [of(0, 1.0), of(0, -1.0), of(1, 1.0), of(1, -1.0), of(2, 1.0), of(2, -1.0)]
}

/// Solves the normal equations of the fit. The integral of a face's squared weight is 2π/5, of its product with the weight of a face
/// beside it π/15, and with that of the opposite face 0. The eigenvectors are the sum of all faces, the difference of opposite ones, and the
/// rest of a pair.
fn solved(sums: [DVec3; 6]) -> [DVec3; 6] {
    let (own, beside) = (2.0 * PI / 5.0, PI / 15.0);
    let mean = sums.iter().sum::<DVec3>() / 6.0;
    std::array::from_fn(|i| {
        let opposite = sums[i ^ 1];
        let pair = (sums[i] + opposite) / 2.0;
        mean / (own + 4.0 * beside) + (sums[i] - pair) / own + (pair - mean) / (own - 2.0 * beside)
    })
}

//! Real spherical harmonics of order 1 to 6: the basis of light that comes from all directions.
//!
//! Convention, the same in every file that this crate reads or writes: orthonormal over the sphere, no Condon–Shortley
//! sign, coefficient l² + l + m at degree l and −l ≤ m ≤ l, negative m for the sine. So the first nine are constants times
//! 1; y, z, x; xy, yz, 3z² − 1, xz, x² − y². An expansion of order N has the degrees below N: N² coefficients.

use super::quadrature::gauss_legendre;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

/// The highest order.
pub const MAX_ORDER: u32 = 6;

/// Coefficients of an expansion of this order.
pub fn count(order: u32) -> usize {
    (order * order) as usize
}

/// Values of all harmonics of an expansion in the unit direction `d`: `out` has [`count`]`(order)` places.
pub fn evaluate(order: u32, d: DVec3, out: &mut [f64]) {
    angular(order, d.z, [d.x, d.y], out);
}

/// P_l^m(z)·(cos mφ or sin mφ), orthonormal over the sphere, where `across` is (cosφ, sinφ)·√(1 − z²). `hsh` gives it
/// coordinates of another sphere.
pub(super) fn angular(order: u32, z: f64, across: [f64; 2], out: &mut [f64]) {
    // (x + iy)^m, and P_m^m over √(1 − z²)^m: both grow from one m to the next.
    let (mut cosine, mut sine) = (1.0, 0.0);
    let mut diagonal = (4.0 * PI).sqrt().recip();
    for m in 0..order {
        if m > 0 {
            (cosine, sine) = (cosine * across[0] - sine * across[1], cosine * across[1] + sine * across[0]);
            diagonal *= (1.0 + 0.5 / f64::from(m)).sqrt();
        }
        let (mut before, mut now) = (0.0, diagonal);
        for l in m..order {
            if l > m {
                (before, now) = (now, next_degree(l, m, z, now, before));
            }
            let middle = (l * l + l) as usize;
            if m == 0 {
                out[middle] = now;
            } else {
                out[middle + m as usize] = SQRT_2 * now * cosine;
                out[middle - m as usize] = SQRT_2 * now * sine;
            }
        }
    }
}

/// The normalised associated Legendre function of degree l by those of l − 1 and l − 2.
fn next_degree(l: u32, m: u32, z: f64, one_less: f64, two_less: f64) -> f64 {
    let [l2, m2, k2] = [l * l, m * m, (l - 1) * (l - 1)].map(f64::from);
    let scale = ((4.0 * l2 - 1.0) / (l2 - m2)).sqrt();
    scale * (z * one_less - ((k2 - m2) / (4.0 * k2 - 1.0)).sqrt() * two_less)
}

/// A_l: the factor of degree l by which radiance becomes irradiance (Ramamoorthi and Hanrahan 2001, eq. 8): π, 2π/3, π/4, 0,
/// −π/24, 0 …
pub fn cosine_factor(l: u32) -> f64 {
    match l {
        1 => TAU / 3.0,
        _ if !l.is_multiple_of(2) => 0.0,
        _ => {
            // l!/(2^l (l/2)!²)
            let central: f64 = (1..=l / 2).map(|k| (2.0 * f64::from(k) - 1.0) / (2.0 * f64::from(k))).product();
            let sign = if l.is_multiple_of(4) { -1.0 } else { 1.0 };
            let l = f64::from(l);
            sign * TAU * central / ((l + 2.0) * (l - 1.0))
        }
    }
}

/// Irradiance, W·m⁻², on a surface of the unit normal `n` by radiance of these coefficients, W·sr⁻¹·m⁻².
pub fn irradiance(coefficients: &[f64], n: DVec3) -> f64 {
    let order = coefficients.len().isqrt() as u32;
    let mut harmonics = vec![0.0; count(order)];
    evaluate(order, n, &mut harmonics);
    let degree = |i: usize| i.isqrt() as u32;
    coefficients.iter().zip(&harmonics).enumerate().map(|(i, (c, h))| cosine_factor(degree(i)) * c * h).sum()
}

/// The coefficients of the function turned by `rotation`: its value in the direction R·d is what it was in d.
///
/// Projected anew by a product rule that is exact for the degrees that occur.
pub fn rotated(coefficients: &[f64], rotation: DMat3) -> Vec<f64> {
    let order = coefficients.len().isqrt() as u32;
    let (mut old, mut new) = (vec![0.0; count(order)], vec![0.0; count(order)]);
    let mut turned = vec![0.0; count(order)];
    for (d, weight) in sphere_rule(order) {
        evaluate(order, rotation.transpose() * d, &mut old);
        evaluate(order, d, &mut new);
        let value: f64 = old.iter().zip(coefficients).map(|(h, c)| h * c).sum();
        turned.iter_mut().zip(&new).for_each(|(sum, h)| *sum += weight * value * h);
    }
    turned
}

/// Directions and solid angles of a rule that integrates products of two harmonics of an expansion exactly.
pub fn sphere_rule(order: u32) -> Vec<(DVec3, f64)> {
    let turns = 2 * order;
    let ring = |(t, weight): (f64, f64)| {
        let z = 2.0 * t - 1.0;
        let radius = (1.0 - z * z).sqrt();
        (0..turns).map(move |i| {
            let (sine, cosine) = (TAU * f64::from(i) / f64::from(turns) + FRAC_PI_2).sin_cos();
            (DVec3::new(radius * cosine, radius * sine, z), 2.0 * weight * TAU / f64::from(turns))
        })
    };
    gauss_legendre(order + 1).into_iter().flat_map(ring).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, dvec3};

    fn harmonics(order: u32, d: DVec3) -> Vec<f64> {
        let mut out = vec![0.0; count(order)];
        evaluate(order, d, &mut out);
        out
    }

    fn projected(order: u32, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; count(order)];
        for (d, weight) in sphere_rule(MAX_ORDER) {
            sums.iter_mut().zip(harmonics(order, d)).for_each(|(sum, h)| *sum += weight * f(d) * h);
        }
        sums
    }

    #[test]
    fn they_are_orthonormal() {
        let order = MAX_ORDER;
        let mut products = vec![0.0; count(order) * count(order)];
        for (d, weight) in sphere_rule(order) {
            let h = harmonics(order, d);
            for (i, a) in h.iter().enumerate() {
                h.iter().enumerate().for_each(|(j, b)| products[i * count(order) + j] += weight * a * b);
            }
        }
        for (at, product) in products.iter().enumerate() {
            let expected = f64::from(u8::from(at / count(order) == at % count(order)));
            assert!((product - expected).abs() < 1e-12, "{at}: {product}");
        }
    }

    #[test]
    fn the_first_nine_have_the_stated_order_and_signs() {
        let d = dvec3(0.48, -0.6, 0.64);
        let (x, y, z) = (d.x, d.y, d.z);
        let [a, b] = [(3.0 / (4.0 * PI)).sqrt(), (15.0 / (4.0 * PI)).sqrt()];
        let (c, half) = ((5.0 / (16.0 * PI)).sqrt(), 0.5 * b);
        let zz = c * (3.0 * z * z - 1.0);
        let expected =
            [0.5 / PI.sqrt(), a * y, a * z, a * x, b * x * y, b * y * z, zz, b * x * z, half * (x * x - y * y)];
        for (got, expected) in harmonics(3, d).iter().zip(expected) {
            assert!((got - expected).abs() < 1e-14, "{got} {expected}");
        }
    }

    #[test]
    fn cosine_factors_are_those_of_the_clamped_cosine() {
        let expected = [PI, TAU / 3.0, PI / 4.0, 0.0, -PI / 24.0, 0.0];
        for (l, expected) in (0..).zip(expected) {
            // ∫ cosθ Y_l0 dω over the hemisphere is A_l·√((2l+1)/4π).
            let by_rule: f64 = gauss_legendre(12)
                .iter()
                .map(|(z, w)| TAU * w * z * harmonics(MAX_ORDER, dvec3((1.0 - z * z).sqrt(), 0.0, *z))[l * l + l])
                .sum();
            let normal = ((2.0 * l as f64 + 1.0) / (4.0 * PI)).sqrt();
            let factor = cosine_factor(l as u32);
            assert!((factor - expected).abs() < 1e-14 && (by_rule / normal - expected).abs() < 1e-13, "{l}: {factor}");
        }
    }

    /// Constant, linear and quadratic skies: ∫ L cosθ dω over the hemisphere about n is πL₀, (2π/3) L₁·n, and
    /// (π/4) Σ Q_ij n_i n_j for a symmetric Q without trace.
    #[test]
    fn irradiance_of_skies_in_closed_form() {
        let linear = dvec3(0.3, -0.8, 0.5);
        let q = [dvec3(0.4, 0.1, -0.3), dvec3(0.1, -0.9, 0.2), dvec3(-0.3, 0.2, 0.5)];
        let bilinear = |d: DVec3| d.dot(dvec3(q[0].dot(d), q[1].dot(d), q[2].dot(d)));
        let sky = projected(3, |d| 1.7 + linear.dot(d) + bilinear(d));
        for n in [DVec3::Z, dvec3(0.6, 0.0, -0.8), dvec3(-2.0, 1.0, 2.0) / 3.0] {
            let expected = 1.7 * PI + TAU / 3.0 * linear.dot(n) + PI / 4.0 * bilinear(n);
            assert!((irradiance(&sky, n) - expected).abs() < 1e-12, "{n}");
        }
    }

    #[test]
    fn turned_coefficients_are_those_of_the_turned_function() {
        let rotation = DMat3::from_quat(DQuat::from_axis_angle(dvec3(1.0, 2.0, -2.0) / 3.0, 0.7));
        for order in 1..=MAX_ORDER {
            let before: Vec<f64> = (0..count(order)).map(|i| (1.3 * i as f64).sin()).collect();
            let after = rotated(&before, rotation);
            let value = |c: &[f64], d: DVec3| c.iter().zip(harmonics(order, d)).map(|(c, h)| c * h).sum::<f64>();
            for d in [DVec3::X, dvec3(0.0, 0.6, 0.8), dvec3(-2.0, 1.0, 2.0) / 3.0] {
                assert!((value(&after, rotation * d) - value(&before, d)).abs() < 1e-12, "{order} {d}");
            }
        }
    }
}

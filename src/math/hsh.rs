//! Hemispherical harmonics of order 1 to 10: the basis of light that reaches a surface, the normal along +z.
//!
//! H_l^m = √2·K_l^m·Φ_m·P_l^m(2cosθ − 1) (Gautron, Křivánek, Pattanaik and Bouatouch 2004, eq. 5): spherical harmonics whose
//! polar argument runs over its whole range within the hemisphere, and so orthonormal there. Order of coefficients and signs are
//! those of [`super::sh`].

use super::sh;
use glam::DVec3;
use std::f64::consts::{PI, SQRT_2};

/// The highest order.
pub const MAX_ORDER: u32 = 10;

/// The factors a, b of cosθ = a·H_0^0 + b·H_1^0, which holds exactly: irradiance is the same sum of two coefficients of
/// radiance.
pub fn cosine() -> [f64; 2] {
    [(PI / 2.0).sqrt(), (PI / 6.0).sqrt()]
}

/// Coefficients of an expansion of this order.
pub fn count(order: u32) -> usize {
    sh::count(order)
}

/// Values of all harmonics of an expansion in the unit direction `d`, z ≥ 0: `out` has [`count`]`(order)` places.
pub fn evaluate(order: u32, d: DVec3, out: &mut [f64]) {
    let cosine = d.z.clamp(0.0, 1.0);
    // √(1 − (2cosθ − 1)²) over sinθ.
    let stretch = 2.0 * (cosine / (1.0 + cosine)).sqrt();
    sh::angular(order, 2.0 * cosine - 1.0, [stretch * d.x, stretch * d.y], out);
    out.iter_mut().for_each(|h| *h *= SQRT_2);
}

/// Irradiance, W·m⁻², by radiance of these coefficients, W·sr⁻¹·m⁻².
pub fn irradiance(coefficients: &[f64]) -> f64 {
    let [constant, linear] = cosine();
    constant * coefficients[0] + coefficients.get(2).map_or(0.0, |c| linear * c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::gauss_legendre;
    use glam::dvec3;
    use std::f64::consts::TAU;

    fn harmonics(order: u32, d: DVec3) -> Vec<f64> {
        let mut out = vec![0.0; count(order)];
        evaluate(order, d, &mut out);
        out
    }

    /// Exact for products of two harmonics.
    fn hemisphere() -> Vec<(DVec3, f64)> {
        let turns = 2 * MAX_ORDER;
        let ring = |(z, weight): (f64, f64)| {
            (0..turns).map(move |i| {
                let (sine, cosine) = (TAU * (f64::from(i) + 0.3) / f64::from(turns)).sin_cos();
                let radius = (1.0 - z * z).sqrt();
                (dvec3(radius * cosine, radius * sine, z), weight * TAU / f64::from(turns))
            })
        };
        gauss_legendre(MAX_ORDER + 2).into_iter().flat_map(ring).collect()
    }

    #[test]
    fn they_are_orthonormal_over_the_hemisphere() {
        let n = count(MAX_ORDER);
        let mut products = vec![0.0; n * n];
        for (d, weight) in hemisphere() {
            let h = harmonics(MAX_ORDER, d);
            for (i, a) in h.iter().enumerate() {
                h.iter().enumerate().for_each(|(j, b)| products[i * n + j] += weight * a * b);
            }
        }
        for (at, product) in products.iter().enumerate() {
            let expected = f64::from(u8::from(at / n == at % n));
            assert!((product - expected).abs() < 1e-11, "{at}: {product}");
        }
    }

    #[test]
    fn the_cosine_is_a_sum_of_two() {
        let [constant, linear] = cosine();
        for (d, _) in hemisphere() {
            let h = harmonics(2, d);
            assert!((constant * h[0] + linear * h[2] - d.z).abs() < 1e-14, "{d}");
        }
    }

    /// A sky of radiance L₀ + L₁·ω + Q(ω): E = πL₀ + (2π/3) L₁z + (π/4)(Qxx + Qyy + 2Qzz).
    #[test]
    fn irradiance_of_skies_in_closed_form() {
        let (linear, quadratic) = (dvec3(0.3, -0.2, 0.6), dvec3(0.5, 0.2, -0.4));
        let sky = |d: DVec3| 1.2 + linear.dot(d) + quadratic.dot(d * d);
        let expected = 1.2 * PI + TAU / 3.0 * linear.z + PI / 4.0 * (quadratic.x + quadratic.y + 2.0 * quadratic.z);
        for order in [2, 6, MAX_ORDER] {
            let mut sums = vec![0.0; count(order)];
            for (d, weight) in hemisphere() {
                sums.iter_mut().zip(harmonics(order, d)).for_each(|(sum, h)| *sum += weight * sky(d) * h);
            }
            assert!((irradiance(&sums) - expected).abs() < 1e-12, "{order}: {}", irradiance(&sums));
        }
    }
}

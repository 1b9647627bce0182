//! Maps from the unit square to directions and points, with their densities.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// Two unit vectors that make a right-handed orthonormal frame with the unit vector `n`.
///
/// Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin, "Building an Orthonormal Basis, Revisited", JCGT 2017.
pub fn frame(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// Unit disc, area measure, density 1/π: the square's strata stay compact.
///
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square", JGT 1997.
pub fn concentric_disc(u: f64, v: f64) -> (f64, f64) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    let (r, phi) = if a.abs() > b.abs() { (a, FRAC_PI_4 * b / a) } else { (b, FRAC_PI_2 - FRAC_PI_4 * a / b) };
    (r * phi.cos(), r * phi.sin())
}

/// Direction around +Z, density cosθ/π per steradian (Malley's method).
pub fn cosine_hemisphere(u: f64, v: f64) -> DVec3 {
    let (x, y) = concentric_disc(u, v);
    DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// Direction on the whole sphere, density 1/4π per steradian.
pub fn uniform_sphere(u: f64, v: f64) -> DVec3 {
    let z = 1.0 - 2.0 * u;
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * (TAU * v).cos(), r * (TAU * v).sin(), z)
}

/// Barycentric coordinates of corners 1 and 2 of a point uniform on a triangle, density 1/area.
///
/// Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
pub fn triangle(u: f64, v: f64) -> (f64, f64) {
    if v > u { (0.5 * u, v - 0.5 * u) } else { (u - 0.5 * v, 0.5 * v) }
}

/// Weight of a sample of density `p` when another technique would draw it with density `q`, same measure.
///
/// Veach 1997, chapter 9: the power heuristic with β = 2. An infinite `p` wins.
pub fn power_heuristic(p: f64, q: f64) -> f64 {
    if p == 0.0 {
        return 0.0;
    }
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}

/// A discrete distribution: index with probability proportional to a weight.
#[derive(Debug, Clone, Default)]
pub struct Discrete {
    /// Running sums of the probabilities; the last is exactly 1.
    cumulative: Vec<f64>,
}

impl Discrete {
    /// From weights that are finite and not negative; `None` if they sum to zero.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = weights
            .into_iter()
            .map(|w| {
                sum += w;
                sum
            })
            .collect();
        if sum <= 0.0 {
            return None;
        }
        cumulative.iter_mut().for_each(|c| *c /= sum);
        let last_possible = cumulative.partition_point(|&c| c < 1.0);
        cumulative[last_possible..].fill(1.0);
        Some(Self { cumulative })
    }

    /// Index whose interval contains `u` in [0, 1), and where in the interval it lies, in [0, 1).
    pub fn sample(&self, u: f64) -> (usize, f64) {
        let i = self.cumulative.partition_point(|&c| c <= u).min(self.cumulative.len() - 1);
        let start = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let place = (u - start) / (self.cumulative[i] - start);
        (i, place.clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// Probability of index `i`.
    pub fn probability(&self, i: usize) -> f64 {
        self.cumulative[i] - if i == 0 { 0.0 } else { self.cumulative[i - 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> impl Iterator<Item = (f64, f64)> {
        (0..n * n).map(move |i| ((i % n) as f64 + 0.5, (i / n) as f64 + 0.5)).map(move |(x, y)| {
            let n = n as f64;
            (x / n, y / n)
        })
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for (u, v) in grid(16) {
            let n = uniform_sphere(u, v);
            let (t, b) = frame(n);
            assert!((t.cross(b) - n).length() < 1e-12, "{n}");
            assert!(t.dot(n).abs() < 1e-12 && (t.length() - 1.0).abs() < 1e-12);
        }
        for n in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.0, 0.0, -1.0)] {
            assert!((frame(n).0.cross(frame(n).1) - n).length() < 1e-15);
        }
    }

    #[test]
    fn moments_of_the_maps() {
        let n = 200;
        let mean = |f: &dyn Fn(f64, f64) -> f64| grid(n).map(|(u, v)| f(u, v)).sum::<f64>() / (n * n) as f64;
        // cosθ under cosθ/π: (1/π)∫cos² = 2/3; x² on the disc: 1/4.
        assert!((mean(&|u, v| cosine_hemisphere(u, v).z) - 2.0 / 3.0).abs() < 5e-4);
        assert!((mean(&|u, v| concentric_disc(u, v).0.powi(2)) - 0.25).abs() < 1e-4);
        assert!((mean(&|u, v| uniform_sphere(u, v).z.powi(2)) - 1.0 / 3.0).abs() < 1e-4);
        // Barycentric moments of a uniform triangle: E[b] = 1/3, E[b²] = 1/6.
        assert!((mean(&|u, v| triangle(u, v).0) - 1.0 / 3.0).abs() < 1e-4);
        assert!((mean(&|u, v| triangle(u, v).1.powi(2)) - 1.0 / 6.0).abs() < 1e-4);
    }

    #[test]
    fn discrete_skips_what_cannot_happen() {
        let d = Discrete::new([0.0, 1.0, 0.0, 3.0, 0.0]).unwrap();
        assert_eq!(d.sample(0.0).0, 1);
        assert_eq!(d.sample(0.2499).0, 1);
        assert_eq!(d.sample(0.25).0, 3);
        assert_eq!(d.sample(0.999_999_999).0, 3);
        assert!((d.sample(0.625).1 - 0.5).abs() < 1e-12);
        assert_eq!((0..5).map(|i| d.probability(i)).collect::<Vec<_>>(), [0.0, 0.25, 0.0, 0.75, 0.0]);
        assert!(Discrete::new([0.0, 0.0]).is_none());
    }

    #[test]
    fn heuristic_weights_sum_to_one() {
        assert!((power_heuristic(2.0, 3.0) + power_heuristic(3.0, 2.0) - 1.0).abs() < 1e-15);
        assert_eq!(power_heuristic(f64::INFINITY, 3.0), 1.0);
        assert_eq!(power_heuristic(0.0, 3.0), 0.0);
    }
}

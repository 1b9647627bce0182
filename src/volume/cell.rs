//! Interpolation in one cell, by the values and gradients at its eight corners.

use super::lattice::octants;
use glam::DVec3;

/// Interpolation between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Trilinear.
    Trilinear,
    /// Trilinear weights times 1/distance, finite at a sample. By 1/distance alone (Tatarchuk and Oat 2005) values would jump at the
    /// faces of cells.
    InverseDistance,
    /// Each sample extrapolated by its gradients, then trilinear (Tatarchuk and Oat 2005).
    Gradients,
    /// Cubic, by values and gradients.
    #[default]
    Hermite,
}

impl Interpolation {
    /// Whether it needs gradients.
    pub fn wants_gradients(self) -> bool {
        matches!(self, Self::Gradients | Self::Hermite)
    }
}

/// Trilinear weights of the corners at `t`, from 0 to 1 along each axis of the cell.
pub fn trilinear(t: DVec3) -> [f64; 8] {
    octants().map(|corner| (0..3).map(|axis| if corner[axis] == 1 { t[axis] } else { 1.0 - t[axis] }).product())
}

/// Weights of a corner's value and of its gradient in the cubic interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicWeight {
    /// Of the value.
    pub value: f64,
    /// Of the derivatives along x, y and z.
    pub gradient: DVec3,
}

/// The cubic interpolation in a cell with sides `size`: with s the distance from a corner along an axis in sides of the cell, and Λ
/// its trilinear weight, the value's weight is Λ·(1 + Σ s(1 − 2s)) and a derivative's ± size·Λ·s(1 − s).
///
/// On an edge that is Hermite's cubic. In space it is the element of Adini and Clough (1961) and Melosh (1963): it has no mixed
/// derivatives, which a tensor product of Hermite's cubics would take, reproduces every cubic polynomial, and is continuous: on a
/// face it depends on the face's four corners alone, and is the same by any part of the face.
pub fn cubic(t: DVec3, size: DVec3) -> [CubicWeight; 8] {
    let weights = trilinear(t);
    let corners = octants();
    std::array::from_fn(|i| {
        let s = DVec3::select(corners[i].cmpeq(glam::UVec3::ONE), 1.0 - t, t);
        let sign = DVec3::ONE - 2.0 * corners[i].as_dvec3();
        let value = weights[i] * (1.0 + (s * (1.0 - 2.0 * s)).element_sum());
        CubicWeight { value, gradient: weights[i] * sign * size * s * (1.0 - s) }
    })
}

/// Derivatives of [`cubic`]'s weights along each axis, by central differences of polynomials of degree 4 at most: exact to rounding.
pub fn cubic_slopes(t: DVec3, size: DVec3) -> [[CubicWeight; 8]; 3] {
    // f'(0) = (8(f(h) − f(−h)) − (f(2h) − f(−2h)))/12h is exact up to degree 4.
    let h = 0.125;
    [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
        let at = |steps: f64| cubic(t + steps * h * axis, size);
        let [far_less, less, more, far_more] = [-2.0, -1.0, 1.0, 2.0].map(at);
        let scale = 1.0 / (12.0 * h * size.dot(axis));
        std::array::from_fn(|i| CubicWeight {
            value: scale * (8.0 * (more[i].value - less[i].value) - far_more[i].value + far_less[i].value),
            gradient: scale
                * (8.0 * (more[i].gradient - less[i].gradient) - far_more[i].gradient + far_less[i].gradient),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    /// A polynomial with every term of degree 3 and below, and its gradient.
    fn polynomial(p: DVec3) -> (f64, DVec3) {
        let DVec3 { x, y, z } = p;
        let value =
            0.3 + x - 2.0 * y + 0.5 * z + x * y - y * z + 0.7 * x * z + x * x - 0.4 * y * y + 0.2 * z * z + x * x * x
                - y * y * y
                + 0.6 * z * z * z
                + x * x * y
                - 0.3 * x * y * y
                + 0.8 * y * y * z
                + x * z * z
                + 0.9 * x * x * z
                - 0.2 * y * z * z
                + 1.1 * x * y * z;
        let dx =
            1.0 + y + 0.7 * z + 2.0 * x + 3.0 * x * x + 2.0 * x * y - 0.3 * y * y + z * z + 1.8 * x * z + 1.1 * y * z;
        let dy = -2.0 + x - z - 0.8 * y - 3.0 * y * y + x * x - 0.6 * x * y + 1.6 * y * z - 0.2 * z * z + 1.1 * x * z;
        let dz = 0.5 - y + 0.7 * x + 0.4 * z + 1.8 * z * z + 0.8 * y * y + 2.0 * x * z + 0.9 * x * x - 0.4 * y * z
            + 1.1 * x * y;
        (value, dvec3(dx, dy, dz))
    }

    #[test]
    fn cubic_polynomials_come_back_with_their_slopes() {
        let (low, size) = (dvec3(0.3, -0.4, 0.2), dvec3(0.5, 0.8, 1.3));
        let corners = octants().map(|corner| polynomial(low + corner.as_dvec3() * size));
        let sum = |weights: &[CubicWeight; 8]| -> f64 {
            weights.iter().zip(&corners).map(|(w, (value, slope))| w.value * value + w.gradient.dot(*slope)).sum()
        };
        for t in [dvec3(0.2, 0.7, 0.4), DVec3::ZERO, DVec3::ONE, dvec3(0.0, 0.5, 0.5)] {
            let (value, slope) = polynomial(low + t * size);
            assert!((sum(&cubic(t, size)) - value).abs() < 1e-12, "{t}");
            let slopes = DVec3::from(cubic_slopes(t, size).each_ref().map(sum));
            assert!((slopes - slope).length() < 1e-11, "{t}: {slopes} {slope}");
        }
    }

    #[test]
    fn weights_sum_to_one() {
        let t = dvec3(0.1, 0.6, 0.9);
        assert!((trilinear(t).iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert!((cubic(t, DVec3::ONE).iter().map(|w| w.value).sum::<f64>() - 1.0).abs() < 1e-15);
    }
}

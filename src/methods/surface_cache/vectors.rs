//! Vectors of an irradiance a place, each colour channel by itself.

use glam::DVec3;

/// Scalar product.
pub(super) fn dot(a: &[DVec3], b: &[DVec3]) -> DVec3 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean length.
pub(super) fn norm(values: &[DVec3]) -> DVec3 {
    dot(values, values).map(f64::sqrt)
}

/// Channel by channel; 0 where there is nothing to divide by.
pub(super) fn ratio(a: DVec3, b: DVec3) -> DVec3 {
    let channel = |i: usize| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 };
    DVec3::new(channel(0), channel(1), channel(2))
}

/// The largest channel of the ratio.
pub(super) fn share(a: DVec3, b: DVec3) -> f64 {
    ratio(a, b).max_element()
}

/// Sum over all entries and channels.
pub(super) fn total(values: &[DVec3]) -> f64 {
    values.iter().map(|v| v.element_sum()).sum()
}

//! Irradiance in closed form, in double precision.

use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// Corners of a parallelogram.
pub fn parallelogram(corner: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
    [corner, corner + u, corner + u + v, corner + v]
}

/// Irradiance at `p` with normal `n` from a polygon of radiance 1 that is seen from its front (Lambert 1760):
/// ½ Σ Θᵢ n·Γᵢ, after clipping at the horizon. Which side is the front is the caller's business.
pub fn polygon(p: DVec3, n: DVec3, corners: &[DVec3]) -> f64 {
    let clipped = above_horizon(p, n, corners);
    let edge = |i: usize| {
        let (a, b) = (clipped[i], clipped[(i + 1) % clipped.len()]);
        let cross = a.cross(b);
        cross.length().atan2(a.dot(b)) * cross.try_normalize().map_or(0.0, |gamma| n.dot(gamma))
    };
    (0.5 * (0..clipped.len()).map(edge).sum::<f64>()).abs()
}

/// The part of the polygon in front of the plane at `p`, relative to `p` (Sutherland and Hodgman 1974).
fn above_horizon(p: DVec3, n: DVec3, corners: &[DVec3]) -> Vec<DVec3> {
    let relative: Vec<DVec3> = corners.iter().map(|c| *c - p).collect();
    let mut kept = Vec::new();
    for (i, a) in relative.iter().enumerate() {
        let b = relative[(i + 1) % relative.len()];
        let (da, db) = (n.dot(*a), n.dot(b));
        if da >= 0.0 {
            kept.push(*a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            kept.push(*a + (b - *a) * (da / (da - db)));
        }
    }
    kept
}

/// Irradiance of a point light of intensity 1.
pub fn point_light(p: DVec3, n: DVec3, light: DVec3) -> f64 {
    let d = light - p;
    (n.dot(d) / d.length().powi(3)).max(0.0)
}

/// glTF's spot: intensity × clamp((cosθ − cos_outer)/(cos_inner − cos_outer), 0, 1)².
pub fn spot_factor(cosine: f64, cos_inner: f64, cos_outer: f64) -> f64 {
    ((cosine - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0).powi(2)
}

/// Whether the segment from `p` to `q` meets the box, grown by `margin`.
pub fn crosses_box(p: DVec3, q: DVec3, low: DVec3, high: DVec3, margin: f64) -> bool {
    let d = q - p;
    let (mut near, mut far) = (0.0f64, 1.0f64);
    for axis in 0..3 {
        let (low, high) = (low[axis] - margin, high[axis] + margin);
        if d[axis] == 0.0 {
            if p[axis] < low || p[axis] > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - p[axis]) / d[axis], (high - p[axis]) / d[axis]);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    near < far
}

/// ∫ f over the rectangle [−half, half]² in the plane y = `height` by the midpoint rule on `n × n` squares.
pub fn over_square(height: f64, half: f64, n: u32, f: impl Fn(DVec3) -> f64) -> f64 {
    let step = 2.0 * half / f64::from(n);
    let at = |i: u32| -half + (f64::from(i) + 0.5) * step;
    let row = |j: u32| (0..n).map(|i| f(dvec3(at(i), height, at(j)))).sum::<f64>();
    (0..n).map(row).sum::<f64>() * step * step
}

/// Irradiance at `p`, `n` from a Lambertian element at `q` with normal `m` of radiance 1, per area.
pub fn element(p: DVec3, n: DVec3, q: DVec3, m: DVec3) -> f64 {
    let d = q - p;
    let r2 = d.length_squared();
    (n.dot(d).max(0.0) * -m.dot(d).min(0.0)) / (r2 * r2)
}

#[test]
fn the_rectangle_of_the_tables() {
    let corners = [dvec3(0.3, -0.7, 1.0), dvec3(1.5, -0.7, 1.0), dvec3(1.5, 0.9, 1.0), dvec3(0.3, 0.9, 1.0)];
    assert!((polygon(DVec3::ZERO, DVec3::Z, &corners) - 0.552554).abs() < 1e-6);
    // Opposite faces of the unit cube, and adjacent ones, from the middle of one: by symmetry 1 over all six.
    let face = |n: DVec3, u: DVec3, v: DVec3| parallelogram(n * 0.5 - u * 0.5 - v * 0.5, u, v);
    let p = -0.5 * DVec3::Z;
    let all = [(DVec3::Z, DVec3::X, DVec3::Y), (DVec3::X, DVec3::Y, DVec3::Z), (DVec3::NEG_X, DVec3::Y, DVec3::Z)];
    let [top, a, b] = all.map(|(n, u, v)| polygon(p, DVec3::Z, &face(n, u, v)));
    let c = polygon(p, DVec3::Z, &face(DVec3::Y, DVec3::X, DVec3::Z));
    let d = polygon(p, DVec3::Z, &face(DVec3::NEG_Y, DVec3::X, DVec3::Z));
    assert!((top + a + b + c + d - PI).abs() < 1e-9, "{top} {a} {b} {c} {d}");
}

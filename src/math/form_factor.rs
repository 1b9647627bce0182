//! Irradiance from emitters of simple shape, in closed form.
//!
//! Irradiance is in W·m⁻² for radiance in W·sr⁻¹·m⁻²; lengths in any one unit.

use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// Irradiance at the origin, on a surface of unit normal `n`, from a polygon of radiance 1 seen from either side.
///
/// Lambert 1760 (as in Baum, Rushmeier, Winget 1989): `½ Σ Θ_i n·Γ_i`; the polygon is clipped at the horizon
/// first. `corners` are relative to the point that receives.
pub fn polygon(n: DVec3, corners: &[DVec3]) -> f64 {
    let clipped = clip(corners, |p| n.dot(p));
    let edges = clipped.iter().zip(clipped.iter().cycle().skip(1));
    let sum: f64 = edges
        .map(|(a, b)| {
            let cross = a.cross(*b);
            let length = cross.length();
            if length == 0.0 { 0.0 } else { length.atan2(a.dot(*b)) * n.dot(cross) / length }
        })
        .sum();
    (0.5 * sum).abs()
}

/// The part of a convex polygon where `height`, a linear function, is positive (Sutherland and Hodgman 1974).
pub fn clip(corners: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(corners.len() + 1);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (ha, hb) = (height(a), height(b));
        if ha >= 0.0 {
            out.push(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            out.push(a + (b - a) * (ha / (ha - hb)));
        }
    }
    out
}

/// Irradiance from a sphere of radiance 1; `h` = radius / distance of its centre, `c` = cosine of the angle between the
/// normal and the direction of the centre. Exact below the horizon too (Snyder 1996, "Area light sources").
pub fn sphere(h: f64, c: f64) -> f64 {
    if c >= h {
        return PI * h * h * c;
    }
    if c <= -h {
        return 0.0;
    }
    let x = (1.0 / (h * h) - 1.0).sqrt();
    let s = (1.0 - c * c).sqrt();
    let y = -x * c / s;
    let q = s * (1.0 - y * y).max(0.0).sqrt();
    h * h * (c * y.clamp(-1.0, 1.0).acos() - x * q) + (q / x).atan()
}

/// Irradiance on a surface tilted by the angle `beta` away from a half space of sky of radiance 1.
pub fn tilted_sky(beta: f64) -> f64 {
    PI * (1.0 + beta.cos()) / 2.0
}

/// Irradiance at distance `x` from a wall of height `h`, infinitely long, perpendicular to the receiver, radiance 1.
pub fn wall(x: f64, h: f64) -> f64 {
    0.5 * PI * (1.0 - x / x.hypot(h))
}

/// Form factor of an infinitely long slit of width `w` centred at height `height` above the receiver.
pub fn slit(w: f64, height: f64) -> f64 {
    0.5 * w / height.hypot(0.5 * w)
}

/// Form factor between two equal, aligned, parallel rectangles `x` × `y` at distance 1 (Howell, configuration C-11).
pub fn parallel_rectangles(x: f64, y: f64) -> f64 {
    let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
    let terms = 0.5 * (x2 * y2 / (1.0 + x * x + y * y)).ln()
        + x * y2.sqrt() * (x / y2.sqrt()).atan()
        + y * x2.sqrt() * (y / x2.sqrt()).atan()
        - x * x.atan()
        - y * y.atan();
    2.0 * FRAC_1_PI / (x * y) * terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    const RECTANGLE: [DVec3; 4] =
        [dvec3(0.3, -0.7, 1.0), dvec3(1.5, -0.7, 1.0), dvec3(1.5, 0.9, 1.0), dvec3(0.3, 0.9, 1.0)];

    #[test]
    fn rectangle_of_the_equations_page() {
        assert!((polygon(DVec3::Z, &RECTANGLE) - 0.552554).abs() < 1e-6);
        let moved = |d: DVec3| polygon(DVec3::Z, &RECTANGLE.map(|c| c - d));
        let step = 1e-4;
        let slope = |d: DVec3| (moved(d * step) - moved(-d * step)) / (2.0 * step);
        assert!((slope(DVec3::X) - 0.85859).abs() < 1e-4 && (slope(DVec3::Y) - 0.06285).abs() < 1e-4);
    }

    #[test]
    fn polygon_is_clipped_at_the_horizon() {
        // An infinite wall beside the point covers half of the cosine-weighted hemisphere's half.
        let far = 1e7;
        let wall_corners = [dvec3(1.0, -far, -far), dvec3(1.0, far, -far), dvec3(1.0, far, far), dvec3(1.0, -far, far)];
        assert!((polygon(DVec3::Z, &wall_corners) - PI / 2.0).abs() < 1e-5);
        let h = 2.0;
        let low = [dvec3(1.0, -far, 0.0), dvec3(1.0, far, 0.0), dvec3(1.0, far, h), dvec3(1.0, -far, h)];
        assert!((polygon(DVec3::Z, &low) - wall(1.0, h)).abs() < 1e-6);
        assert_eq!(polygon(DVec3::NEG_Z, &RECTANGLE), 0.0);
    }

    #[test]
    fn sphere_by_quadrature_and_at_the_seams() {
        let (h, n) = (0.6f64, 1500);
        for c in [0.9, 0.61, 0.59, 0.3, 0.0, -0.4, -0.59] {
            let s = (1.0f64 - c * c).sqrt();
            let cos_max = (1.0 - h * h).sqrt();
            let mut sum = 0.0;
            for i in 0..n {
                let z = cos_max + (1.0 - cos_max) * (i as f64 + 0.5) / n as f64;
                let r = (1.0 - z * z).sqrt();
                for k in 0..n {
                    let phi = 2.0 * PI * (k as f64 + 0.5) / n as f64;
                    sum += (c * z + s * r * phi.cos()).max(0.0);
                }
            }
            let numeric = sum * 2.0 * PI * (1.0 - cos_max) / (n * n) as f64;
            assert!((sphere(h, c) - numeric).abs() < 1e-5, "c {c}: {} {numeric}", sphere(h, c));
        }
        assert_eq!(sphere(0.6, -0.7), 0.0);
    }

    #[test]
    fn unit_cube_faces() {
        let opposite = parallel_rectangles(1.0, 1.0);
        assert!((opposite - 0.199825).abs() < 1e-6, "{opposite}");
        assert!(((1.0 - opposite) / 4.0 - 0.200044).abs() < 1e-6);
    }

    #[test]
    fn limits() {
        assert!((tilted_sky(0.0) - PI).abs() < 1e-15 && tilted_sky(PI).abs() < 1e-15);
        assert!((slit(2.0, 1.0) - 0.5f64.sqrt()).abs() < 1e-15);
    }
}

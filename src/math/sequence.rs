//! Low-discrepancy points.

use glam::Vec2;

/// Barycentric (u, v) of point `index` of the triangular van der Corput sequence (Basu and Owen 2015, "Low discrepancy
/// constructions in the triangle", section 3): each base-4 digit chooses one of the four triangles that the
/// last one splits into, so that every 4ᵏ points in a row lie one in each of the 4ᵏ equal triangles.
pub fn triangle_point(index: u32) -> Vec2 {
    let [mut a, mut b, mut c] = [Vec2::ZERO, Vec2::X, Vec2::Y];
    let mut rest = index;
    // Digit 0 keeps the centre where it is: leading zeros need no step.
    while rest > 0 {
        let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
        [a, b, c] = match rest & 3 {
            0 => [bc, ca, ab],
            1 => [a, ab, ca],
            2 => [ab, b, bc],
            _ => [ca, bc, c],
        };
        rest >>= 2;
    }
    (a + b + c) / 3.0
}

/// Direction `index` of `count` on the unit sphere: spherical Fibonacci points (Keinert et al. 2015).
pub fn fibonacci_sphere(index: u32, count: u32) -> glam::Vec3 {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (golden * f64::from(index)).sin_cos();
    glam::Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibonacci_points_are_balanced() {
        let mean = (0..256).map(|i| fibonacci_sphere(i, 256)).sum::<glam::Vec3>() / 256.0;
        assert!(mean.length() < 2e-3, "{mean}");
    }

    #[test]
    fn each_run_of_a_power_of_four_has_one_point_in_each_equal_triangle() {
        for first in [0, 64, 192] {
            let mut seen = std::collections::BTreeSet::new();
            for p in (first..first + 64).map(triangle_point) {
                let s = p * 8.0;
                let upper = s.x.fract() + s.y.fract() > 1.0;
                assert!(p.x > 0.0 && p.y > 0.0 && p.x + p.y < 1.0, "{p}");
                assert!(seen.insert((s.x as u32, s.y as u32, upper)), "two points in one triangle: {p}");
            }
        }
    }
}

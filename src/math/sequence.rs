//! Low-discrepancy points.

use glam::Vec2;

/// Point `index` of the R2 sequence (Roberts 2018) in the unit square: additive recurrence with the plastic number.
pub fn r2(index: u32) -> Vec2 {
    let n = f64::from(index) + 0.5;
    Vec2::new((0.754_877_666_246_692_7 * n).fract() as f32, (0.569_840_290_998_053_2 * n).fract() as f32)
}

/// Barycentric (u, v) of a point of the unit square, folded onto the triangle u + v ≤ 1.
pub fn fold_to_triangle(p: Vec2) -> Vec2 {
    if p.x + p.y > 1.0 { Vec2::ONE - p } else { p }
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
    fn r2_fills_the_square_evenly() {
        let left = (0..1000).filter(|i| r2(*i).x < 0.5 && r2(*i).y < 0.5).count();
        assert!((245..=255).contains(&left), "{left}");
    }
}

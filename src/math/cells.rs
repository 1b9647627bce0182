//! Surface cells: a triangle cut into r² triangles of equal shape; twin of `glsl/inc/cells.glsl`.
//!
//! Row i of r along the first side holds 2(r − i) − 1 cells: one that is turned like the whole, one upside down, and so on.

use glam::DVec2;

/// Corners of a cell in barycentric coordinates (u, v) of its triangle p0 + u·(p1 − p0) + v·(p2 − p0), cut along each side
/// into `r` parts.
pub fn corners(r: u32, cell: u32) -> [DVec2; 3] {
    let mut row = 0;
    while cell >= (row + 1) * (2 * r - row - 1) {
        row += 1;
    }
    let along = cell - row * (2 * r - row);
    let corner = DVec2::new(f64::from(row), f64::from(along / 2));
    let local = [DVec2::ZERO, DVec2::X, DVec2::Y];
    let place = |st: DVec2| corner + if along.is_multiple_of(2) { st } else { 1.0 - st };
    local.map(|st| place(st) / f64::from(r))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All cells have the same area, lie within the triangle and are different.
    #[test]
    fn cells_fill_their_triangle() {
        for r in [1, 2, 5] {
            let mut middles = Vec::new();
            for cell in 0..r * r {
                let [a, b, c] = corners(r, cell);
                assert!(((b - a).perp_dot(c - a) * f64::from(r * r) - 1.0).abs() < 1e-12);
                assert!([a, b, c].iter().all(|p| p.min_element() >= 0.0 && p.x + p.y < 1.0 + 1e-12));
                middles.push((a + b + c) / 3.0);
            }
            for (i, m) in middles.iter().enumerate() {
                assert!(middles[..i].iter().all(|other| m.distance(*other) > 0.1 / f64::from(r)));
            }
        }
    }
}

//! Surface cells: a triangle cut into r² triangles of equal shape; twin of `glsl/inc/subdivision.glsl`.
//!
//! Row i of r along the first side holds 2(r − i) − 1 cells: one that is turned like the whole, one upside down, and so on.

use glam::{DVec2, UVec2, Vec2};

/// Row of a cell, and its place in the row.
fn place(r: u32, cell: u32) -> [u32; 2] {
    // Row i starts at i(2r − i) = r² − (r − i)².
    let rest = r * r - cell;
    let up = rest.isqrt();
    let row = r - if up * up == rest { up } else { up + 1 };
    [row, cell - row * (2 * r - row)]
}

/// Cell that holds the point (u, v) of its triangle p0 + u·(p1 − p0) + v·(p2 − p0), cut along each side into `r` parts.
pub fn at(r: u32, uv: Vec2) -> u32 {
    let s = uv.clamp(Vec2::ZERO, Vec2::ONE) * r as f32;
    let i = (s.x as u32).min(r - 1);
    let j = (s.y as u32).min(r - 1 - i);
    let f = s - UVec2::new(i, j).as_vec2();
    let upper = u32::from(f.x + f.y > 1.0 && i + j + 2 <= r);
    i * (2 * r - i) + 2 * j + upper
}

/// The point (s, t), s + t ≤ 1, of a cell, in (u, v).
pub fn point(r: u32, cell: u32, st: DVec2) -> DVec2 {
    let [row, along] = place(r, cell);
    let corner = UVec2::new(row, along / 2).as_dvec2();
    (corner + if along.is_multiple_of(2) { st } else { 1.0 - st }) / f64::from(r)
}

/// Centre (u, v) of a cell.
pub fn centre(r: u32, cell: u32) -> Vec2 {
    point(r, cell, DVec2::splat(1.0 / 3.0)).as_vec2()
}

/// Corners (u, v) of a cell.
pub fn corners(r: u32, cell: u32) -> [DVec2; 3] {
    [DVec2::ZERO, DVec2::X, DVec2::Y].map(|st| point(r, cell, st))
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

    #[test]
    fn a_cell_holds_its_centre() {
        for r in [1, 2, 3, 8, 100] {
            for cell in 0..r * r {
                assert_eq!(at(r, centre(r, cell)), cell, "of {r}²");
            }
        }
    }
}

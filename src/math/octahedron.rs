//! A map of the directions onto a square: the octahedron |x| + |y| + |z| = 1, unfolded (Cigolle et al. 2014). Its cells hold what is
//! stored by direction, such as a probe's distances.

use glam::{DVec2, DVec3, dvec2};

/// Cells along a side of the map.
pub const SIDE: usize = 8;
/// Cells of the map.
pub const CELLS: usize = SIDE * SIDE;

/// Where the direction `d`, of any length, lies in the square from −1 to 1: the upper hemisphere is its inner diamond.
pub fn encode(d: DVec3) -> DVec2 {
    let p = d / (d.x.abs() + d.y.abs() + d.z.abs());
    if p.z < 0.0 { (1.0 - exchanged(p.truncate()).abs()) * signs(p.truncate()) } else { p.truncate() }
}

/// The cell that the direction `d` lies in: row by row.
pub fn cell(d: DVec3) -> usize {
    let at = ((encode(d) + 1.0) * (0.5 * SIDE as f64)).floor().clamp(DVec2::ZERO, DVec2::splat(SIDE as f64 - 1.0));
    at.y as usize * SIDE + at.x as usize
}

/// Unit direction of a cell's middle.
pub fn middle(cell: usize) -> DVec3 {
    let at = (dvec2((cell % SIDE) as f64, (cell / SIDE) as f64) + 0.5) * (2.0 / SIDE as f64) - 1.0;
    let z = 1.0 - at.x.abs() - at.y.abs();
    let p = if z < 0.0 { (1.0 - exchanged(at).abs()) * signs(at) } else { at };
    p.extend(z).normalize()
}

/// The four cells around a direction and their weights, which are continuous in the direction and sum to 1.
pub fn around(d: DVec3) -> [(usize, f64); 4] {
    let at = (encode(d) + 1.0) * (0.5 * SIDE as f64) - 0.5;
    let low = at.floor();
    let f = at - low;
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
        let weight = [1.0 - f.x, f.x][i] * [1.0 - f.y, f.y][j];
        (wrapped(low.x as i32 + i as i32, low.y as i32 + j as i32), weight)
    })
}

/// The cell at integer coordinates, at most one outside of the map: across a side the map goes on turned by half about the side's
/// middle.
fn wrapped(x: i32, y: i32) -> usize {
    let side = SIDE as i32;
    let (mut x, mut y) = (x, y);
    if x < 0 || x >= side {
        (x, y) = (x.clamp(0, side - 1), side - 1 - y);
    }
    if y < 0 || y >= side {
        (x, y) = (side - 1 - x, y.clamp(0, side - 1));
    }
    (y * side + x) as usize
}

fn signs(v: DVec2) -> DVec2 {
    let sign = |x: f64| if x >= 0.0 { 1.0 } else { -1.0 };
    dvec2(sign(v.x), sign(v.y))
}

fn exchanged(v: DVec2) -> DVec2 {
    dvec2(v.y, v.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sh::sphere_rule;

    fn value(cells: &[f64], d: DVec3) -> f64 {
        around(d).iter().map(|(cell, weight)| weight * cells[*cell]).sum()
    }

    #[test]
    fn middles_lie_in_their_cells() {
        assert!((0..CELLS).all(|i| cell(middle(i)) == i));
    }

    #[test]
    fn weights_are_even_and_change_without_jumps() {
        let cells: Vec<f64> = (0..CELLS).map(|i| (1.7 * i as f64).sin()).collect();
        for i in 0..20000 {
            let t = f64::from(i) * 1e-3;
            let d = dvec2((3.1 * t).sin(), (2.3 * t).cos()).extend((1.3 * t).sin());
            let next = d + 1e-6 * dvec2(t.cos(), (7.0 * t).sin()).extend((5.0 * t).cos());
            assert!((around(d).iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!((value(&cells, d) - value(&cells, next)).abs() < 1e-3, "a jump at {d}");
        }
    }

    /// What is stored is a smooth function of the direction: it comes back to the second order in a cell's width.
    #[test]
    fn a_smooth_function_comes_back() {
        let f = |d: DVec3| 1.0 + 0.3 * d.x - 0.2 * d.y * d.z;
        let mut sums = vec![(0.0, 0.0); CELLS];
        for (d, weight) in sphere_rule(60) {
            let sum = &mut sums[cell(d)];
            *sum = (sum.0 + weight * f(d), sum.1 + weight);
        }
        let cells: Vec<f64> = sums.iter().map(|(sum, weight)| sum / weight).collect();
        for (d, _) in sphere_rule(7) {
            assert!((value(&cells, d) - f(d)).abs() < 0.05, "{d}: {} {}", value(&cells, d), f(d));
        }
    }
}

//! Whether something stands between a record and a point, by what the record's hemicube has seen: CPU twin of
//! `glsl/splat/hidden.glsl`.

use glam::{DVec2, DVec3};

/// Share of the distance by which something must stand nearer than the point.
pub const TOLERANCE: f64 = 0.1;

/// Whether the point at `offset` from a record, in its local frame, is hidden from it.
///
/// `inverse_distance` holds 1/distance of every texel of a hemicube of `size` texels a side, in the order of its table.
/// Along a plane 1/(forward distance) is linear in a face's column, so that a straight wall hides exactly what is behind it.
/// Of two rows the further one counts: on a concave surface the lower one sees the surface before the point.
pub fn hidden(size: u32, inverse_distance: &[f64], offset: DVec3) -> bool {
    if offset.z >= offset.x.abs().max(offset.y.abs()) {
        return false; // Above the sides: no thin wall stands so.
    }
    let (view, f) = side_coordinates(offset);
    let n = f64::from(size);
    let at = (DVec2::new(f.x, -f.y.max(0.0)) / f.z * 0.5 + 0.5) * n - 0.5;
    // Before a face's first centre and past its last the line goes on.
    let low = DVec2::new(at.x.floor().clamp(0.0, n - 2.0), at.y.floor());
    let inverse_forward = |dx: f64, dy: f64| {
        let x = low.x + dx;
        let y = (low.y + dy).clamp(0.0, n / 2.0 - 1.0);
        let p = (DVec2::new(x, y) + 0.5) * 2.0 / n - 1.0;
        let texel = (size * size + view * size * size / 2) as usize + (y * n + x) as usize;
        inverse_distance[texel] * (1.0 + p.length_squared()).sqrt()
    };
    let share = at.x - low.x;
    let row = |dy| inverse_forward(0.0, dy) * (1.0 - share) + inverse_forward(1.0, dy) * share;
    f.z * row(0.0).min(row(1.0)) > 1.0 + TOLERANCE
}

/// The side face, from 0, that sees a local direction, and (right, up, forward) on it; twin of `face_coordinates`.
fn side_coordinates(l: DVec3) -> (u32, DVec3) {
    if l.x.abs() >= l.y.abs() {
        if l.x >= 0.0 { (0, DVec3::new(l.y, l.z, l.x)) } else { (1, DVec3::new(-l.y, l.z, -l.x)) }
    } else if l.y >= 0.0 {
        (2, DVec3::new(-l.x, l.z, l.y))
    } else {
        (3, DVec3::new(l.x, l.z, -l.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::capture::Projection;
    use std::f64::consts::{PI, TAU};

    /// What a hemicube sees where `inverse` is 1/distance along a direction.
    fn seen(size: u32, inverse: impl Fn(DVec3) -> f64) -> Vec<f64> {
        Projection::Hemicube.table(size).texels.iter().map(|t| inverse(t.direction).max(0.0)).collect()
    }

    fn azimuths() -> impl Iterator<Item = DVec3> {
        (0..720).map(|i| f64::from(i) / 720.0 * TAU).map(|phi| DVec3::new(phi.cos(), phi.sin(), 0.0))
    }

    #[test]
    fn a_wall_hides_what_is_behind_it_and_nothing_else() {
        for size in [8, 32, 64] {
            for turn in [0.0, 0.3, 0.7, 2.0] {
                // An endless wall at distance 1 in the direction m: 1/d = m·ω.
                let m = DVec3::new(f64::cos(turn), f64::sin(turn), 0.0);
                let wall = seen(size, |direction| m.dot(direction));
                for azimuth in azimuths() {
                    let towards = azimuth.dot(m);
                    for share in [0.3, 0.9, 1.0] {
                        // Where the wall meets the horizon, texels beside it see none of it.
                        let reach = share / towards.max(2.0 / f64::from(size));
                        assert!(!hidden(size, &wall, azimuth * reach), "{size} {turn} {azimuth} {share}");
                    }
                    let behind = (1.0 + TOLERANCE) * 1.02 / towards;
                    if towards > 4.0 / f64::from(size) {
                        assert!(hidden(size, &wall, azimuth * behind), "{size} {turn} {azimuth}");
                    }
                }
            }
        }
    }

    /// A record on the inside of a sphere of radius 1 sees all of it.
    #[test]
    fn a_concave_surface_hides_nothing_of_itself() {
        for size in [16, 32, 64] {
            let sphere = seen(size, |direction| 0.5 / direction.z);
            for azimuth in azimuths().step_by(7) {
                for angle in [0.02, 0.1, 0.3, 0.6, 1.0, PI / 2.0] {
                    let p = azimuth * f64::sin(angle) + DVec3::Z * (1.0 - f64::cos(angle));
                    assert!(!hidden(size, &sphere, p), "{size} {azimuth} {angle}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_hidden_under_the_open_sky() {
        let sky = seen(32, |_| 0.0);
        assert!(azimuths().all(|azimuth| !hidden(32, &sky, azimuth * 1e9)));
    }
}

//! Whether something stands between a record and a point, by the horizon that the record keeps of what its hemicube saw: CPU twin
//! of `glsl/keep_records`, `glsl/inc/horizon.glsl` and `glsl/splat/hidden.glsl`.

use glam::{DVec2, DVec3};

/// Share of the distance by which something must stand nearer than the point.
pub const TOLERANCE: f64 = 0.1;
/// Rows of a side face that are kept.
const ROWS: usize = 8;
/// Range of the values that a horizon tells apart.
const OCTAVES: f64 = 16.0;
/// Columns of a side face that are kept, at most.
const MOST_COLUMNS: u32 = 32;

/// What a record keeps of the distances that its hemicube of `size` texels a side saw: of each column of the side faces
/// 1/(forward distance) in eight rows, a byte each.
#[derive(Clone, Debug, PartialEq)]
pub struct Horizon {
    size: u32,
    columns: u32,
    /// Largest 1/(forward distance).
    largest: f64,
    /// A column each.
    bytes: Vec<[u8; ROWS]>,
}

/// Row of a side face, counted upwards from the lowest one, that is kept as the `kept`-th.
fn row(kept: usize, size: u32) -> u32 {
    const OF_32: [u32; ROWS] = [0, 1, 2, 3, 5, 8, 11, 15];
    (OF_32[kept] * size / 32).max(kept as u32).min(size / 2 - 1)
}

impl Horizon {
    /// The horizon of a hemicube of `size` texels a side; `inverse_distance` holds 1/distance of every texel in the order of its
    /// table. Values are rounded up, by 4 % at most, where they are at least 2⁻¹⁶ of the largest.
    pub fn new(size: u32, inverse_distance: &[f64]) -> Self {
        let (n, columns) = (f64::from(size), size.min(MOST_COLUMNS));
        let inverse_forward = |side: u32, x: u32, y: u32| {
            let p = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * 2.0 / n - 1.0;
            let texel = (size * size + side * size * size / 2 + y * size + x) as usize;
            inverse_distance[texel] * (1.0 + p.length_squared()).sqrt()
        };
        let value = |column: u32, kept: usize| {
            let (side, y) = (column / columns, size / 2 - 1 - row(kept, size));
            let x = (f64::from(column % columns) + 0.5) * n / f64::from(columns) - 0.5;
            let share = x.fract();
            let low = inverse_forward(side, x as u32, y);
            if share == 0.0 { low } else { low * (1.0 - share) + inverse_forward(side, x as u32 + 1, y) * share }
        };
        let values: Vec<[f64; ROWS]> =
            (0..4 * columns).map(|column| std::array::from_fn(|kept| value(column, kept))).collect();
        let largest = values.iter().flatten().fold(0.0, |a: f64, b| a.max(*b));
        let byte = |v: f64| if v > 0.0 { (255.0 + (v / largest).log2() * 255.0 / OCTAVES).ceil() as u8 } else { 0 };
        Self { size, columns, largest, bytes: values.iter().map(|column| column.map(byte)).collect() }
    }

    fn value(&self, column: usize, row: usize) -> f64 {
        match self.bytes[column][row] {
            0 => 0.0,
            byte => self.largest * ((f64::from(byte) - 255.0) * OCTAVES / 255.0).exp2(),
        }
    }

    /// Whether the point at `offset` from the record, in its local frame, is hidden from it.
    ///
    /// Along a plane 1/(forward distance) is linear in a face's column, so that a straight wall hides exactly what is behind it.
    /// Of two rows the further one counts: on a concave surface the lower one sees the surface before the point.
    pub fn hides(&self, offset: DVec3) -> bool {
        if offset.z >= offset.x.abs().max(offset.y.abs()) {
            return false; // Above the sides: no thin wall stands so.
        }
        let (side, f) = side_coordinates(offset);
        let slope = f.y / f.z;
        let x = (f.x / f.z * 0.5 + 0.5) * f64::from(self.columns) - 0.5;
        // Before a face's first centre and past its last the line goes on.
        let low = x.floor().clamp(0.0, f64::from(self.columns) - 2.0);
        let (column, share) = ((side * self.columns) as usize + low as usize, x - low);
        let slope_of = |kept| f64::from(2 * row(kept, self.size) + 1) / f64::from(self.size);
        let upper = (0..ROWS - 1).find(|kept| slope < slope_of(*kept)).unwrap_or(ROWS - 1);
        let at = |row| self.value(column, row) * (1.0 - share) + self.value(column + 1, row) * share;
        f.z * at(upper).min(at(upper.saturating_sub(1))) > 1.0 + TOLERANCE
    }
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
    fn seen(size: u32, inverse: impl Fn(DVec3) -> f64) -> Horizon {
        let texels = Projection::Hemicube.table(size).texels;
        Horizon::new(size, &texels.iter().map(|t| inverse(t.direction).max(0.0)).collect::<Vec<_>>())
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
                        assert!(!wall.hides(azimuth * reach), "{size} {turn} {azimuth} {share}");
                    }
                    let behind = (1.0 + TOLERANCE) * 1.02 / towards;
                    if towards > 4.0 / f64::from(size) {
                        assert!(wall.hides(azimuth * behind), "{size} {turn} {azimuth}");
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
                    assert!(!sphere.hides(p), "{size} {azimuth} {angle}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_hidden_under_the_open_sky() {
        let sky = seen(32, |_| 0.0);
        assert!(azimuths().all(|azimuth| !sky.hides(azimuth * 1e9)));
    }
}

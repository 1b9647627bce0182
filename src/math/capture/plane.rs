//! The plane: one perspective view along the normal, which sees a part of the hemisphere only.
//!
//! Border compensation: a texel at the border stands for all directions from its outer edge down to the horizon, within
//! the azimuths of that edge. With θ_b the edge's own angle at azimuth φ, that adds ½ ∫ cos²θ_b dφ to its
//! cosine-weighted solid angle and ∫ cosθ_b dφ to its solid angle (S0 takes one angle for all texels, and says cosθ_b δφ
//! for the former). The border's edges are arcs of great circles, and so are the meridians from their ends down to the
//! horizon: the texel and what is added to it are one spherical polygon, measured exactly, and all of them make up the
//! hemisphere. The meridians between neighbours are edges of the translation gradient like any other, at the distance
//! that the border's texels have; without compensation nothing moves in over the border.

use super::pitch;
use super::polygons::{Cell, Corner, Polygons};
use glam::DVec3;

/// Corners are in units of half a texel from the middle; the third number is 1 on the plane and 0 on the horizon.
pub(super) fn polygons(size: u32, half_width: f64, compensated: bool) -> Polygons {
    let pitch = pitch(size, half_width);
    let n = i64::from(size);
    let mut cells = Vec::with_capacity((size * size) as usize);
    for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
        let (left, top) = (2 * i64::from(x) - n, n - 2 * i64::from(y));
        let square = [[left, top, 1], [left, top - 2, 1], [left + 2, top - 2, 1], [left + 2, top, 1]];
        let corners = if compensated { down_to_the_horizon(&square, n) } else { square.to_vec() };
        let centre = DVec3::new((left + 1) as f64, (top - 1) as f64, 0.0) * pitch / 2.0 + DVec3::Z;
        cells.push(Cell { at: [0, x, y], centre, corners });
    }
    Polygons { cells, scale: DVec3::new(pitch / 2.0, pitch / 2.0, 1.0) }
}

/// The square with each side that lies on the border moved down to the horizon.
fn down_to_the_horizon(square: &[Corner; 4], border: i64) -> Vec<Corner> {
    let mut corners = Vec::with_capacity(8);
    for (side, &a) in square.iter().enumerate() {
        let b = square[(side + 1) % 4];
        corners.push(a);
        if (0..2).any(|axis| a[axis] == b[axis] && a[axis].abs() == border) {
            corners.extend([[a[0], a[1], 0], [b[0], b[1], 0]]);
        }
    }
    corners
}

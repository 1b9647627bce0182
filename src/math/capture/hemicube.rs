//! The hemicube: the top along +z, then +x, −x, +y, −y, of which only the half above the horizon counts (Cohen and
//! Greenberg 1985). The views are those of `glsl/inc/views.glsl`.

use super::polygons::{Cell, table as measure};
use super::{Table, pitch};
use glam::{DVec2, DVec3};

/// Point (x, y) at distance 1 on a face; the inverse of `face_coordinates` in `views.glsl`.
pub fn face_direction(face: u32, p: DVec2) -> DVec3 {
    match face {
        0 => DVec3::new(p.x, p.y, 1.0),
        1 => DVec3::new(1.0, p.x, p.y),
        2 => DVec3::new(-1.0, -p.x, p.y),
        3 => DVec3::new(-p.x, 1.0, p.y),
        4 => DVec3::new(p.x, -1.0, p.y),
        _ => DVec3::new(p.x, -p.y, -1.0),
    }
}

/// Corners are in units of 1/size on the cube.
pub(super) fn table(size: u32) -> Table {
    let n = f64::from(size);
    let pitch = pitch(size, 1.0);
    let point = |x: f64, y: f64| DVec2::new(x * pitch - 1.0, 1.0 - y * pitch);
    let mut cells = Vec::with_capacity(3 * (size * size) as usize);
    for face in 0..5 {
        let rows = if face == 0 { size } else { size / 2 };
        for (y, x) in (0..rows).flat_map(|y| (0..size).map(move |x| (y, x))) {
            let (left, top) = (f64::from(x), f64::from(y));
            let corner = |u: f64, v: f64| {
                (face_direction(face, point(left + u, top + v)) * n).to_array().map(|c| c.round() as i64)
            };
            cells.push(Cell {
                at: [face, x, y],
                centre: face_direction(face, point(left + 0.5, top + 0.5)),
                corners: vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0)],
            });
        }
    }
    measure(&cells, |corner| DVec3::from_array(corner.map(|c| c as f64)))
}

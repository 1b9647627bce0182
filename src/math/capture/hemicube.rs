//! The hemicube: the top along +z, then +x, −x, +y, −y, of which only the half above the horizon counts (Cohen and
//! Greenberg 1985). The whole cube has these faces in full, and −z. The views are those of `glsl/inc/views.glsl`.

use super::pitch;
use super::polygons::{Cell, Polygons};
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

/// The hemicube's texels.
pub(super) fn polygons(size: u32) -> Polygons {
    on_faces(size, [size, size / 2, size / 2, size / 2, size / 2].as_slice())
}

/// The cube's.
pub(super) fn whole_cube(size: u32) -> Polygons {
    on_faces(size, [size; 6].as_slice())
}

/// Texels of so many rows of each face, from the top. Corners are in units of 1/size on the cube.
fn on_faces(size: u32, rows: &[u32]) -> Polygons {
    let n = f64::from(size);
    let pitch = pitch(size, 1.0);
    let point = |x: f64, y: f64| DVec2::new(x * pitch - 1.0, 1.0 - y * pitch);
    let mut cells = Vec::with_capacity(3 * (size * size) as usize);
    for (face, &rows) in (0..).zip(rows) {
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
    Polygons { cells, scale: DVec3::ONE }
}

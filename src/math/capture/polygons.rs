//! Texels that are spherical polygons: all sides are arcs of great circles, as in every perspective view.

use super::{Edge, Table, Texel};
use glam::DVec3;
use std::collections::HashMap;

/// A corner by whole numbers, so that neighbours agree on shared ones.
pub(super) type Corner = [i64; 3];

/// A texel to be measured.
pub(super) struct Cell {
    /// View, column and row.
    pub at: [u32; 3],
    /// Through the centre, of any length, 1 along the view's axis.
    pub centre: DVec3,
    /// Corners in order.
    pub corners: Vec<Corner>,
}

/// Measures cells whose corners lie in the directions `direction` of any length.
pub(super) fn table(cells: &[Cell], direction: impl Fn(Corner) -> DVec3) -> Table {
    let unit = |corner: &Corner| direction(*corner).normalize();
    let texel = |cell: &Cell| {
        let polygon: Vec<DVec3> = cell.corners.iter().map(unit).collect();
        let flux = polygon_flux(&polygon);
        Texel {
            layer: cell.at[0],
            x: cell.at[1],
            y: cell.at[2],
            direction: cell.centre.normalize(),
            solid_angle: polygon_solid_angle(&polygon),
            flux: flux * flux.z.signum(),
            forward: 1.0 / cell.centre.length(),
        }
    };
    let texels: Vec<Texel> = cells.iter().map(texel).collect();
    let edges = inner_edges(cells, &texels, unit);
    Table { texels, edges }
}

/// ∫ ω dω over a spherical polygon (Lambert 1760): ½ Σ Θ_i Γ_i, outwards if its corners run counter-clockwise from within.
pub fn polygon_flux(vertices: &[DVec3]) -> DVec3 {
    let next = vertices.iter().cycle().skip(1);
    let side = |(a, b): (&DVec3, &DVec3)| {
        let cross = a.cross(*b);
        let sine = cross.length();
        if sine > 0.0 { cross * (sine.atan2(a.dot(*b)) / sine) } else { DVec3::ZERO }
    };
    vertices.iter().zip(next).map(side).sum::<DVec3>() / 2.0
}

/// Solid angle of a spherical polygon, as a fan of triangles: tan(Ω/2) = a·(b×c) / (1 + a·b + b·c + c·a) (Van Oosterom
/// and Strackee 1983).
pub fn polygon_solid_angle(vertices: &[DVec3]) -> f64 {
    let Some((a, rest)) = vertices.split_first() else { return 0.0 };
    let triangle = |pair: &[DVec3]| {
        let (b, c) = (pair[0], pair[1]);
        2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(*a))
    };
    rest.windows(2).map(triangle).sum::<f64>().abs()
}

/// Every side that two cells share.
fn inner_edges(cells: &[Cell], texels: &[Texel], unit: impl Fn(&Corner) -> DVec3) -> Vec<Edge> {
    let mut open: HashMap<(Corner, Corner), u32> = HashMap::new();
    let mut edges = Vec::with_capacity(texels.len() * 2);
    for (j, cell) in cells.iter().enumerate() {
        for (side, a) in cell.corners.iter().enumerate() {
            let b = &cell.corners[(side + 1) % cell.corners.len()];
            let key = (*a.min(b), *a.max(b));
            match open.remove(&key) {
                // A corner texel of a plane meets itself along a meridian.
                Some(i) if i == j as u32 => {}
                Some(i) => edges.push(edge(i, j as u32, texels, unit(&key.0), unit(&key.1))),
                None => {
                    open.insert(key, j as u32);
                }
            }
        }
    }
    edges.sort_by_key(|e| (e.i, e.j));
    edges
}

/// The arc from a to b: ∫ cosθ m dl = tan(γ/2) n·(a + b) m, γ the angle between them and m across the arc.
fn edge(i: u32, j: u32, texels: &[Texel], a: DVec3, b: DVec3) -> Edge {
    let across = a.cross(b).normalize();
    let towards = texels[j as usize].direction - texels[i as usize].direction;
    let m = if across.dot(towards) >= 0.0 { across } else { -across };
    // tan(γ/2) = sinγ/(1 + cosγ)
    let tangent = a.cross(b).length() / (1.0 + a.dot(b));
    Edge { i, j, step: tangent * (a.z + b.z) * m, middle: (a + b).normalize() }
}

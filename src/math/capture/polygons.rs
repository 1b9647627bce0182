//! Texels that are spherical polygons: all sides are arcs of great circles, as in every perspective view.

use super::{Edge, Table, Texel};
use crate::math::quadrature::{arc, gauss_legendre, spherical_triangle};
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

/// All texels of a projection.
pub(super) struct Polygons {
    /// Texels, view by view, row by row.
    pub cells: Vec<Cell>,
    /// A corner times this is its direction, of any length.
    pub scale: DVec3,
}

/// Two cells that share a side, and its ends.
struct Side {
    cells: [u32; 2],
    ends: [DVec3; 2],
}

/// Solid angle, sr, up to which a short rule does.
const SMALL: f64 = 0.05;

impl Polygons {
    /// Measures the cells and finds the edges between them.
    pub(super) fn table(&self) -> Table {
        let texels: Vec<Texel> = self.cells.iter().map(|cell| self.texel(cell)).collect();
        let edges = self.sides().iter().map(|side| side.edge(&texels)).collect();
        Table { texels, edges }
    }

    /// [`super::Shape::visit_texels`].
    pub(super) fn visit_texels(&self, visit: &mut dyn FnMut(usize, DVec3, f64)) {
        let [short, long] = [6, 20].map(gauss_legendre);
        for (i, cell) in self.cells.iter().enumerate() {
            let corners: Vec<DVec3> = cell.corners.iter().map(|corner| self.unit(corner)).collect();
            let rule = if polygon_solid_angle(&corners) < SMALL { &short } else { &long };
            // A fan: where corners turn back, its triangles' signs make up for it.
            for pair in corners[1..].windows(2) {
                spherical_triangle([corners[0], pair[0], pair[1]], rule).for_each(|(d, weight)| visit(i, d, weight));
            }
        }
    }

    /// [`super::Shape::visit_edges`].
    pub(super) fn visit_edges(&self, texels: &[Texel], visit: &mut dyn FnMut(usize, DVec3, DVec3)) {
        let [short, long] = [6, 20].map(gauss_legendre);
        for (e, side) in self.sides().iter().enumerate() {
            let ([a, b], m) = (side.ends, side.across(texels));
            let rule = if a.distance_squared(b) < SMALL { &short } else { &long };
            arc(a, b, rule).for_each(|(d, length)| visit(e, d, length * m));
        }
    }

    fn unit(&self, corner: &Corner) -> DVec3 {
        (DVec3::from_array(corner.map(|c| c as f64)) * self.scale).normalize()
    }

    fn texel(&self, cell: &Cell) -> Texel {
        let polygon: Vec<DVec3> = cell.corners.iter().map(|corner| self.unit(corner)).collect();
        let (flux, direction) = (polygon_flux(&polygon), cell.centre.normalize());
        Texel {
            layer: cell.at[0],
            x: cell.at[1],
            y: cell.at[2],
            direction,
            solid_angle: polygon_solid_angle(&polygon),
            flux: flux * flux.dot(direction).signum(),
            forward: 1.0 / cell.centre.length(),
        }
    }

    /// Every side that two cells share, by their numbers.
    fn sides(&self) -> Vec<Side> {
        let mut open: HashMap<(Corner, Corner), u32> = HashMap::new();
        let mut sides = Vec::with_capacity(self.cells.len() * 2);
        for (j, cell) in self.cells.iter().enumerate() {
            for (side, a) in cell.corners.iter().enumerate() {
                let b = &cell.corners[(side + 1) % cell.corners.len()];
                let key = (*a.min(b), *a.max(b));
                match open.remove(&key) {
                    // A corner texel of a plane meets itself along a meridian.
                    Some(i) if i == j as u32 => {}
                    Some(i) => {
                        let ends = [self.unit(&key.0), self.unit(&key.1)];
                        sides.push(Side { cells: [i, j as u32], ends });
                    }
                    None => {
                        open.insert(key, j as u32);
                    }
                }
            }
        }
        sides.sort_by_key(|side| side.cells);
        sides
    }
}

impl Side {
    /// The unit vector across the arc between its ends, from the first cell to the second.
    fn across(&self, texels: &[Texel]) -> DVec3 {
        let ([i, j], [a, b]) = (self.cells, self.ends);
        let across = a.cross(b).normalize();
        let towards = texels[j as usize].direction - texels[i as usize].direction;
        if across.dot(towards) >= 0.0 { across } else { -across }
    }

    /// ∫ cosθ m dl = tan(γ/2) n·(a + b) m, γ the angle between the ends a and b, and m across the arc.
    fn edge(&self, texels: &[Texel]) -> Edge {
        let ([i, j], [a, b]) = (self.cells, self.ends);
        // tan(γ/2) = sinγ/(1 + cosγ)
        let tangent = a.cross(b).length() / (1.0 + a.dot(b));
        Edge { i, j, step: tangent * (a.z + b.z) * self.across(texels), middle: (a + b).normalize() }
    }
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

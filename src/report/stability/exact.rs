//! Irradiance of a lit surface in closed form, occlusion included: what gradients in a room are held against.
//!
//! Each cell of the surface, of constant radiance, is cut by the shadow of every triangle as seen from the point; what is
//! left are convex polygons, whose irradiance is Lambert's. For scenes of few triangles.

use crate::math::form_factor::{clip, polygon};
use crate::methods::probes::SurfaceCell;
use glam::DVec3;
use rayon::prelude::*;

/// How much further than an occluder's plane something must be to lie behind it: rounding of positions along a shared edge.
const BEHIND: f64 = 1e-7;

/// A lit surface.
pub(super) struct Exact {
    cells: Vec<SurfaceCell>,
    /// What may hide it.
    pub triangles: Vec<[DVec3; 3]>,
}

/// The shadow of a triangle as seen from the origin: where all n·x > d, of these planes (n, d).
type Shadow = [(DVec3, f64); 4];

impl Exact {
    pub fn new(cells: Vec<SurfaceCell>, triangles: Vec<[DVec3; 3]>) -> Self {
        Self { cells, triangles }
    }

    /// Irradiance in the red channel at `p` on a surface of unit normal `n`.
    pub fn irradiance(&self, p: DVec3, n: DVec3) -> f64 {
        let shadows: Vec<Shadow> = self.triangles.iter().filter_map(|t| shadow(t.map(|c| c - p))).collect();
        // Summed in order: the same bits every time.
        let each: Vec<f64> = self.cells.par_iter().map(|cell| of_cell(cell, p, n, &shadows)).collect();
        each.iter().sum()
    }
}

fn of_cell(cell: &SurfaceCell, p: DVec3, n: DVec3, shadows: &[Shadow]) -> f64 {
    let corners = cell.corners.map(|c| c - p);
    let [a, b, c] = corners;
    let faces = (b - a).cross(c - a).dot(a) < 0.0;
    let radiance = f64::from(cell.radiance[usize::from(!faces)].x);
    if radiance == 0.0 || corners.iter().all(|c| n.dot(*c) <= 0.0) {
        return 0.0;
    }
    let mut pieces = vec![corners.to_vec()];
    for shadow in shadows {
        pieces = pieces.into_iter().flat_map(|piece| without(piece, shadow)).collect();
    }
    radiance * pieces.iter().map(|piece| polygon(n, piece)).sum::<f64>()
}

/// The shadow of a triangle; none where it is seen edge-on.
fn shadow([a, b, c]: [DVec3; 3]) -> Option<Shadow> {
    let normal = (b - a).cross(c - a);
    let height = normal.dot(a);
    if height.abs() <= 1e-12 * normal.length() {
        return None;
    }
    // a·(b × c) is the height: by its sign the sides' planes face inwards.
    let side = |from: DVec3, to: DVec3| (from.cross(to) * height.signum(), 0.0);
    Some([side(a, b), side(b, c), side(c, a), (normal / height, 1.0 + BEHIND)])
}

/// What is left of a convex polygon outside of a shadow, as convex polygons.
fn without(polygon: Vec<DVec3>, shadow: &Shadow) -> Vec<Vec<DVec3>> {
    if shadow.iter().any(|(n, d)| polygon.iter().all(|p| n.dot(*p) <= *d)) {
        return vec![polygon];
    }
    let (mut rest, mut outside) = (polygon, Vec::new());
    for &(n, d) in shadow {
        outside.push(clip(&rest, |p| d - n.dot(p)));
        rest = clip(&rest, |p| n.dot(p) - d);
    }
    outside.retain(|piece| piece.len() > 2);
    outside
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, dvec3};

    fn quad(corner: DVec3, u: DVec3, v: DVec3) -> [[DVec3; 3]; 2] {
        [[corner, corner + u, corner + v], [corner + u + v, corner + v, corner + u]]
    }

    /// A plate behind a smaller one: the whole less its shadow, in closed form.
    #[test]
    fn a_plate_is_seen_around_another() {
        let far = quad(dvec3(-1.0, -1.0, 2.0), DVec3::X * 2.0, DVec3::Y * 2.0);
        let near = quad(dvec3(-0.1, 0.1, 1.0), DVec3::X * 0.3, DVec3::Y * 0.2);
        let cell = |corners| SurfaceCell { corners, radiance: [Vec3::splat(3.0), Vec3::splat(2.0)] };
        let lit = far.map(cell).to_vec();
        let rectangle = |[[a, b, c], [d, ..]]: [[DVec3; 3]; 2]| polygon(DVec3::Z, &[a, b, d, c]);
        // Its back is what faces the origin.
        let whole = 2.0 * rectangle(far);
        let open = Exact::new(lit.clone(), far.to_vec()).irradiance(DVec3::ZERO, DVec3::Z);
        assert!((open - whole).abs() < 1e-12, "{open} {whole}");
        let part = Exact::new(lit, [far, near].concat()).irradiance(DVec3::ZERO, DVec3::Z);
        let expected = whole - 2.0 * rectangle(near);
        assert!((part - expected).abs() < 1e-9, "{part} {expected}");
    }
}

//! Captures as tables: what each texel of a projection measures, and the edges between texels.
//!
//! A capture is views and the measure of their texels; an integrator is a capture and a basis. Whatever the projection, a
//! table holds for each texel the exact integral of its directions, and for each edge between two texels the exact
//! integral along it, so that one shader (`glsl/integrate`) serves all of them. [`Table::integrate`] is its CPU twin.
//!
//! Local frame: the normal is +z. Directions have unit length.

mod basis;
mod faces;
mod hemicube;
mod hemisphere;
mod plane;
mod polygons;
#[cfg(test)]
mod tests;

pub use basis::{Basis, Coefficient, Weights};
pub use faces::Faces;
pub use hemicube::face_direction;
pub use polygons::{polygon_flux, polygon_solid_angle};

use glam::DVec3;
use std::f64::consts::PI;

/// How directions become texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Five faces at distance 1, the sides cut at the horizon (Cohen and Greenberg 1985).
    Hemicube,
    /// One perspective view along the normal.
    Plane {
        /// Half the width of the plane at distance 1: the tangent of half the aperture.
        half_width: f64,
        /// Whether the texels at the border stand for what lies between them and the horizon.
        compensated: bool,
    },
    /// One view of the whole hemisphere, projected onto the disc below it (Nusselt 1928).
    Hemisphere,
    /// Six faces at distance 1, without a horizon. The cosine has no meaning there: it takes a [`Basis`] of the whole sphere.
    Cube,
}

/// The texels of a projection before anything is integrated over them.
enum Shape {
    /// Spherical polygons.
    Polygons(polygons::Polygons),
    /// Squares on the disc below the hemisphere.
    Disc(hemisphere::Grid),
}

/// A texel of a capture.
#[derive(Clone, Copy, Debug)]
pub struct Texel {
    /// View that it belongs to.
    pub layer: u32,
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Direction through the centre, where it is sampled.
    pub direction: DVec3,
    /// Solid angle, sr.
    pub solid_angle: f64,
    /// ∫ ω dω over the directions that it stands for.
    pub flux: DVec3,
    /// Cosine between its direction and the axis of its face: 1/distance is this times 1/(distance along the axis).
    pub forward: f64,
}

/// An edge between two texels, with the factor of the translation gradient.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// First texel.
    pub i: u32,
    /// Second texel.
    pub j: u32,
    /// ∫ cosθ m dl along the edge; the unit vector m is perpendicular to the direction and to the edge, from i to j.
    pub step: DVec3,
    /// Unit direction of the edge's middle.
    pub middle: DVec3,
}

/// All texels of a capture and all edges between them.
pub struct Table {
    /// Texels, view by view, row by row.
    pub texels: Vec<Texel>,
    /// Edges, seams between views included; those on the horizon vanish and are left out.
    pub edges: Vec<Edge>,
}

/// What a texel sees.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Radiance, W·sr⁻¹·m⁻².
    pub radiance: f64,
    /// 1/distance through the texel's centre; 0 for the sky.
    pub inverse_distance: f64,
    /// Plane of what is seen: along any unit direction its dot product is 1/distance.
    pub plane: DVec3,
}

/// What a capture tells about its record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integral {
    /// Irradiance for radiance given in W·sr⁻¹·m⁻².
    pub irradiance: f64,
    /// Rotation gradient ∫ L (n×ω) dω.
    pub rotation: DVec3,
    /// Translation gradient.
    pub translation: DVec3,
    /// Hessian of the irradiance under translation in the tangent plane: xx, xy, yy.
    pub hessian: DVec3,
    /// Harmonic mean of the distances, cosine-weighted: 1/R.
    pub inverse_distance: f64,
}

impl Texel {
    /// Cosine-weighted solid angle ∫ cosθ dω, sr.
    pub fn weight(&self) -> f64 {
        self.flux.z
    }

    /// ∫ n×ω dω: the weight in the rotation gradient.
    pub fn turn(&self) -> DVec3 {
        DVec3::Z.cross(self.flux)
    }
}

impl Edge {
    /// Factor of the second derivatives xx, xy and yy for 1/distance²: the step's own derivative, the edge staying where it
    /// is in space; `glsl/inc/sums.glsl` derives it.
    pub fn bend(&self) -> DVec3 {
        let (s, m) = (self.step, self.middle);
        DVec3::new(4.0 * s.x * m.x, 2.0 * (s.x * m.y + s.y * m.x), 4.0 * s.y * m.y)
    }
}

impl Projection {
    /// The table of `size` texels a side; `size` is even.
    pub fn table(self, size: u32) -> Table {
        match self.shape(size) {
            Shape::Polygons(polygons) => polygons.table(),
            Shape::Disc(grid) => grid.table(),
        }
    }

    /// Whether nothing below a surface's plane is seen.
    pub fn has_horizon(self) -> bool {
        self != Self::Cube
    }

    fn shape(self, size: u32) -> Shape {
        assert!(size >= 2 && size.is_multiple_of(2), "a capture's size is even");
        match self {
            Self::Hemicube => Shape::Polygons(hemicube::polygons(size)),
            Self::Cube => Shape::Polygons(hemicube::whole_cube(size)),
            Self::Plane { half_width, compensated } => Shape::Polygons(plane::polygons(size, half_width, compensated)),
            Self::Hemisphere => Shape::Disc(hemisphere::Grid::new(size)),
        }
    }
}

impl Shape {
    /// Gives the directions and solid angles of a rule over every texel, with the texel's number.
    fn visit_texels(&self, visit: &mut dyn FnMut(usize, DVec3, f64)) {
        match self {
            Self::Polygons(polygons) => polygons.visit_texels(visit),
            Self::Disc(grid) => grid.visit_texels(visit),
        }
    }

    /// Gives the directions of a rule along every edge of `table`, this shape's own, with the edge's number and m dl.
    fn visit_edges(&self, table: &Table, visit: &mut dyn FnMut(usize, DVec3, DVec3)) {
        match self {
            Self::Polygons(polygons) => polygons.visit_edges(&table.texels, visit),
            Self::Disc(grid) => grid.visit_edges(visit),
        }
    }
}

impl Table {
    /// Σ of all weights: π where the whole hemisphere is seen.
    pub fn weight(&self) -> f64 {
        self.texels.iter().map(Texel::weight).sum()
    }

    /// Between the centres of an edge's texels, where the faces or the disc are.
    pub fn between(&self, edge: &Edge) -> DVec3 {
        let centre = |i: u32| self.texels[i as usize].direction / self.texels[i as usize].forward;
        (centre(edge.i) + centre(edge.j)) / 2.0
    }

    /// CPU twin of `glsl/integrate`: `seen` holds what each texel sees.
    ///
    /// An edge moves as the nearer surface does: by −δ·m/r for a step δ, so that ∇_t E = −Σ (L_i − L_j) ∫ cosθ m dl / r.
    pub fn integrate(&self, seen: &[Seen]) -> Integral {
        let mut sum = Integral::default();
        for (texel, seen) in self.texels.iter().zip(seen) {
            sum.irradiance += texel.weight() * seen.radiance;
            sum.inverse_distance += texel.weight() * seen.inverse_distance;
            sum.rotation += seen.radiance * texel.turn();
        }
        sum.inverse_distance /= self.weight();
        for edge in &self.edges {
            let (i, j) = (edge.i as usize, edge.j as usize);
            let between = self.between(edge).normalize();
            let change = seen[i].radiance - seen[j].radiance;
            sum.translation -= change * inverse_edge_distance(&seen[i], &seen[j], between) * edge.step;
            let nearest = seen[i].inverse_distance.max(seen[j].inverse_distance);
            sum.hessian -= change * nearest * nearest * edge.bend();
        }
        sum
    }
}

/// 1/distance of the nearer surface where its plane meets the edge; `inc/sums.glsl` says why.
fn inverse_edge_distance(a: &Seen, b: &Seen, between: DVec3) -> f64 {
    let near = if a.inverse_distance >= b.inverse_distance { a } else { b };
    let q = near.inverse_distance;
    near.plane.dot(between).clamp(-q, 3.0 * q)
}

/// Width of a texel where the whole side is `2 half_width` long.
fn pitch(size: u32, half_width: f64) -> f64 {
    2.0 * half_width / f64::from(size)
}

/// Share of the cosine-weighted hemisphere that a plane of half width w sees: (4/π)·k·atan k, k = w/√(1 + w²).
///
/// The form factor of a square seen from its axis (Hamilton and Morgan 1952), four quarters.
pub fn seen_by_plane(half_width: f64) -> f64 {
    let k = half_width / half_width.hypot(1.0);
    4.0 / PI * k * k.atan()
}

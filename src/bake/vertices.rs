//! Irradiance at vertices, chosen so that what is interpolated between them comes closest to the surface's (Kavan, Bargteil and
//! Sloan 2011, "Least squares vertex baking"): x minimises ∫(Σ xᵢφᵢ − E)² dA, φᵢ being linear on each triangle, and a
//! little of the bend across edges.
//!
//! Vertices at one place with one normal, as where texture coordinates have a seam, have one value.

mod mesh;
mod solve;

use crate::methods::surface_irradiance::SurfaceIrradiance;
use crate::scene::Scene;
use glam::{DVec3, Vec3};
use mesh::Mesh;
use std::fmt;

/// Bend across an edge counts as much as the error over this share of its triangles' area.
const SMOOTHNESS: f64 = 1e-3;

/// How vertices get their values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexMethod {
    /// Least squares over the triangles.
    LeastSquares,
    /// The irradiance of the cells that lie at the vertex: for comparison.
    Sampled,
}

/// Irradiance at vertices, and how close it comes to the surface's.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexIrradiance {
    /// Of each vertex of the scene, W·m⁻²; not negative. Zero where no triangle is.
    pub values: Vec<Vec3>,
    /// Values that are independent of each other.
    pub unknowns: usize,
    /// Steps of the solver.
    pub steps: usize,
    /// Against the surface's irradiance.
    pub off: Off,
}

/// How far interpolated irradiance is from the surface's, all channels together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// Root of the mean square, as a share of that of the irradiance.
    pub rms: f64,
    /// Mean of the absolute difference, as a share of the mean.
    pub mean: f64,
    /// The whole of it, as a share of what it should be.
    pub energy: f64,
}

impl fmt::Display for Off {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [mean, rms, energy] = [self.mean, self.rms, self.energy - 1.0].map(|share| 100.0 * share);
        write!(f, "off by {mean:.2} % (root mean square {rms:.2} %), energy {energy:+.2} %")
    }
}

impl VertexIrradiance {
    /// Brings the irradiance of `scene`'s surface to its vertices.
    ///
    /// A triangle has that of its front; where its material is double-sided, that of the side that has more.
    pub fn new(scene: &Scene, found: &SurfaceIrradiance, method: VertexMethod) -> Self {
        let mesh = Mesh::new(scene, found);
        let (values, steps) = match method {
            VertexMethod::LeastSquares => solve::least_squares(&mesh, SMOOTHNESS),
            VertexMethod::Sampled => (solve::sampled(&mesh), 0),
        };
        let values: Vec<DVec3> = values.into_iter().map(|value| value.max(DVec3::ZERO)).collect();
        let off = mesh.off(&values);
        let of_vertex = |unknown: &Option<u32>| unknown.map_or(Vec3::ZERO, |u| values[u as usize].as_vec3());
        Self { values: mesh.unknowns.iter().map(of_vertex).collect(), unknowns: values.len(), steps, off }
    }
}

#[cfg(test)]
mod tests;

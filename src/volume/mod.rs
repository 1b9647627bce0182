//! Irradiance volumes: light at samples in space, for objects that move (Greger et al. 1998; Tatarchuk and Oat 2005).
//!
//! A [`Volume`] has samples at the corners of cells. The cells are a uniform grid, or the leaves of octrees that stand on one
//! ([`Lattice`]). A [`Reader`] interpolates between samples in one of several ways ([`Interpolation`]), and [`visibility`] keeps
//! light from passing through walls. [`place`] decides where samples are, [`file`](mod@file) reads and writes JSON, [`export`] writes
//! the formats of engines, and [`memory`] counts floats and bytes. This module runs on the CPU and knows of no device;
//! [`crate::methods::volume`] measures the samples. The guide describes volumes and their file ([`crate::guide::volumes`]).
//!
//! A sample holds radiance as spherical harmonics ([`crate::math::sh`]), W·sr⁻¹·m⁻²: the light that surfaces reflect, and the sky's.
//! Positions are in the scene's own coordinates.

pub mod cell;
pub mod export;
pub mod file;
mod jets;
pub mod lattice;
pub mod memory;
pub mod place;
pub mod reader;
#[cfg(test)]
mod tests;
pub mod tree;
pub mod visibility;

pub use cell::Interpolation;
pub use lattice::{Cell, Lattice};
pub use reader::{NotThere, Reader};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Position of a sample relative to its corner of the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// The sample is at its corner.
    #[default]
    Free,
    /// The corner is inside of geometry; the sample stands beside it, outside of the geometry.
    Moved,
    /// The sample is inside of geometry. Interpolation uses it only where no other sample is.
    Inside,
}

/// Light at a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// The point, in the scene's coordinates.
    pub position: DVec3,
    /// Radiance as spherical harmonics, W·sr⁻¹·m⁻², for the three colour channels.
    pub coefficients: Vec<Vec3>,
    /// Derivatives of each coefficient along x, y and z, per unit of length; empty in a volume without gradients.
    pub gradients: Vec<[Vec3; 3]>,
    /// Share of the sphere that backs of triangles fill, 0 to 1.
    pub back_share: f32,
    /// 1/R: R is the harmonic mean, by solid angle, of the distances that the sample sees. 0 where only the sky is seen.
    pub inverse_distance: f32,
    /// Mean of the distance and mean of its square in each cell of [`crate::math::octahedron`], weighted by solid angle over the
    /// distance's square; empty in a volume without moments.
    pub moments: Vec<[f32; 2]>,
    /// Position relative to its corner.
    pub state: State,
}

/// Samples at the corners of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Order of the harmonics, 2 to [`crate::math::sh::MAX_ORDER`].
    pub order: u32,
    /// Number of reflections of the light, or `all`.
    pub bounces: String,
    /// Lowest and highest corner of the box in which the volume can be read, in the scene's coordinates.
    pub bounds: [DVec3; 2],
    /// The samples.
    pub samples: Vec<Sample>,
    /// The cells, whose corners are numbers of samples. They lie inside of `bounds`; in the rim around them the nearest point of the
    /// cells is read.
    pub lattice: Lattice,
}

impl Volume {
    /// Whether samples have gradients.
    pub fn has_gradients(&self) -> bool {
        self.samples.first().is_some_and(|sample| !sample.gradients.is_empty())
    }

    /// Whether a point lies in the box, its faces included.
    pub fn contains(&self, point: DVec3) -> bool {
        let [low, high] = self.bounds;
        point.cmpge(low).all() && point.cmple(high).all()
    }

    /// Whether samples have moments of the distance.
    pub fn has_moments(&self) -> bool {
        self.samples.first().is_some_and(|sample| !sample.moments.is_empty())
    }
}

//! Irradiance volumes: light at samples in space, for what moves (Greger et al. 1998; Tatarchuk and Oat 2005).
//!
//! A [`Volume`] is samples at the corners of cells: a uniform grid, or leaves of octrees that stand on one ([`Lattice`]). A
//! [`Reader`] interpolates it: [`Interpolation`] names the ways, [`visibility`] keeps light from passing through walls. [`place`]
//! decides where samples are, [`file`](mod@file) is the documented JSON format, [`memory`] counts floats and bytes. All of it runs on
//! the CPU and knows of no device: whoever bakes says how a sample is measured ([`place::Measured`]).
//!
//! A sample holds radiance as spherical harmonics ([`crate::math::sh`]), W·sr⁻¹·m⁻², of the light that surfaces reflect and of the
//! sky. Positions are in the scene's own coordinates.

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

/// Where a sample stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// At its corner of the cells.
    #[default]
    Free,
    /// Beside its corner, which is inside of geometry.
    Moved,
    /// Inside of geometry: it takes no part in interpolation wherever another sample does.
    Inside,
}

/// Light at a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Where it was measured.
    pub position: DVec3,
    /// Radiance as spherical harmonics, a colour channel each, W·sr⁻¹·m⁻².
    pub coefficients: Vec<Vec3>,
    /// How each coefficient changes along x, y and z, per unit of length. Empty if they were not asked for.
    pub gradients: Vec<[Vec3; 3]>,
    /// Share of the sphere in which backs of triangles are seen, 0 to 1.
    pub back_share: f32,
    /// 1/R: R is the harmonic mean, by solid angle, of the distances that are seen. 0 where nothing but the sky is.
    pub inverse_distance: f32,
    /// Mean distance and mean square of the distance, by solid angle over the distance's square, in each cell of [`crate::math::octahedron`]. Empty if they were not kept.
    pub moments: Vec<[f32; 2]>,
    /// Where it stands.
    pub state: State,
}

/// Samples at the corners of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Order of the harmonics, 2 to [`crate::math::sh::MAX_ORDER`].
    pub order: u32,
    /// Reflections of the light: a number, or `all`.
    pub bounces: String,
    /// The samples.
    pub samples: Vec<Sample>,
    /// The cells, whose corners are numbers of samples.
    pub lattice: Lattice,
}

impl Volume {
    /// Whether samples have gradients.
    pub fn has_gradients(&self) -> bool {
        self.samples.first().is_some_and(|sample| !sample.gradients.is_empty())
    }

    /// Whether samples have moments of the distance.
    pub fn has_moments(&self) -> bool {
        self.samples.first().is_some_and(|sample| !sample.moments.is_empty())
    }
}

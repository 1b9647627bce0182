//! Techniques: passes composed into something a user would name.

use crate::passes::geometry::Geometry;
use crate::passes::material::Textures;
use crate::scene::Scene;

pub mod captures;
pub mod cascades;
pub mod casters;
pub mod direct;
pub mod emitter_samples;
mod far_view;
pub mod gather;
pub mod irradiance_cache;
pub mod light_samples;
pub mod light_set;
pub mod probes;
pub mod rates;
pub mod records;
mod sky;
pub mod sphere_probes;
pub mod surface_cache;
pub mod surface_irradiance;
pub mod volume;
pub mod work;

pub use sky::{Sky, has_suns, sky_bytes};

/// What every technique stands on.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// Scene on the CPU.
    pub scene: &'a Scene,
    /// Geometry and lit surface.
    pub geometry: &'a Geometry,
    /// Textures.
    pub textures: Option<&'a Textures>,
}

//! The surface cache: light that goes on from surface to surface, captured once and gathered as often as there are bounces.
//!
//! Sparse places on the surface, one for some hundred cells, capture a hemicube each, which is kept as the numbers of the cells
//! that its texels see. Irradiance by one reflection is a sum over these; that by every further one a sparse product
//! ([`system`]). Patches of cells get theirs by interpolation between places (`interpolate`) and reflect it on top of their direct light,
//! for whatever looks at the lit surface next.
//!
//! Captures of cells with light, one for each place and bounce, would take as long as the first ones every time; a product
//! takes a few milliseconds. The memory for it is 512 MB at most: in scenes that need more places, these lie further apart.

mod choose;
mod course;
mod gmres;
mod interpolate;
mod light;
mod numbers;
mod places;
mod reflected;
mod sides;
pub mod solve;
pub mod system;
mod vectors;

pub use numbers::Looking;
pub use solve::{Solver, Step};

use super::Ground;
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Memory, Result};
use course::SurfaceCache;
use std::sync::Arc;

/// As many bounces as carry light.
pub const ALL_BOUNCES: u32 = u32::MAX;
/// Bytes of what texels see, at most.
const SEEN_BYTES: usize = 512 << 20;

/// How light goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCacheSettings {
    /// Reflections whose light cells receive: 1 adds the light by one reflection to direct light; [`ALL_BOUNCES`] all.
    pub bounces: u32,
    /// Of all bounces, the share of the light that may be missing after the last product.
    pub tolerance: f32,
    /// How all bounces are summed.
    pub solver: Solver,
    /// Places, about. `None`: by the number of cells.
    pub places: Option<u32>,
    /// How places look.
    pub looking: Looking,
}

/// What was done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounced {
    /// Places that captured.
    pub places: u64,
    /// Rounds in which they were chosen.
    pub rounds: u32,
    /// Bytes of what their texels see.
    pub seen_bytes: u64,
    /// Entries of the matrix.
    pub entries: u64,
    /// Where the sum of bounces stood after each product.
    pub steps: Vec<Step>,
    /// What the bounces left out would add, as a share of all light by reflection.
    pub lost: f64,
    /// Milliseconds that choosing and capturing places, building the matrix, solving, and lighting cells took.
    pub times_ms: [f64; 4],
    /// Whether more light is missing than the tolerance allows.
    pub is_unfinished: bool,
    /// Whether more places would have been needed than memory is set aside for.
    pub is_cut: bool,
}

impl Bounced {
    /// What was not done as asked for, for the user.
    pub fn warning(&self) -> Option<String> {
        let Self { places, steps, lost, .. } = self;
        if self.is_cut {
            let limit = SEEN_BYTES >> 20;
            return Some(format!(
                "what {places} places see takes {limit} MB, and light beyond the first bounce has no more places"
            ));
        }
        let (products, lost) = (steps.len(), lost * 100.0);
        let unfinished = || {
            format!(
                "bounces: after {products} products {lost:.2} % of the light are missing; is a closed room's albedo 1?"
            )
        };
        self.is_unfinished.then(unfinished)
    }
}

/// Adds to the light of all cells of `ground`, which are lit directly, what they reflect of each other's. `on_progress` hears
/// stages done, of three.
///
/// # Errors
/// The device's. The cells have their direct light then.
pub fn add_bounces(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    ground: &Ground<'_>,
    settings: &SurfaceCacheSettings,
    on_progress: &mut dyn FnMut(u64),
) -> Result<Bounced> {
    let cache = SurfaceCache::new(device, recorder, ground, settings)?;
    let found = cache.gather(recorder, on_progress);
    let irradiance = found.as_ref().ok().and_then(|(irradiance, _)| irradiance.as_deref());
    let light = irradiance.map(|irradiance| cache.light(irradiance));
    ground.geometry.cell_radiance.upload(light.as_ref().unwrap_or(&cache.direct))?;
    Ok(found?.1)
}

/// Irradiance by the light of `settings.bounces` reflections of both sides of each cell of `ground`, W·m⁻². The cells are lit
/// directly, and stay so.
///
/// # Errors
/// The device's.
pub fn reflected_irradiance(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    ground: &Ground<'_>,
    settings: &SurfaceCacheSettings,
    on_progress: &mut dyn FnMut(u64),
) -> Result<(Vec<[f32; 3]>, Bounced)> {
    let cache = SurfaceCache::new(device, recorder, ground, settings)?;
    let found = cache.gather(recorder, on_progress);
    ground.geometry.cell_radiance.upload(&cache.direct)?;
    let (irradiance, bounced) = found?;
    Ok((irradiance.unwrap_or_else(|| vec![[0.0; 3]; cache.direct.len()]), bounced))
}

/// Radiance of every side, and the first cell of every triangle.
pub(super) fn read_surface(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    ground: &Ground<'_>,
) -> Result<(Vec<[f32; 3]>, Vec<u32>)> {
    let geometry = ground.geometry;
    let (radiance, first) = (&geometry.cell_radiance, &geometry.first_cell);
    let room = |buffer: &Buffer| Buffer::new(device, "surface radiance", buffer.size, Memory::Readback);
    let (to_radiance, to_first) = (room(radiance)?, room(first)?);
    recorder.submit(|recording| {
        recording.pass("readback", |c| {
            c.copy_buffer(radiance, &to_radiance, radiance.size);
            c.copy_buffer(first, &to_first, first.size);
            Ok(())
        })
    })?;
    Ok((to_radiance.read(2 * geometry.cell_count as usize), to_first.read(geometry.triangles.len() + 1)))
}

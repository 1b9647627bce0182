//! Direct light: every light sample's shadow is rendered once, in batches, and lights the surface cells and the pixels.

pub use super::light_samples::{Extent, LightKind, LightSet, LightSettings, TooManyLights, light_sets};
use crate::passes::capture::{Capture, CaptureDesc, pays_to_cull};
use crate::passes::gbuffer::Targets;
use crate::passes::geometry::Geometry;
use crate::passes::material::Textures;
use crate::passes::pixel_light::PixelLight;
use crate::passes::surface_light::{Batch, SurfaceLight};
use crate::scene::Scene;
use crate::vk::gpu_types::LightSample;
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Memory, Result};
use std::sync::Arc;

/// Bytes of shadow depth that are held at once.
const SHADOW_BUDGET: u64 = 128 << 20;
/// Fewest points of a cell that a light is evaluated at, over all its samples.
const POINTS_IN_CELL: u32 = 16;

/// What direct light is computed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Receivers {
    /// Surface cells: needed by captures.
    pub cells: bool,
    /// Pixels.
    pub pixels: bool,
}

/// What the renderer has on the GPU.
pub struct Target<'a> {
    /// Scene on the CPU.
    pub scene: &'a Scene,
    /// Geometry and cells.
    pub geometry: &'a Geometry,
    /// Textures.
    pub textures: Option<&'a Textures>,
    /// G-buffer.
    pub gbuffer: &'a Targets,
    /// Direct irradiance, four floats a pixel; `None` where no light reaches pixels directly.
    pub direct: Option<&'a Buffer>,
}

/// Passes for one set of lights.
pub struct DirectLight {
    set: LightSet,
    shadow: Capture,
    lights: Buffer,
    surface: Option<SurfaceLight>,
    pixel: Option<PixelLight>,
    lift: f32,
}

impl DirectLight {
    /// Builds the passes that `set` needs.
    pub fn new(device: &Arc<Device>, set: LightSet, target: &Target<'_>, cells: bool) -> Result<Self> {
        let tile = u64::from(set.shadow_size).pow(2) * u64::from(set.views.count()) * 4;
        let capacity = (SHADOW_BUDGET / tile).clamp(1, set.samples.len() as u64) as u32;
        let desc = CaptureDesc {
            name: "shadow",
            views: set.views,
            size: set.shadow_size,
            capacity,
            identity: false,
            culled: pays_to_cull(device, target.geometry.triangle_count),
        };
        let Target { scene, geometry, textures, gbuffer, direct } = *target;
        let shadow = Capture::new(device, scene, geometry, textures, desc)?;
        let bytes = u64::from(shadow.desc.capacity) * size_of::<LightSample>() as u64;
        let lights = Buffer::new(device, "light samples", bytes, Memory::Device)?;
        let kind = (set.kind, &shadow);
        let surface = cells.then(|| SurfaceLight::new(device, scene, geometry, textures, kind, &lights)).transpose()?;
        let pixel = direct
            .filter(|_| !set.cells_only)
            .map(|direct| PixelLight::new(device, gbuffer, kind, &lights, direct))
            .transpose()?;
        let lift = geometry.radius * 1e-6;
        Ok(Self { set, shadow, lights, surface, pixel, lift })
    }

    /// Number of light samples.
    pub fn sample_count(&self) -> usize {
        self.set.samples.len()
    }

    /// Renders all batches of shadows and adds their light.
    pub fn run(&self, recorder: &mut Recorder, target: &Target<'_>, mut done: impl FnMut(usize)) -> Result<()> {
        let capacity = self.shadow.desc.capacity as usize;
        let points = POINTS_IN_CELL.div_ceil(self.set.samples.len() as u32);
        for (index, samples) in self.set.samples.chunks(capacity).enumerate() {
            let first = index * capacity;
            let count = samples.len() as u32;
            self.lights.upload(samples)?;
            self.shadow.frames.upload(&self.set.frames[first..first + samples.len()])?;
            recorder.submit(|recording| {
                if self.shadow.is_culled() {
                    recording.pass("cull", |c| {
                        self.shadow.record_cull(c, count);
                        Ok(())
                    })?;
                }
                recording.pass("shadow", |c| {
                    self.shadow.record(c, target.geometry, target.textures, count);
                    Ok(())
                })?;
                if let Some(surface) = &self.surface {
                    let batch = Batch { first: first as u32, count, points, lift: self.lift };
                    recording.pass("surface_light", |c| {
                        surface.record(c, target.scene, target.geometry, target.textures, batch);
                        Ok(())
                    })?;
                }
                if let Some(pixel) = &self.pixel {
                    recording.pass("pixel_light", |c| {
                        pixel.record(c, count, self.lift);
                        Ok(())
                    })?;
                }
                Ok(())
            })?;
            done(samples.len());
        }
        Ok(())
    }
}

//! Direct light: every light sample's shadow is rendered once, in batches, and lights the surface cells and the pixels.

use super::Ground;
use super::casters::Casters;
use super::light_set::{Face, LightSet};
use crate::passes::capture::{Capture, CaptureDesc, FramesBy, pays_to_cull};
use crate::passes::gbuffer::Targets;
use crate::passes::pixel_light::PixelLight;
use crate::passes::shadow::Shadow;
use crate::passes::surface_light::{Batch, SurfaceLight};
use crate::vk::gpu_types::{EmitterFace, LightSample};
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Memory, Result, Sampler};
use std::sync::Arc;

/// Bytes of shadow tiles, depth and identity, that are held at once.
const SHADOW_BUDGET: u64 = 128 << 20;
/// Fewest points of a cell that a light is evaluated at, over all its samples.
const POINTS_IN_CELL: u32 = 8;

/// Passes for one set of lights.
pub struct DirectLight<'a> {
    set: LightSet,
    casters: Arc<Casters<'a>>,
    shadow: Capture,
    lights: Buffer,
    faces: Option<Buffer>,
    _sampler: Sampler,
    surface: Option<SurfaceLight>,
    pixel: Option<PixelLight>,
    lift: f32,
}

impl<'a> DirectLight<'a> {
    /// Builds the passes that `set` needs.
    ///
    /// Pixels see the shadows of exact `casters` only; `pixels` are the visible surfaces and the buffer of their
    /// direct irradiance, four floats a pixel; `cells` says whether captures will read the surface cells.
    pub fn new(
        device: &Arc<Device>,
        set: LightSet,
        ground: &Ground<'_>,
        casters: &Arc<Casters<'a>>,
        pixels: Option<(&Targets, &Buffer)>,
        cells: bool,
    ) -> Result<Self> {
        let tile = u64::from(set.shadow_size).pow(2) * u64::from(set.views.count()) * 8;
        let capacity = (SHADOW_BUDGET / tile).clamp(1, set.samples.len() as u64) as u32;
        let desc = CaptureDesc {
            name: "shadow",
            views: set.views,
            size: set.shadow_size,
            capacity,
            keeps_depth: true,
            culled: pays_to_cull(device, casters.geometry.triangle_count),
            frames: FramesBy::on(device),
        };
        let Ground { scene, geometry, textures } = *ground;
        let shadow = Capture::new(device, casters.scene, casters.geometry, textures, desc)?;
        let bytes = u64::from(shadow.desc.capacity) * size_of::<LightSample>() as u64;
        let lights = Buffer::new(device, "light samples", bytes, Memory::Device)?;
        // A batch holds no more faces than samples.
        let bytes = u64::from(shadow.desc.capacity) * size_of::<EmitterFace>() as u64;
        let pixels = pixels.filter(|_| !set.cells_only);
        let has_faces = pixels.is_some() && !set.faces.is_empty();
        let faces = has_faces.then(|| Buffer::new(device, "light samples", bytes, Memory::Device)).transpose()?;
        let sampler = Sampler::new(device, [ash::vk::SamplerAddressMode::CLAMP_TO_EDGE; 2], true)?;
        let shadows = Shadow {
            kind: set.kind,
            capture: &shadow,
            lights: &lights,
            sampler: &sampler,
            triangles: &casters.triangles,
            opaque: casters.scene.opaque_count(),
            own: casters.error == 0.0,
        };
        let surface = cells.then(|| SurfaceLight::new(device, scene, geometry, textures, &shadows)).transpose()?;
        let pixel = pixels
            .map(|(gbuffer, direct)| PixelLight::new(device, gbuffer, &shadows, faces.as_ref(), direct))
            .transpose()?;
        let lift = (geometry.radius * 1e-6).max(casters.lift());
        let (casters, _sampler) = (casters.clone(), sampler);
        Ok(Self { set, casters, shadow, lights, faces, _sampler, surface, pixel, lift })
    }

    /// Number of light samples.
    pub fn sample_count(&self) -> usize {
        self.set.samples.len()
    }

    /// Renders all batches of shadows and adds their light.
    pub fn run(&self, recorder: &mut Recorder, ground: &Ground<'_>, mut done: impl FnMut(usize)) -> Result<()> {
        let capacity = self.shadow.desc.capacity as usize;
        let points = POINTS_IN_CELL.div_ceil(self.set.samples.len() as u32);
        for (index, samples) in self.set.samples.chunks(capacity).enumerate() {
            let first = index * capacity;
            let count = samples.len() as u32;
            self.lights.upload(samples)?;
            let faces = Face::of_batch(&self.set.faces, &(first as u32..first as u32 + count));
            if let Some(buffer) = &self.faces {
                buffer.upload(&faces)?;
            }
            self.shadow.frames.upload(&self.set.frames[first..first + samples.len()])?;
            recorder.submit(|recording| {
                if self.shadow.is_culled() {
                    recording.pass("cull", |c| {
                        self.shadow.record_cull(c, count);
                        Ok(())
                    })?;
                }
                recording.pass("shadow", |c| {
                    self.shadow.record(c, self.casters.geometry, ground.textures, count);
                    Ok(())
                })?;
                if let Some(surface) = &self.surface {
                    let batch = Batch { first: first as u32, count, points, lift: self.lift, stride: self.set.stride };
                    recording.pass("surface_light", |c| {
                        surface.record(c, ground.scene, ground.geometry, ground.textures, batch);
                        Ok(())
                    })?;
                }
                if let Some(pixel) = &self.pixel {
                    recording.pass("pixel_light", |c| {
                        pixel.record(c, if self.faces.is_some() { faces.len() as u32 } else { count }, self.lift);
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

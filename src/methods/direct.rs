//! Direct light: every light sample's shadow is rendered in batches, and lights the surface cells, the pixels of a view, or both.

use super::Ground;
use super::casters::Casters;
use super::light_set::{Face, LightSet};
use crate::math::core::Core;
use crate::passes::capture::{Capture, CaptureDesc, FramesBy, pays_to_cull};
use crate::passes::gbuffer::Targets;
use crate::passes::pixel_light::PixelLight;
use crate::passes::shadow::{Lift, Shadow};
use crate::passes::surface_light::{Batch, SurfaceLight};
use crate::scene::Scene;
use crate::vk::gpu_types::{EmitterFace, LightSample};
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Image, Memory, Result, Sampler};
use std::sync::Arc;

/// Bytes of shadow tiles, depth and identity, that are held at once.
const SHADOW_BUDGET: u64 = 128 << 20;
/// Fewest points of a cell that a light is evaluated at, over all its samples.
const POINTS_IN_CELL: u32 = 8;
/// How far receivers stand off their surface, relative to the size of what is near.
const LIFT: f32 = 1e-6;

/// Passes for one set of lights.
pub struct DirectLight {
    set: LightSet,
    casters: Arc<Casters>,
    shadow: Capture,
    lights: Buffer,
    faces: Option<Buffer>,
    sampler: Sampler,
    surface: Option<SurfaceLight>,
    lift: Lift,
}

impl DirectLight {
    /// Builds the passes that `set` needs: `cells` says whether captures will read the surface cells, `pixels` whether views are lit.
    ///
    /// Pixels see the shadows of exact `casters` only.
    pub fn new(
        device: &Arc<Device>,
        set: LightSet,
        ground: &Ground<'_>,
        casters: &Arc<Casters>,
        (cells, pixels): (bool, bool),
    ) -> Result<Self> {
        let tile = u64::from(set.shadow_size).pow(2) * u64::from(set.views.count()) * 8;
        let capacity = (SHADOW_BUDGET / tile).clamp(1, set.samples.len() as u64) as u32;
        let from = casters.surface(ground);
        let desc = CaptureDesc {
            name: "shadow",
            views: set.views,
            size: set.shadow_size,
            capacity,
            keeps_depth: true,
            culled: pays_to_cull(device, from.geometry.triangle_count),
            frames: FramesBy::on(device),
        };
        let shadow = Capture::new(device, from.scene, from.geometry, from.textures, desc)?;
        let bytes = u64::from(shadow.desc.capacity) * size_of::<LightSample>() as u64;
        let lights = Buffer::new(device, "light samples", bytes, Memory::Device)?;
        // A batch holds no more faces than samples.
        let bytes = u64::from(shadow.desc.capacity) * size_of::<EmitterFace>() as u64;
        let has_faces = pixels && !set.cells_only && !set.faces.is_empty();
        let faces = has_faces.then(|| Buffer::new(device, "light samples", bytes, Memory::Device)).transpose()?;
        let sampler = Sampler::new(device, [ash::vk::SamplerAddressMode::CLAMP_TO_EDGE; 2], true)?;
        let Core { radius, .. } = ground.geometry.core;
        let lift = Lift { ball: ground.geometry.core.to_array(), share: LIFT.max(casters.lift() / radius) };
        let mut light = Self { set, casters: casters.clone(), shadow, lights, faces, sampler, surface: None, lift };
        let Ground { scene, geometry, textures } = *ground;
        let shadows = light.shadows(from.scene);
        let surface = cells.then(|| SurfaceLight::new(device, scene, geometry, textures, &shadows)).transpose()?;
        light.surface = surface;
        Ok(light)
    }

    /// The pass that lights the pixels of a view, whose visible surfaces are `gbuffer`, in `direct`, four floats a pixel. None where
    /// the set lights the surface cells alone.
    pub fn pixels(
        &self,
        device: &Arc<Device>,
        ground: &Ground<'_>,
        gbuffer: &Targets,
        direct: &Image,
    ) -> Result<Option<PixelLight>> {
        let shadows = self.shadows(self.casters.surface(ground).scene);
        let new = || PixelLight::new(device, gbuffer, &shadows, self.faces.as_ref(), direct);
        (!self.set.cells_only).then(new).transpose()
    }

    fn shadows(&self, casters: &Scene) -> Shadow<'_> {
        Shadow {
            kind: self.set.kind,
            capture: &self.shadow,
            lights: &self.lights,
            sampler: &self.sampler,
            triangles: &self.casters.triangles,
            opaque: casters.opaque_count(),
            own: self.casters.error == 0.0,
        }
    }

    /// Number of light samples.
    pub fn sample_count(&self) -> usize {
        self.set.samples.len()
    }

    /// Renders all batches of shadows and adds their light: to the surface cells if `cells` says so, and to the pixels of `pixel`.
    pub fn run(
        &self,
        recorder: &mut Recorder,
        ground: &Ground<'_>,
        (cells, pixel): (bool, Option<&PixelLight>),
        mut done: impl FnMut(usize),
    ) -> Result<()> {
        let surface = self.surface.as_ref().filter(|_| cells);
        if surface.is_none() && pixel.is_none() {
            done(self.set.samples.len());
            return Ok(());
        }
        let casters = self.casters.surface(ground);
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
                    self.shadow.record(c, casters.geometry, casters.textures, count);
                    Ok(())
                })?;
                if let Some(surface) = surface {
                    let batch = Batch { first: first as u32, count, points, lift: self.lift, stride: self.set.stride };
                    recording.pass("surface_light", |c| {
                        surface.record(c, ground.scene, ground.geometry, ground.textures, batch);
                        Ok(())
                    })?;
                }
                if let Some(pixel) = pixel {
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

//! A view: what is seen, the records over it, and the image.

use super::camera::View as Eyes;
use super::plan::{Part, Plan};
use super::surface::Surface;
use super::{Clock, OnProgress, Settings, output};
use crate::image::Picture;
use crate::methods::irradiance_cache::{CacheStats, Features, IrradianceCache};
use crate::methods::records::Records;
use crate::methods::{Ground, Sky};
use crate::passes::gbuffer::GBuffer;
use crate::passes::pixel_light::{PixelLight, direct_image};
use crate::passes::resolve::{Inputs, Plane, Resolve};
use crate::scene::Scene;
use crate::vk::pass::Recorder;
use crate::vk::{Device, Image, Result};
use glam::DVec3;
use std::sync::Arc;

/// Targets and passes of views by the same settings.
pub(super) struct View {
    pub(super) settings: Settings,
    gbuffer: GBuffer,
    direct: Option<Image>,
    /// One a light; none where it lights the surface alone.
    pub(super) pixel_lights: Vec<Option<PixelLight>>,
    cache: Option<IrradianceCache>,
    resolve: Resolve,
}

impl View {
    /// Builds what `plan` says.
    pub(super) fn new(
        device: &Arc<Device>,
        surface: &Surface,
        scene: &Scene,
        plan: &Plan,
        settings: &Settings,
        records: Option<&Records>,
    ) -> Result<Self> {
        let size = [settings.width, settings.height];
        let ground = surface.ground(scene);
        let emission = plan.runs(Part::Emission);
        let gbuffer = GBuffer::new(device, scene, ground.geometry, ground.textures, size, emission)?;
        let direct = plan.lights().then(|| direct_image(device, size)).transpose()?;
        let pixel_lights = match &direct {
            Some(direct) => {
                let new = |light: &crate::methods::direct::DirectLight| {
                    light.pixels(device, &ground, &gbuffer.targets, direct)
                };
                surface.lights.iter().map(new).collect::<Result<_>>()?
            }
            None => Vec::new(),
        };
        let cache = new_cache(device, surface, &ground, &gbuffer, (plan, settings), records)?;
        let resolve = new_resolve(device, surface, &gbuffer, direct.as_ref(), cache.as_ref(), settings)?;
        Ok(Self { settings: settings.clone(), gbuffer, direct, pixel_lights, cache, resolve })
    }

    /// Builds the cache anew, and what reads it.
    pub(super) fn build_cache(
        &mut self,
        device: &Arc<Device>,
        surface: &Surface,
        scene: &Scene,
        plan: &Plan,
        settings: &Settings,
        records: Option<&Records>,
    ) -> Result<()> {
        self.cache = None;
        self.cache = new_cache(device, surface, &surface.ground(scene), &self.gbuffer, (plan, settings), records)?;
        let (direct, cache) = (self.direct.as_ref(), self.cache.as_ref());
        self.resolve = new_resolve(device, surface, &self.gbuffer, direct, cache, settings)?;
        self.settings = settings.clone();
        Ok(())
    }

    /// Draws what is seen.
    pub(super) fn draw(&self, recorder: &mut Recorder, ground: &Ground<'_>, eyes: &Eyes) -> Result<()> {
        recorder.submit(|recording| {
            if let Some(direct) = &self.direct {
                recording.pass("clear", |c| {
                    c.clear_image(direct);
                    Ok(())
                })?;
            }
            recording.pass("gbuffer", |c| {
                let Ground { scene, geometry, textures } = *ground;
                self.gbuffer.record(c, scene, geometry, textures, eyes.world_to_clip, eyes.eye);
                Ok(())
            })
        })
    }

    /// Covers what is seen with `records`, and adds those that are missing.
    pub(super) fn run_cache(
        &self,
        recorder: &mut Recorder,
        ground: &Ground<'_>,
        eyes: &Eyes,
        records: Option<&mut Records>,
        (stop, on_progress): (&dyn Fn() -> bool, OnProgress<'_>),
    ) -> Result<CacheStats> {
        let Some((cache, records)) = self.cache.as_ref().zip(records) else { return Ok(CacheStats::default()) };
        let viewpoint = eyes.viewpoint(&self.settings.cache, ground.geometry);
        let progress = |_, share| on_progress("records", (share * 1000.0) as u64, 1000);
        cache.run(recorder, ground, (&self.gbuffer.targets, &viewpoint), records, (stop, progress))
    }

    /// Makes the image.
    pub(super) fn resolve(
        &self,
        recorder: &mut Recorder,
        eyes: &Eyes,
        clock: &mut Clock,
        origin: DVec3,
    ) -> Result<Picture> {
        let values = self.resolve.run(recorder, eyes.clip_to_world_direction, eyes.axis)?;
        clock.lap("run passes");
        let size = [self.settings.width, self.settings.height];
        let picture = output::picture(values, &self.settings.planes, size, origin);
        clock.lap("read result");
        Ok(picture)
    }
}

fn new_cache(
    device: &Arc<Device>,
    surface: &Surface,
    ground: &Ground<'_>,
    gbuffer: &GBuffer,
    (plan, settings): (&Plan, &Settings),
    records: Option<&Records>,
) -> Result<Option<IrradianceCache>> {
    let features = Features {
        sky: surface.sky.as_ref().map(Sky::captured),
        in_compute: plan.compute(),
        counts_records: settings.planes.contains(&Plane::Records),
        counts_work: settings.counts_work,
    };
    let new = |records| IrradianceCache::new(device, ground, &gbuffer.targets, records, features, settings.cache);
    records.map(new).transpose()
}

fn new_resolve(
    device: &Arc<Device>,
    surface: &Surface,
    gbuffer: &GBuffer,
    direct: Option<&Image>,
    cache: Option<&IrradianceCache>,
    settings: &Settings,
) -> Result<Resolve> {
    let inputs = Inputs {
        gbuffer: &gbuffer.targets,
        sums: cache.map(|cache| &cache.splat.sums),
        direct,
        sky: surface.sky.as_ref().map(Sky::seen),
    };
    Resolve::new(device, &inputs, &settings.planes)
}

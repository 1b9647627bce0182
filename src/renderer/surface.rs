//! The scene on the device: its surface, what it is made of, and what lights it.

use super::plan::{Part, Plan};
use super::{Clock, OnProgress, RenderError, Settings};
use crate::methods::casters::{Casters, CoarseSurface};
use crate::methods::direct::DirectLight;
use crate::methods::light_samples::light_sets;
use crate::methods::light_set::{Extent, LightSet};
use crate::methods::surface_cache::{self, Bounced, Looking, SurfaceCacheSettings};
use crate::methods::{Ground, Sky};
use crate::passes::geometry::{Arrangement, Geometry, SurfaceSize};
use crate::passes::material::Textures;
use crate::passes::pixel_light::PixelLight;
use crate::scene::Scene;
use crate::vk::pass::Recorder;
use crate::vk::{Device, Error as VulkanError};
use std::sync::Arc;

/// Texels a side of the captures of places: many see each cell, so that coarse ones do.
const PLACE_SIZE: u32 = 16;

/// What follows from the scene and its settings alone.
pub(super) struct Surface {
    pub(super) geometry: Geometry,
    pub(super) textures: Option<Textures>,
    pub(super) sky: Option<Sky>,
    pub(super) lights: Vec<DirectLight>,
    pub(super) size: SurfaceSize,
    /// Captures see the cells.
    is_captured: bool,
    /// Captures see light on the cells.
    has_cells: bool,
    /// The cells are lit, or cleared where no light is to be seen on them.
    is_lit: bool,
    /// What was done for light that goes on from cell to cell, once they are lit.
    pub(super) bounced: Option<Bounced>,
}

impl Surface {
    /// Uploads `scene`, arranged, and builds the passes that light its surface. The plan learns whether shadows are cast by a
    /// coarser surface.
    pub(super) fn new(
        device: &Arc<Device>,
        scene: &Scene,
        arrangement: Arrangement,
        plan: &mut Plan,
        settings: &Settings,
        clock: &mut Clock,
    ) -> Result<Self, RenderError> {
        let size = arrangement.size();
        let textures = Textures::new(device, scene)?;
        let geometry = Geometry::of(device, scene, arrangement)?;
        let sky = plan
            .runs(Part::Sky)
            .then(|| Sky::new(device, &scene.background, settings.cache.capture_size, true))
            .transpose()?;
        clock.lap("upload scene");
        let has_cells = plan.captures && settings.bounces > 0;
        let (is_captured, lights, bounced) = (plan.captures, Vec::new(), None);
        let mut surface =
            Self { geometry, textures, sky, lights, size, is_captured, has_cells, is_lit: false, bounced };
        let ground = surface.ground(scene);
        let coarse = plan.runs(Part::CoarseCasters).then(|| CoarseSurface::new(device, &ground)).transpose()?.flatten();
        if plan.runs(Part::CoarseCasters) && coarse.is_none() {
            *plan = plan.clone().of_own_casters();
        }
        let extent = Extent::of(ground.geometry);
        let sets = light_sets(scene, extent, &settings.lights, plan.runs(Part::Sky) && has_cells)?;
        surface.lights = build_lights(device, sets, &ground, coarse, (has_cells, plan.lights()))?;
        Ok(surface)
    }

    /// What every technique stands on.
    pub(super) fn ground<'a>(&'a self, scene: &'a Scene) -> Ground<'a> {
        Ground { scene, geometry: &self.geometry, textures: self.textures.as_ref() }
    }

    /// What was done otherwise than the file says, for the user.
    pub(super) fn note(&self) -> Option<String> {
        self.sky.as_ref()?.note.clone()
    }

    /// Adds the lights to a view by its passes, one a light, and to the surface unless that is lit.
    pub(super) fn light(
        &mut self,
        recorder: &mut Recorder,
        scene: &Scene,
        pixels: &[Option<PixelLight>],
        on_progress: OnProgress<'_>,
    ) -> Result<(), VulkanError> {
        let cells = self.has_cells && !self.is_lit;
        if self.is_captured && !self.is_lit {
            recorder.submit(|recording| {
                recording.pass("clear", |c| {
                    c.fill(&self.geometry.cell_radiance, 0);
                    Ok(())
                })
            })?;
        }
        let total = self.lights.iter().map(DirectLight::sample_count).sum::<usize>() as u64;
        let (ground, mut lit) = (self.ground(scene), 0);
        for (index, light) in self.lights.iter().enumerate() {
            let pixel = pixels.get(index).and_then(Option::as_ref);
            light.run(recorder, &ground, (cells, pixel), |samples| {
                lit += samples as u64;
                on_progress("direct light", lit, total);
            })?;
        }
        self.is_lit = true;
        Ok(())
    }

    /// Lets the light of the cells go on from one to another, as the plan says, unless that is done; a warning where it is not
    /// done as asked for.
    pub(super) fn bounce(
        &mut self,
        (device, recorder): (&Arc<Device>, &mut Recorder),
        scene: &Scene,
        plan: &Plan,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<Option<String>, VulkanError> {
        if self.bounced.is_some() || !plan.runs(Part::SurfaceCache) {
            return Ok(None);
        }
        let looking = Looking {
            size: PLACE_SIZE,
            in_compute: plan.compute(),
            lod_error: settings.cache.lod_error,
            shared: settings.cache.share_views,
        };
        let wanted = SurfaceCacheSettings {
            bounces: settings.cell_bounces(),
            tolerance: settings.bounce_tolerance,
            solver: settings.bounce_solver,
            places: settings.places,
            looking,
        };
        let mut hear = |done| on_progress("bounces", done, 3);
        let ground = self.ground(scene);
        let bounced = surface_cache::add_bounces(device, recorder, &ground, &wanted, &mut hear)?;
        let warning = bounced.warning();
        self.bounced = Some(bounced);
        Ok(warning)
    }
}

fn build_lights(
    device: &Arc<Device>,
    sets: Vec<LightSet>,
    ground: &Ground<'_>,
    coarse: Option<CoarseSurface>,
    (cells, pixels): (bool, bool),
) -> Result<Vec<DirectLight>, VulkanError> {
    let needed = |set: &LightSet| cells || !set.cells_only;
    let sets: Vec<_> = sets.into_iter().filter(needed).collect();
    let coarse = coarse.map(|coarse| Casters::coarse(device, coarse)).transpose()?.map(Arc::new);
    let is_exact = |set: &LightSet| coarse.is_none() || !set.cells_only;
    let exact = sets.iter().any(is_exact).then(|| Casters::exact(device, ground)).transpose()?.map(Arc::new);
    let new = |set: LightSet| {
        let casters = if is_exact(&set) { &exact } else { &coarse };
        casters.as_ref().map(|casters| DirectLight::new(device, set, ground, casters, (cells, pixels)))
    };
    sets.into_iter().filter_map(new).collect()
}

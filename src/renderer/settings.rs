//! What a frame is made with, and its checks.

use crate::math::capture::Projection;
use crate::math::density::Focus;
use crate::methods::captures::CaptureMode;
use crate::methods::irradiance_cache::CacheSettings;
use crate::methods::light_set::LightSettings;
use crate::methods::surface_cache::{ALL_BOUNCES, Solver};
use crate::passes::integrate::{Gradients, Radius};
use crate::passes::resolve::Plane;
use crate::passes::splat::Weight;
use crate::scene::{Scene, SideLimit};
use crate::vk::Device;

/// Longest side for hemispheres, whose projection bends sides. In the Cornell box half of it costs three times as much for
/// an eighth of the error.
const HEMISPHERE_SIDE: f32 = 0.06;
/// Shorter sides would make millions of triangles of an empty room.
const SHORTEST_SIDE: f32 = 0.002;
/// Most voxels along a side: single precision numbers as many.
const MOST_SLICES: u32 = 128;

/// Settings of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Reflections on the way: 0 direct light only, 1 one bounce of indirect light, [`ALL_BOUNCES`] as many as carry light.
    pub bounces: u32,
    /// Of all bounces, the share of the light that may be missing.
    pub bounce_tolerance: f32,
    /// How all bounces are summed.
    pub bounce_solver: Solver,
    /// Places on the surface that capture light beyond the first bounce, about. `None`: by the number of cells.
    pub places: Option<u32>,
    /// The irradiance cache.
    pub cache: CacheSettings,
    /// Direct light.
    pub lights: LightSettings,
    /// Cells that the surfaces are cut into, about; each triangle has at least one. `None`: by the scene's detail and
    /// the number of its lights.
    pub surface_cells: Option<u32>,
    /// Longest side of a triangle as a share of the scene's diagonal: longer ones are cut. `None`: as captures need it.
    pub tessellation: Option<f32>,
    /// Layers of the result.
    pub planes: Vec<Plane>,
    /// Builds and runs every part, needed or not: what leaving parts out is tested against.
    pub full_plan: bool,
    /// What the passes of the cache do is counted, for [`Rendered::cache`](super::Rendered::cache).
    pub counts_work: bool,
}

/// What views of one scene may differ in.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSettings {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The irradiance cache. How records look at the scene is settled when that is opened: other values of
    /// [`CacheSettings::captures`] have no effect.
    pub cache: CacheSettings,
    /// Layers of the result.
    pub planes: Vec<Plane>,
    /// What the passes of the cache do is counted.
    pub counts_work: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            bounces: 1,
            bounce_tolerance: 1e-3,
            bounce_solver: Solver::Accelerated,
            places: None,
            cache: CacheSettings {
                accuracy: 0.3,
                capture: CaptureMode::Auto,
                capture_size: 32,
                lod_error: 0.025,
                share_views: false,
                gradients: Gradients { rotation: true, translation: true },
                radius: Radius::Hessian,
                min_radius: 0.006,
                max_radius: 0.05,
                weight: Weight::Bounded,
                covered: 0.3,
                normal_limit: 0.2,
                hidden: true,
                clamped: true,
                contrast: 0.15,
                batch: None,
                seed: 0,
            },
            lights: LightSettings { area_samples: 64, sky_samples: 128, shadow_size: 256 },
            surface_cells: None,
            tessellation: None,
            planes: vec![Plane::Final],
            full_plan: false,
            counts_work: false,
        }
    }
}

/// A setting that makes no sense, or that the device cannot hold.
#[derive(Debug, thiserror::Error)]
#[error("{name} {found}: {rule}")]
pub struct SettingsError {
    name: &'static str,
    found: String,
    rule: String,
}

impl Settings {
    /// Reflections whose light surface cells receive before records look at them.
    pub(super) fn cell_bounces(&self) -> u32 {
        if self.bounces == ALL_BOUNCES { ALL_BOUNCES } else { self.bounces.saturating_sub(1) }
    }

    /// Those of a view.
    pub fn view(&self) -> ViewSettings {
        let Self { width, height, cache, planes, counts_work, .. } = self.clone();
        ViewSettings { width, height, cache, planes, counts_work }
    }

    /// The same scene's for another view.
    pub(super) fn with_view(&self, view: &ViewSettings) -> Self {
        let ViewSettings { width, height, cache, planes, counts_work } = view.clone();
        let CacheSettings { capture, capture_size, lod_error, share_views, .. } = self.cache;
        let cache = CacheSettings { capture, capture_size, lod_error, share_views, ..cache };
        Self { width, height, cache, planes, counts_work, ..self.clone() }
    }

    /// How long sides of triangles of `scene` may be: as captures and settings allow, and by their distance from the `foci`
    /// that surface cells are finer near, for a triangle's cells are all of one size. Without a device, captures are taken to be
    /// render passes.
    pub(super) fn side_limit(&self, scene: &Scene, foci: Vec<Focus>, device: Option<&Device>) -> SideLimit {
        let (low, high) = scene.bounds();
        let longest = self.longest_side(scene, device).map_or(f32::INFINITY, |share| (high - low).length() * share);
        SideLimit { longest, foci }
    }

    /// As a share of the scene's diagonal, where triangles are to be cut for captures or as settings say.
    fn longest_side(&self, scene: &Scene, device: Option<&Device>) -> Option<f32> {
        let is_disc = self.cache.capture.projection() == Projection::Hemisphere;
        let is_curved = is_disc && self.against_compute(scene, device).is_some();
        self.tessellation.or(is_curved.then_some(HEMISPHERE_SIDE))
    }

    /// Why captures of `scene` do not run in compute, if so. Who asks for compute whatever the scene's size is refused where the
    /// device does not hold it, by [`super::check_memory`].
    pub(super) fn against_compute(&self, scene: &Scene, device: Option<&Device>) -> Option<String> {
        let CacheSettings { capture, capture_size, .. } = self.cache;
        match device {
            None => Some("a CPU's captures, and no device is chosen yet".into()),
            Some(device) if capture.wants_compute() => capture.against_any_compute(device, scene, capture_size),
            Some(device) => capture.against_compute(device, scene, capture_size),
        }
    }

    /// Refuses what cannot be rendered, before anything is built.
    pub fn check(&self, device: &Device) -> Result<(), SettingsError> {
        let limits = &device.capabilities.limits;
        let side = limits.max_image_dimension2_d.min(limits.max_framebuffer_width).min(limits.max_framebuffer_height);
        range("--width", self.width, 1, side)?;
        range("--height", self.height, 1, side)?;
        if !(self.bounce_tolerance > 0.0 && self.bounce_tolerance < 1.0) {
            return Err(error("--bounce-tolerance", self.bounce_tolerance, "must be above 0 and below 1"));
        }
        range("--places", self.places.unwrap_or(1), 1, 1 << 20)?;
        range("--capture-size", self.cache.capture_size, 8, 256)?;
        if !self.cache.capture_size.is_multiple_of(2) {
            let rule = "must be even: the horizon lies between two rows of a hemicube's sides";
            return Err(error("--capture-size", self.cache.capture_size, rule));
        }
        if let CaptureMode::Plane { aperture, .. } = self.cache.capture
            && !(10.0..=170.0).contains(&aperture)
        {
            return Err(error("--aperture", aperture, "must be from 10 to 170 degrees: a plane has no more"));
        }
        if let CaptureMode::Slices { across, near } = self.cache.capture {
            range("--slices", across, 4, MOST_SLICES)?;
            if !(2.0..=1e3).contains(&near) {
                return Err(error("--slices-near", near, "must be from 2 voxels, for a record lies in one, to 1000"));
            }
        }
        range("--light-samples", self.lights.area_samples, 1, 1 << 16)?;
        range("--surface-cells", self.surface_cells.unwrap_or(1), 1, 1 << 26)?;
        if let Some(share) = self.tessellation
            && (share.is_nan() || share < SHORTEST_SIDE)
        {
            return Err(error("--tessellate", share, format!("must be {SHORTEST_SIDE} or more")));
        }
        positive("--accuracy", self.cache.accuracy, 10.0)?;
        if !(0.0..=16.0).contains(&self.cache.lod_error) {
            return Err(error(
                "--lod-error",
                self.cache.lod_error,
                "must be from 0 (all triangles are drawn) to 16 texels",
            ));
        }
        if !(0.0..=1e4).contains(&self.cache.contrast) {
            return Err(error("--contrast", self.cache.contrast, "must be from 0 (records may disagree) to 10000"));
        }
        positive("--normal-limit", self.cache.normal_limit, 10.0)?;
        range("--batch", self.cache.batch.unwrap_or(1), 1, u32::MAX)?;
        positive("--min-radius", self.cache.min_radius, 1e4)?;
        positive("--max-radius", self.cache.max_radius, 1e4)?;
        Ok(())
    }
}

fn range(name: &'static str, value: u32, low: u32, high: u32) -> Result<(), SettingsError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(error(name, value, format!("must be from {low} to {high}")))
    }
}

fn positive(name: &'static str, value: f32, high: f32) -> Result<(), SettingsError> {
    if value > 0.0 && value <= high {
        Ok(())
    } else {
        Err(error(name, value, format!("must be above 0, at most {high}")))
    }
}

fn error(name: &'static str, found: impl ToString, rule: impl Into<String>) -> SettingsError {
    SettingsError { name, found: found.to_string(), rule: rule.into() }
}

//! Lights as samples with a shadow view each: what [`super::direct`] renders, prepared on the CPU.
//!
//! A punctual light is one sample. Emissive triangles have samples of their own ([`super::emitter_samples`]), and so have small
//! bright regions of the sky. The rest of the sky is a set of parallel lights for the surface cells alone; pixels see it by
//! their records' captures.

use super::cascades::Cascades;
use super::emitter_samples::{EmitterSets, add_emitters};
use super::far_view::{FarViews, Seen};
use super::light_set::{Extent, LightSet, LightSettings, for_shell, frame, with};
use super::sky::{SKY_SHADOW_SIZE, add_sky, add_suns, sky_stride};
use crate::passes::shadow::LightKind::{Area, Directional, Point, Spot};
use crate::passes::views::Views::{Cube, Hemicube, Orthographic, Plane};
use crate::scene::{Light, Scene};
use crate::vk::gpu_types::LightSample;
use glam::Vec3;

/// Most punctual lights that are rendered: each costs shadow views and a lookup at every pixel and surface cell.
pub const MAX_LIGHTS: usize = 4096;

/// Of how many samples of emissive triangles a surface cell takes one.
const EMITTER_STRIDE: u32 = 2;

/// The scene has more lights than are rendered.
#[derive(Debug, thiserror::Error)]
#[error(
    "the scene has {found} punctual lights; at most {MAX_LIGHTS} are rendered, since each needs its own shadow views and a \
     lookup at every pixel ({found} lights would need {views} views): merge them, or make them emissive triangles, whose \
     number is not limited"
)]
pub struct TooManyLights {
    found: usize,
    views: usize,
}

/// Every light of `scene` as samples, the sky included where `sky` says so.
pub fn light_sets(
    scene: &Scene,
    extent: Extent,
    settings: &LightSettings,
    sky: bool,
) -> Result<Vec<LightSet>, TooManyLights> {
    if scene.lights.len() > MAX_LIGHTS {
        return Err(TooManyLights { found: scene.lights.len(), views: scene.lights.len() * 6 });
    }
    let count = |wanted: fn(&Light) -> bool| scene.lights.iter().filter(|l| wanted(l)).count();
    let size = |largest: u32, lights: usize| shrink(largest, lights).min(settings.shadow_size * 16);
    let directional = size(2048, count(|l| matches!(l, Light::Directional { .. })));
    let point = size(1024, count(|l| matches!(l, Light::Point { .. })));
    let spot = size(2048, count(|l| matches!(l, Light::Spot { .. })));
    let area = settings.shadow_size;
    let views = FarViews::of(scene, extent);
    let cascades = Cascades::of(extent);
    let mut sets = Sets {
        directional: LightSet::empty("directional lights", Directional, Orthographic, directional),
        point: LightSet::empty("point lights", Point, Cube, point),
        far_point: LightSet::empty("far point lights", Point, Plane, point),
        farthest_point: LightSet::empty("farthest point lights", Point, Orthographic, point),
        spot: LightSet::empty("spot lights", Spot, Plane, spot),
        wide_spot: LightSet::empty("wide spot lights", Spot, Cube, spot / 2),
        farthest_spot: LightSet::empty("farthest spot lights", Spot, Orthographic, spot),
    };
    for light in &scene.lights {
        add_punctual(light, extent, (&views, &cascades), &mut sets);
    }
    let mut emitters = EmitterSets {
        even: LightSet::empty("emissive triangles", Area, Hemicube, area),
        uneven: LightSet::empty("emissive textures", Area, Hemicube, area),
        far_even: LightSet::empty("far emissive triangles", Area, Plane, area),
        far_uneven: LightSet::empty("far emissive textures", Area, Plane, area),
    };
    add_emitters(scene, extent, &views, settings.area_samples, &mut emitters);
    let EmitterSets { even, uneven, far_even, far_uneven } = emitters;
    let mut suns = LightSet::empty("suns of the sky", Directional, Orthographic, size(1024, 1));
    add_suns(&scene.background, &cascades, settings.area_samples, &mut suns);
    let mut areas = vec![even, uneven, far_even, far_uneven, suns];
    areas.iter_mut().for_each(|set| set.stride = EMITTER_STRIDE.min(set.samples.len().max(1) as u32));
    let mut around = LightSet::empty("sky on surfaces", Directional, Orthographic, SKY_SHADOW_SIZE);
    if sky {
        around.cells_only = true;
        add_sky(&scene.background, &cascades, settings.sky_samples, &mut around);
        around.stride = sky_stride(around.samples.len() / cascades.count() as usize);
    }
    let Sets { directional, point, far_point, farthest_point, spot, wide_spot, farthest_spot } = sets;
    let mut all = vec![directional, point, far_point, farthest_point, spot, wide_spot, farthest_spot];
    all.append(&mut areas);
    all.push(around);
    all.retain(|set| !set.samples.is_empty());
    Ok(all)
}

/// Punctual lights by kind and by the views of their shadows.
struct Sets {
    directional: LightSet,
    point: LightSet,
    far_point: LightSet,
    farthest_point: LightSet,
    spot: LightSet,
    wide_spot: LightSet,
    farthest_spot: LightSet,
}

/// Halves the size of each shadow view as their number grows fourfold.
fn shrink(largest: u32, lights: usize) -> u32 {
    let halvings = (lights.max(1) as f32).log2() / 2.0;
    (largest >> halvings as u32).max(256)
}

fn add_punctual(light: &Light, extent: Extent, (views, cascades): (&FarViews, &Cascades), sets: &mut Sets) {
    match *light {
        Light::Directional { direction, irradiance } => {
            if irradiance != Vec3::ZERO {
                cascades.push(direction, irradiance, &mut sets.directional);
            }
        }
        Light::Point { position, intensity } => {
            let sample =
                LightSample { position: with(position, 0.0), power: with(intensity, 0.0), ..Default::default() };
            views.seen(&[position]).for_each(|seen| sets.add_point(sample, position, seen, extent));
        }
        Light::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            // 1 − cos by double precision: single precision cannot tell thin cones from none.
            let sample = LightSample {
                position: with(position, 0.0),
                direction: with(direction, (1.0 - cos_outer) as f32),
                power: with(intensity, (1.0 / (cos_inner - cos_outer).max(HARD_EDGE)) as f32),
                ..Default::default()
            };
            let cone = Cone { position, direction, cos_outer };
            views.seen(&[position]).for_each(|seen| sets.add_spot(sample, cone, seen, extent));
        }
    }
}

/// That of a spot.
#[derive(Clone, Copy)]
struct Cone {
    position: Vec3,
    direction: Vec3,
    cos_outer: f64,
}

impl Sets {
    fn add_point(&mut self, sample: LightSample, position: Vec3, seen: Seen<'_>, extent: Extent) {
        let (sample, near) = (for_shell(sample, seen), extent.near(position));
        match seen {
            Seen::Towards(receivers) if receivers.is_parallel(position) => {
                self.farthest_point.push(receivers.parallel_view(position, extent), sample);
            }
            Seen::Towards(receivers) => self.far_point.push(receivers.view(position, near), sample),
            Seen::Around(_) => {
                let scale = self.point.guard();
                self.point.push(frame(position, Vec3::Z, near, scale), sample);
            }
        }
    }

    fn add_spot(&mut self, sample: LightSample, cone: Cone, seen: Seen<'_>, extent: Extent) {
        let Cone { position, direction, cos_outer } = cone;
        let (sample, near) = (for_shell(sample, seen), extent.near(position));
        let tangent = (((1.0 - cos_outer) * (1.0 + cos_outer)).max(0.0).sqrt() / cos_outer.max(1e-3)) as f32;
        match seen {
            Seen::Towards(receivers) if receivers.is_parallel(position) => {
                self.farthest_spot.push(receivers.parallel_view(position, extent), sample);
            }
            Seen::Towards(receivers) if receivers.tangent(position) < tangent => {
                self.spot.push(receivers.view(position, near), sample);
            }
            _ if cos_outer < WIDE => {
                let scale = self.wide_spot.guard();
                self.wide_spot.push(frame(position, direction, near, scale), sample);
            }
            _ => {
                let scale = 1.0 / (tangent * 1.02).max(1e-6);
                self.spot.push(frame(position, direction, near, scale), sample);
            }
        }
    }
}

/// Least difference of the cosines of a spot's cones: less is a hard edge.
const HARD_EDGE: f64 = 1e-30;
/// A plane's aperture ends at 90°; from 75° on, whose cosine this is, its texels are stretched too far.
const WIDE: f64 = 0.26;

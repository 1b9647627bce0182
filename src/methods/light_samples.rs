//! Lights as samples with a shadow view each: what [`super::direct`] renders, prepared on the CPU.
//!
//! A punctual light is one sample. Emissive triangles have samples of their own ([`super::emitter_samples`]), and so have small
//! bright regions of the sky. The rest of the sky is a set of parallel lights for the surface cells alone; pixels see it by
//! their records' captures.

use super::cascades::Cascades;
use super::emitter_samples::{EmitterSets, add_emitters};
use super::far_view::Receivers;
use super::light_set::{Extent, LightSet, LightSettings, NEAR, frame, with};
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
    let receivers = Receivers::of(scene, extent);
    let cascades = Cascades::of(scene, extent);
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
        add_punctual(light, extent, (&receivers, &cascades), &mut sets);
    }
    let mut emitters = EmitterSets {
        even: LightSet::empty("emissive triangles", Area, Hemicube, area),
        uneven: LightSet::empty("emissive textures", Area, Hemicube, area),
        far_even: LightSet::empty("far emissive triangles", Area, Plane, area),
        far_uneven: LightSet::empty("far emissive textures", Area, Plane, area),
    };
    add_emitters(scene, extent, &receivers, settings.area_samples, &mut emitters);
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

fn add_punctual(light: &Light, extent: Extent, (receivers, cascades): (&Receivers, &Cascades), sets: &mut Sets) {
    let near = extent.radius * NEAR;
    match *light {
        Light::Directional { direction, irradiance } => {
            if irradiance != Vec3::ZERO {
                cascades.push(direction, irradiance, &mut sets.directional);
            }
        }
        Light::Point { position, intensity } => {
            let sample =
                LightSample { position: with(position, 0.0), power: with(intensity, 0.0), ..Default::default() };
            if receivers.is_parallel(position) {
                sets.farthest_point.push(receivers.parallel_view(position, extent), sample);
            } else if receivers.is_far(position) {
                sets.far_point.push(receivers.view(position, near), sample);
            } else {
                let scale = sets.point.guard();
                sets.point.push(frame(position, Vec3::Z, near, scale), sample);
            }
        }
        Light::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            // 1 − cos by double precision: single precision cannot tell thin cones from none.
            let sample = LightSample {
                position: with(position, 0.0),
                direction: with(direction, (1.0 - cos_outer) as f32),
                power: with(intensity, (1.0 / (cos_inner - cos_outer).max(HARD_EDGE)) as f32),
            };
            let tangent = (((1.0 - cos_outer) * (1.0 + cos_outer)).max(0.0).sqrt() / cos_outer.max(1e-3)) as f32;
            if receivers.is_parallel(position) {
                sets.farthest_spot.push(receivers.parallel_view(position, extent), sample);
            } else if receivers.is_far(position) && receivers.tangent(position) < tangent {
                sets.spot.push(receivers.view(position, near), sample);
            } else if cos_outer < WIDE {
                let scale = sets.wide_spot.guard();
                sets.wide_spot.push(frame(position, direction, near, scale), sample);
            } else {
                let scale = 1.0 / (tangent * 1.02).max(1e-6);
                sets.spot.push(frame(position, direction, near, scale), sample);
            }
        }
    }
}

/// Least difference of the cosines of a spot's cones: less is a hard edge.
const HARD_EDGE: f64 = 1e-30;
/// A plane's aperture ends at 90°; from 75° on, whose cosine this is, its texels are stretched too far.
const WIDE: f64 = 0.26;

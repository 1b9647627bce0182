//! Lights as samples with a shadow view each: what [`super::direct`] renders, prepared on the CPU.
//!
//! A punctual light is one sample. Emissive triangles have samples of their own ([`super::emitter_samples`]), and so have small
//! bright regions of the sky. The rest of the sky is a set of parallel lights for the surface cells alone; pixels see it by
//! their records' captures.

use super::emitter_samples::add_emitters;
use super::light_set::{Extent, LightSet, LightSettings, NEAR, frame, parallel_frame, parallel_sample, with};
use super::sky::{SKY_SHADOW_SIZE, add_sky, add_suns, sky_stride};
use crate::passes::shadow::LightKind;
use crate::passes::views::Views;
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
    let mut sets = vec![
        LightSet::empty("directional lights", LightKind::Directional, Views::Orthographic, directional),
        LightSet::empty("point lights", LightKind::Point, Views::Cube, point),
        LightSet::empty("spot lights", LightKind::Spot, Views::Plane, spot),
        LightSet::empty("wide spot lights", LightKind::Spot, Views::Cube, spot / 2),
        LightSet::empty("emissive triangles", LightKind::Area, Views::Hemicube, settings.shadow_size),
        LightSet::empty("sky on surfaces", LightKind::Directional, Views::Orthographic, SKY_SHADOW_SIZE),
        LightSet::empty("suns of the sky", LightKind::Directional, Views::Orthographic, size(1024, 1)),
    ];
    for light in &scene.lights {
        add_punctual(light, extent, &mut sets);
    }
    add_emitters(scene, extent, settings.area_samples, &mut sets[4]);
    sets[4].stride = EMITTER_STRIDE.min(sets[4].samples.len().max(1) as u32);
    add_suns(&scene.background, extent, settings.area_samples, &mut sets[6]);
    sets[6].stride = EMITTER_STRIDE.min(sets[6].samples.len().max(1) as u32);
    if sky {
        sets[5].cells_only = true;
        add_sky(&scene.background, extent, settings.sky_samples, &mut sets[5]);
        sets[5].stride = sky_stride(sets[5].samples.len());
    }
    sets.retain(|set| !set.samples.is_empty());
    Ok(sets)
}

/// Halves the size of each shadow view as their number grows fourfold.
fn shrink(largest: u32, lights: usize) -> u32 {
    let halvings = (lights.max(1) as f32).log2() / 2.0;
    (largest >> halvings as u32).max(256)
}

fn add_punctual(light: &Light, extent: Extent, sets: &mut [LightSet]) {
    let near = extent.radius * NEAR;
    match *light {
        Light::Directional { direction, irradiance } => {
            if irradiance != Vec3::ZERO {
                sets[0].push(parallel_frame(direction, extent), parallel_sample(direction, irradiance));
            }
        }
        Light::Point { position, intensity } => {
            let sample =
                LightSample { position: with(position, 0.0), power: with(intensity, 0.0), ..Default::default() };
            let scale = sets[1].guard();
            sets[1].push(frame(position, Vec3::Z, near, scale), sample);
        }
        Light::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            let sample = LightSample {
                position: with(position, 0.0),
                direction: with(direction, cos_outer),
                power: with(intensity, 1.0 / (cos_inner - cos_outer).max(1e-4)),
            };
            // A plane's aperture ends at 90°; from 75° on its texels are stretched too far.
            let wide = cos_outer < 0.26;
            let tangent = (1.0 - cos_outer * cos_outer).max(0.0).sqrt() / cos_outer.max(1e-3);
            let scale = if wide { sets[3].guard() } else { 1.0 / (tangent * 1.02).max(1e-3) };
            sets[if wide { 3 } else { 2 }].push(frame(position, direction, near, scale), sample);
        }
    }
}

//! Lights as samples with a shadow view each: what [`super::direct`] renders, prepared on the CPU.
//!
//! A punctual light is one sample. Emissive triangles have samples of their own ([`super::emitter_samples`]). The sky, for
//! the surface cells alone, is a set of parallel lights; pixels see it by their records' captures.

use super::emitter_samples::{Face, add_emitters};
use crate::math::sequence::fibonacci_sphere;
use crate::passes::capture::Views;
use crate::scene::{Background, EnvironmentMap, Light, Scene};
use crate::vk::gpu_types::{Frame, LightSample};
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// Most punctual lights that are rendered: each costs shadow views and a lookup at every pixel and surface cell.
pub const MAX_LIGHTS: usize = 4096;

/// Texels a side of a shadow view of the sky.
pub const SKY_SHADOW_SIZE: u32 = 512;
/// Samples of the sky that a surface cell needs.
const SAMPLES_OF_CELL: u32 = 32;

/// Of how many samples of the sky a surface cell takes one, others than its neighbours do: captures see the mean of many.
fn sky_stride(samples: usize) -> u32 {
    (samples as u32 / SAMPLES_OF_CELL).max(1)
}

/// Kinds of light samples (`glsl/shared/types.glsl`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// Radiant intensity from a point.
    Point,
    /// The same within a cone.
    Spot,
    /// A piece of an emissive triangle.
    Area,
}

impl LightKind {
    /// Value of the shaders' `LIGHT_KIND`.
    pub fn code(self) -> u32 {
        match self {
            Self::Directional => 0,
            Self::Point => 1,
            Self::Spot => 2,
            Self::Area => 3,
        }
    }
}

/// Samples that share a kind, a kind of shadow view and a shadow size.
#[derive(Clone, Debug)]
pub struct LightSet {
    /// What is sampled, in words.
    pub name: &'static str,
    /// Kind of all samples.
    pub kind: LightKind,
    /// Views of their shadows.
    pub views: Views,
    /// Texels a side of a shadow view.
    pub shadow_size: u32,
    /// Where each sample looks from.
    pub frames: Vec<Frame>,
    /// The samples.
    pub samples: Vec<LightSample>,
    /// Emissive triangles whose samples these are, one after the other; empty where samples stand for several triangles.
    pub faces: Vec<Face>,
    /// Lights the surface cells only.
    pub cells_only: bool,
    /// Of how many samples a surface cell takes one.
    pub stride: u32,
}

/// How finely lights are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSettings {
    /// Samples of all emissive triangles together; more where each triangle needs one of its own.
    pub area_samples: u32,
    /// Parallel lights that stand for the sky on the surface cells.
    pub sky_samples: u32,
    /// Texels a side of the shadow view of an area sample; punctual lights have larger ones in proportion.
    pub shadow_size: u32,
}

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

/// Extent of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Lowest and highest corner of the bounding box.
    pub bounds: [Vec3; 2],
    /// Half its diagonal.
    pub radius: f32,
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
    ];
    for light in &scene.lights {
        add_punctual(light, extent, &mut sets);
    }
    add_emitters(scene, extent, settings.area_samples, &mut sets[4]);
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

impl LightSet {
    fn empty(name: &'static str, kind: LightKind, views: Views, shadow_size: u32) -> Self {
        Self {
            name,
            kind,
            views,
            shadow_size,
            frames: vec![],
            samples: vec![],
            faces: vec![],
            cells_only: false,
            stride: 1,
        }
    }

    /// Scale that leaves two texels around each face of a cube, so that what lies beyond its edge is seen from both sides.
    pub(super) fn guard(&self) -> f32 {
        1.0 - 4.0 / self.shadow_size as f32
    }

    pub(super) fn push(&mut self, frame: Frame, sample: LightSample) {
        self.frames.push(frame);
        self.samples.push(sample);
    }
}

/// Relative to the scene's size: nearer than this nothing casts a shadow.
pub(super) const NEAR: f32 = 1.0 / 65536.0;

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

fn parallel_sample(direction: Vec3, irradiance: Vec3) -> LightSample {
    LightSample { direction: with(direction, 0.0), power: with(irradiance, 0.0), ..Default::default() }
}

/// A view along `direction` that holds the whole bounding box.
fn parallel_frame(direction: Vec3, extent: Extent) -> Frame {
    let (tangent, bitangent) = direction.any_orthonormal_pair();
    // any_orthonormal_pair gives (a, b) with a × b = direction up to sign; the views need t × b = n.
    let bitangent = if tangent.cross(bitangent).dot(direction) > 0.0 { bitangent } else { -bitangent };
    let [low, high] = extent.bounds;
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let reach = |axis: Vec3| (axis.abs().dot(half) * 1.001).max(extent.radius * 1e-4);
    let origin = centre - direction * reach(direction);
    Frame {
        origin: with(origin, 0.0),
        tangent: with(tangent, 1.0 / reach(tangent)),
        bitangent: with(bitangent, 1.0 / reach(bitangent)),
        normal: with(direction, 0.5 / reach(direction)),
        horizon: [0.0, 0.0, 0.0, 1.0],
    }
}

pub(super) fn frame(origin: Vec3, axis: Vec3, near: f32, scale: f32) -> Frame {
    let tangent = axis.any_orthonormal_vector();
    Frame {
        origin: with(origin, near),
        tangent: with(tangent, scale),
        bitangent: with(axis.cross(tangent), scale),
        normal: with(axis, 1.0),
        horizon: [0.0, 0.0, 0.0, 1.0],
    }
}

pub(super) fn with(v: Vec3, w: f32) -> [f32; 4] {
    Vec4::from((v, w)).to_array()
}

pub(super) fn brightness(v: Vec3) -> f32 {
    v.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn add_sky(background: &Background, extent: Extent, count: u32, set: &mut LightSet) {
    match background {
        Background::Black => {}
        Background::Constant(radiance) => {
            for index in 0..count {
                let direction = fibonacci_sphere(index, count);
                let irradiance = *radiance * (4.0 * PI / count as f32);
                set.push(parallel_frame(direction, extent), parallel_sample(direction, irradiance));
            }
        }
        Background::Map(map) => add_sky_map(map, extent, count, set),
    }
}

/// Steps through the map's cumulated power: as many parallel lights, each of the same power.
fn add_sky_map(map: &EnvironmentMap, extent: Extent, count: u32, set: &mut LightSet) {
    let solid_angle = |row: u32| {
        let (top, bottom) = (f64::from(row) / f64::from(map.height), f64::from(row + 1) / f64::from(map.height));
        let pi = std::f64::consts::PI;
        ((top * pi).cos() - (bottom * pi).cos()) * 2.0 * pi / f64::from(map.width)
    };
    let power =
        |index: usize| f64::from(brightness(Vec3::from(map.rgb[index]))) * solid_angle(index as u32 / map.width);
    let total: f64 = (0..map.rgb.len()).map(power).sum();
    if total <= 0.0 {
        return;
    }
    let (mut texel, mut passed) = (0, 0.0);
    for index in 0..count {
        let target = (f64::from(index) + 0.5) / f64::from(count) * total;
        while texel + 1 < map.rgb.len() && passed + power(texel) <= target {
            passed += power(texel);
            texel += 1;
        }
        let (x, y) = (texel as u32 % map.width, texel as u32 / map.width);
        let uv = [(x as f32 + 0.5) / map.width as f32, (y as f32 + 0.5) / map.height as f32];
        let direction = -EnvironmentMap::uv_to_direction(uv);
        let weight = total / f64::from(count) / power(texel) * solid_angle(y);
        let irradiance = Vec3::from(map.rgb[texel]) * weight as f32;
        set.push(parallel_frame(direction, extent), parallel_sample(direction, irradiance));
    }
}

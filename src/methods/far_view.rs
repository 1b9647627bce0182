//! Views from lights that are far from what they light: narrow enough that what they light fills the shadow map.

use super::light_set::{Extent, frame, parallel_view, with};
use crate::math::core::Core;
use crate::scene::Scene;
use crate::vk::gpu_types::Frame;
use glam::{Vec3, Vec4Swizzles};

/// Radii of the receivers' sphere from which on a light is far.
const FAR: f32 = 2.0;
/// The same, for light that is as good as parallel where its shadows fall.
const PARALLEL: f32 = 1000.0;

/// Radius about a scene's core that has views of its own, in radii of the core.
pub(super) const MARGIN: f32 = 2.0;

/// Everywhere: see [`LightSample::shell`](crate::vk::gpu_types::LightSample::shell).
const NO_SHELL: [f32; 2] = [0.0; 2];

/// A sphere about all surfaces that reflect, or about the scene's core.
#[derive(Clone, Copy, Debug)]
pub struct Receivers {
    centre: Vec3,
    radius: f32,
    /// Radii of the shell about the core that views of them are for.
    pub shell: [f32; 2],
}

/// How the shadows of a light are looked at, and for which shell about the core.
#[derive(Clone, Copy, Debug)]
pub enum Seen<'a> {
    /// In all directions.
    Around([f32; 2]),
    /// Towards receivers that it is far from.
    Towards(&'a Receivers),
}

/// What lights may be far from.
#[derive(Clone, Copy, Debug)]
pub struct FarViews {
    all: Receivers,
    core: Option<Receivers>,
}

impl FarViews {
    /// Of `scene`.
    pub fn of(scene: &Scene, extent: Extent) -> Self {
        let Core { centre, radius, is_apart } = extent.core;
        let radius = MARGIN * radius;
        let core = is_apart.then_some(Receivers { centre, radius, shell: [0.0, radius] });
        Self { all: Receivers::of(scene, extent), core }
    }

    /// How the shadows of a light with these corners are looked at: all of them, or what is in the core and what is not.
    pub fn seen(&self, corners: &[Vec3]) -> impl Iterator<Item = Seen<'_>> {
        let is_far = |from: &&Receivers| corners.iter().all(|corner| from.is_far(*corner));
        let (all, core) = (Some(&self.all).filter(is_far), self.core.as_ref().filter(is_far));
        let towards = all.or(core);
        let around = match (all, core) {
            (Some(_), _) => None,
            (None, Some(core)) => Some(Seen::Around([core.radius, 0.0])),
            (None, None) => Some(Seen::Around(NO_SHELL)),
        };
        around.into_iter().chain(towards.map(Seen::Towards))
    }
}

impl Receivers {
    /// Of `scene`, or of all of it where nothing reflects.
    fn of(scene: &Scene, extent: Extent) -> Self {
        let reflects = |part: &&crate::scene::Part| {
            !scene.emits(part) || scene.materials[part.material as usize].base_color.xyz() != Vec3::ZERO
        };
        let triangles = scene.parts.iter().filter(reflects).flat_map(|part| scene.triangles_of(part)).flatten();
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let grown = |(low, high): (Vec3, Vec3), v: &u32| {
            let p = scene.positions[*v as usize];
            (low.min(p), high.max(p))
        };
        let (low, high) = triangles.fold(empty, grown);
        let [low, high] = if low.x <= high.x { [low, high] } else { extent.bounds };
        Self {
            centre: (low + high) * 0.5,
            radius: (0.5 * (high - low).length()).max(f32::MIN_POSITIVE),
            shell: NO_SHELL,
        }
    }

    /// Whether a light at `position` is far from all of them.
    fn is_far(&self, position: Vec3) -> bool {
        position.distance(self.centre) > FAR * self.radius
    }

    /// Whether its light is as good as parallel.
    pub fn is_parallel(&self, position: Vec3) -> bool {
        position.distance(self.centre) > PARALLEL * self.radius
    }

    /// Tangent of the half angle of the cone about them, seen from a far position.
    pub fn tangent(&self, position: Vec3) -> f32 {
        let distance = position.distance(self.centre);
        self.radius / (distance * distance - self.radius * self.radius).sqrt()
    }

    /// A perspective view of them; how much of its depth they take goes with it.
    pub fn view(&self, position: Vec3, near: f32) -> Frame {
        let distance = position.distance(self.centre);
        let axis = (self.centre - position) / distance;
        let view = frame(position, axis, near, 1.0 / (1.02 * self.tangent(position)));
        Frame { normal: with(axis, (2.0 * self.radius / distance).min(1.0)), ..view }
    }

    /// A parallel view of them, deep enough for all that stands in between.
    pub fn parallel_view(&self, position: Vec3, extent: Extent) -> Frame {
        let axis = (self.centre - position).normalize();
        parallel_view(axis, extent, self.centre, self.radius)
    }
}

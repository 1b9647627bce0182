//! Views from lights that are far from what they light: narrow enough that what they light fills the shadow map.

use super::light_set::{Extent, frame, parallel_frame, with};
use crate::scene::Scene;
use crate::vk::gpu_types::Frame;
use glam::{Vec3, Vec4Swizzles};

/// Radii of the receivers' sphere from which on a light is far.
const FAR: f32 = 2.0;
/// The same, for light that is as good as parallel where its shadows fall.
const PARALLEL: f32 = 1000.0;

/// A sphere about all surfaces that reflect.
#[derive(Clone, Copy, Debug)]
pub struct Receivers {
    centre: Vec3,
    radius: f32,
}

impl Receivers {
    /// Of `scene`, or of all of it where nothing reflects.
    pub fn of(scene: &Scene, extent: Extent) -> Self {
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
        Self { centre: (low + high) * 0.5, radius: (0.5 * (high - low).length()).max(f32::MIN_POSITIVE) }
    }

    /// Whether a light at `position` is far from all of them.
    pub fn is_far(&self, position: Vec3) -> bool {
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
        let view = parallel_frame(axis, extent);
        let origin = Vec3::from_slice(&view.origin[..3]);
        let aside = (self.centre - origin) - axis * axis.dot(self.centre - origin);
        let scale = 1.0 / (1.02 * self.radius);
        let [tangent, bitangent] = [view.tangent, view.bitangent].map(|[x, y, z, _]| [x, y, z, scale]);
        Frame { origin: with(origin + aside, 0.0), tangent, bitangent, ..view }
    }
}

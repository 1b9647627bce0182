//! A scene made ready for rays: what is seen along a ray, whether two points see each other.

use super::bvh::{Bvh, Hit};
use super::lights::Emitters;
use super::sky::Sky;
use super::surface::{Plane, SurfacePoint, evaluate, single};
use crate::scene::Scene;
use glam::DVec3;
use std::sync::atomic::{AtomicU64, Ordering};

/// A scene with everything that light transport asks of it.
pub struct Tracer<'a> {
    /// The scene itself.
    pub scene: &'a Scene,
    pub(super) sky: Sky<'a>,
    pub(super) emitters: Emitters,
    bvh: Bvh,
    /// One entry a triangle.
    planes: Vec<Plane>,
    /// One entry a triangle: alpha decides, point by point, whether the surface is there.
    masked: Vec<bool>,
    rays: AtomicU64,
    /// Emitters reflect too, which scenes' emitters never do: only for closed forms that need it.
    #[cfg(test)]
    pub(super) emitters_reflect: bool,
}

impl<'a> Tracer<'a> {
    /// Builds the hierarchy and the tables of lights.
    pub fn new(scene: &'a Scene) -> Self {
        let mut masked = vec![false; scene.triangles.len()];
        for part in &scene.parts {
            let first = part.first_triangle as usize;
            masked[first..first + part.triangle_count as usize].fill(scene.is_masked(part));
        }
        Self {
            scene,
            sky: Sky::new(&scene.background),
            emitters: Emitters::new(scene),
            bvh: Bvh::new(&scene.positions, &scene.triangles),
            planes: (0..scene.triangles.len() as u32).map(|t| Plane::new(scene, t)).collect(),
            masked,
            rays: AtomicU64::new(0),
            #[cfg(test)]
            emitters_reflect: false,
        }
    }

    /// Nearest surface along a ray. `direction` is a unit vector.
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.bvh.nearest(origin, direction, f64::INFINITY, |t, at| self.solid(t, at))
    }

    /// The surface where a ray of the given direction hits.
    pub fn surface(&self, hit: &Hit, direction: DVec3) -> SurfacePoint {
        #[allow(unused_mut)]
        let mut surface = evaluate(self.scene, &self.planes[hit.triangle as usize], hit, direction);
        #[cfg(test)]
        if self.emitters_reflect {
            let material = self.scene.material_of(hit.triangle) as usize;
            surface.albedo = self.scene.materials[material].base_color.truncate().as_dvec3();
        }
        surface
    }

    /// Whether nothing stands within `distance` of `origin` in the unit direction `direction`.
    pub fn free(&self, origin: DVec3, direction: DVec3, distance: f64) -> bool {
        !self.bvh.occluded(origin, direction, distance, |t, at| self.solid(t, at))
    }

    /// Whether nothing stands between a lifted surface point and a point on the triangle of an emitter.
    pub fn sees(&self, origin: DVec3, target: DVec3) -> bool {
        // Ends just before the emitter, which would occlude itself.
        const SHORTEN: f64 = 1.0 - 1e-9;
        let offset = target - origin;
        let distance = offset.length();
        self.free(origin, offset / distance, distance * SHORTEN)
    }

    /// Adds to the count of rays traced. Callers count for themselves and tell now and then: threads share this number.
    pub fn count_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// Rays counted so far.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    #[inline]
    fn solid(&self, triangle: u32, barycentric: (f64, f64)) -> bool {
        !self.masked[triangle as usize] || self.scene.is_present(triangle, single(barycentric))
    }
}

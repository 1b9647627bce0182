//! Rays against all triangles: a wide bounding volume hierarchy (obvhs) over watertight triangle tests.

use super::intersect::ShearedRay;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// The hierarchy lives in a world scaled by a power of two so that coordinates reach about 2²⁰. The traversal's own
/// absolute tolerance (1e-4) is negligible there, and a scene scaled by a power of two takes the same decisions, bit by
/// bit.
const CANONICAL_EXPONENT: i32 = 20;
/// Margin of the boxes in canonical units: more than what the single-precision box test can be off by.
const BOX_MARGIN: f32 = 1.0;

/// Triangles ready for rays.
pub struct Bvh {
    tree: CwBvh,
    /// Corners in canonical scale, in the tree's order of primitives.
    corners: Vec<[Vec3; 3]>,
    /// Index into the scene's triangles, in the tree's order.
    index: Vec<u32>,
    to_canonical: f64,
    bounds: (DVec3, DVec3),
}

/// The nearest hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Index into the scene's triangles.
    pub triangle: u32,
    /// Distance along the ray in scene units per unit of direction.
    pub t: f64,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: (f64, f64),
}

impl Bvh {
    /// Builds over triangles with finite corners.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let reach = positions.iter().fold(0f32, |m, p| m.max(p.abs().max_element()));
        let exponent = if reach > 0.0 { CANONICAL_EXPONENT - exponent_of(reach) } else { 0 };
        let to_canonical = 2f64.powi(exponent);
        let scaled = |i: u32| (positions[i as usize].as_dvec3() * to_canonical).as_vec3();
        let corners: Vec<_> = triangles.iter().map(|t| t.map(scaled)).collect();
        let boxes: Vec<_> = corners.iter().map(padded_box).collect();
        if boxes.is_empty() {
            return Self { tree: CwBvh::default(), corners, index: vec![], to_canonical, bounds: Default::default() };
        }
        let tree = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let total = boxes.iter().fold(Aabb::empty(), |sum, b| sum.union(&b.aabb()));
        Self {
            corners: tree.primitive_indices.iter().map(|&i| corners[i as usize]).collect(),
            index: tree.primitive_indices.clone(),
            to_canonical,
            bounds: (Vec3::from(total.min).as_dvec3(), Vec3::from(total.max).as_dvec3()),
            tree,
        }
    }

    /// Nearest hit with `0 < t < t_max` that `solid(triangle, barycentric)` accepts.
    pub fn nearest(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_max: f64,
        solid: impl Fn(u32, (f64, f64)) -> bool,
    ) -> Option<Hit> {
        let (start, ray) = self.enter(origin, direction, t_max)?;
        let sheared = ShearedRay::new(origin * self.to_canonical, direction);
        let mut best = t_max * self.to_canonical;
        let mut found = None;
        self.tree.ray_traverse(ray, &mut RayHit::none(), |_, i| {
            let Some(hit) = sheared.meet(&self.corners[i]) else { return f32::INFINITY };
            if hit.t <= 0.0 || hit.t >= best || !solid(self.index[i], hit.barycentric) {
                return f32::INFINITY;
            }
            best = hit.t;
            found = Some(Hit { triangle: self.index[i], t: hit.t / self.to_canonical, barycentric: hit.barycentric });
            box_limit(best - start)
        });
        found
    }

    /// Whether something that `solid` accepts lies at `0 < t < t_max`.
    pub fn occluded(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_max: f64,
        solid: impl Fn(u32, (f64, f64)) -> bool,
    ) -> bool {
        let Some((_, ray)) = self.enter(origin, direction, t_max) else { return false };
        let sheared = ShearedRay::new(origin * self.to_canonical, direction);
        let limit = t_max * self.to_canonical;
        !self.tree.ray_traverse_miss(ray, |_, i| match sheared.meet(&self.corners[i]) {
            Some(hit) if hit.t > 0.0 && hit.t < limit && solid(self.index[i], hit.barycentric) => -1.0,
            _ => f32::INFINITY,
        })
    }

    /// The ray for the box tests, in canonical scale, and how far along it starts: where it enters the scene's bounds, so
    /// that single precision holds for origins far outside.
    fn enter(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, Ray)> {
        if self.corners.is_empty() {
            return None;
        }
        let origin = origin * self.to_canonical;
        let (low, high) = ((self.bounds.0 - origin) / direction, (self.bounds.1 - origin) / direction);
        // A direction component of 0 gives ±∞ or, on the face itself, NaN, which min and max drop.
        let enter = low.min(high).to_array().into_iter().fold(0.0, f64::max);
        let exit = low.max(high).to_array().into_iter().fold(t_max * self.to_canonical, f64::min);
        if enter > exit {
            return None;
        }
        let at: Vec3A = (origin + direction * enter).as_vec3a();
        Some((enter, Ray::new(at, direction.as_vec3a(), 0.0, box_limit(exit - enter))))
    }
}

/// An upper bound for box tests: single precision may round down, and boxes are only as exact as their margin.
fn box_limit(t: f64) -> f32 {
    (t * (1.0 + 1e-6)) as f32 + 2.0 * BOX_MARGIN
}

fn padded_box(corners: &[Vec3; 3]) -> Aabb {
    let points = corners.map(Vec3A::from);
    let bounds = Aabb::from_points(&points);
    Aabb::new(bounds.min - BOX_MARGIN, bounds.max + BOX_MARGIN)
}

/// Floor of the binary logarithm of a positive normal number.
fn exponent_of(x: f32) -> i32 {
    (x.max(f32::MIN_POSITIVE).to_bits() >> 23) as i32 - 127
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::{cosine_hemisphere, uniform_sphere};
    use glam::vec3;

    /// A closed tessellated box with corners that single precision must round.
    fn lumpy_box(n: u32, scale: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (vec![], vec![]);
        for face in 0..6 {
            let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
            for i in 0..n {
                for j in 0..n {
                    let base = positions.len() as u32;
                    for (di, dj) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                        let at = |k: u32| 2.0 * k as f32 / n as f32 - 1.0;
                        let mut p = [0.0; 3];
                        p[axis] = sign;
                        p[(axis + 1) % 3] = at(i + di);
                        p[(axis + 2) % 3] = at(j + dj);
                        let p = Vec3::from(p);
                        positions.push(p.normalize() * (1.0 + 0.1 * (7.0 * p.x + 5.0 * p.y * p.z).sin()) * scale);
                    }
                    triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
                }
            }
        }
        (positions, triangles)
    }

    #[test]
    fn no_ray_leaves_a_closed_mesh() {
        let (positions, triangles) = lumpy_box(12, 3.7);
        let bvh = Bvh::new(&positions, &triangles);
        for i in 0..200_000u32 {
            let [u, v, _, _] = sobol_burley::sample_4d(i % 65536, 0, i / 65536);
            let origin = DVec3::new(0.1, -0.2, 0.3);
            let hit = bvh.nearest(origin, uniform_sphere(u.into(), v.into()), f64::INFINITY, |_, _| true);
            assert!(hit.is_some(), "ray {i} leaves");
        }
        // Aimed at vertices and edge centres, where cracks would be.
        for t in &triangles {
            let [a, b, _] = t.map(|i| positions[i as usize].as_dvec3());
            for target in [a, (a + b) * 0.5, a.lerp(b, 0.3)] {
                assert!(bvh.nearest(DVec3::ZERO, target.normalize(), f64::INFINITY, |_, _| true).is_some());
            }
        }
    }

    #[test]
    fn agrees_with_brute_force_near_and_far() {
        let (positions, triangles) = lumpy_box(6, 1.0);
        let bvh = Bvh::new(&positions, &triangles);
        for i in 0..3000 {
            let [u, v, x, y] = sobol_burley::sample_4d(i, 0, 1);
            let far = if i % 2 == 0 { 3.0 } else { 1e5 };
            let origin = uniform_sphere(u.into(), v.into()) * far;
            let target = cosine_hemisphere(x.into(), y.into()) * 1.2;
            let direction = (target - origin).normalize();
            let ray = ShearedRay::new(origin, direction);
            let all = triangles.iter().filter_map(|t| ray.meet(&t.map(|i| positions[i as usize])));
            let expected = all.map(|h| h.t).filter(|&t| t > 0.0).fold(f64::INFINITY, f64::min);
            let hit = bvh.nearest(origin, direction, f64::INFINITY, |_, _| true);
            let t = hit.map_or(f64::INFINITY, |h| h.t);
            assert!(t == expected || (t - expected).abs() < 1e-9 * expected, "{t} {expected}");
            assert_eq!(bvh.occluded(origin, direction, far + 2.0, |_, _| true), hit.is_some());
        }
    }

    #[test]
    fn scale_by_a_power_of_two_changes_nothing() {
        let (positions, triangles) = lumpy_box(6, 1.0);
        let hits = |scale: f32| {
            let scaled: Vec<_> = positions.iter().map(|&p| p * scale).collect();
            let bvh = Bvh::new(&scaled, &triangles);
            let trace = |i| {
                let [u, v, _, _] = sobol_burley::sample_4d(i, 0, 2);
                let origin = vec3(0.3, 0.1, 0.2).as_dvec3() * f64::from(scale);
                let hit = bvh.nearest(origin, uniform_sphere(u.into(), v.into()), f64::INFINITY, |_, _| true);
                hit.map(|h| (h.triangle, h.t / f64::from(scale), h.barycentric))
            };
            (0..500).map(trace).collect::<Vec<_>>()
        };
        let unit = hits(1.0);
        assert!(unit.iter().all(Option::is_some));
        assert!(hits(2f32.powi(-20)) == unit && hits(2f32.powi(20)) == unit);
    }
}

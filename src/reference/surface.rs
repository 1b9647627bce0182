//! What a ray finds where it meets a triangle.

use super::bvh::Hit;
use crate::scene::Scene;
use glam::{DVec3, Vec2, Vec3};

/// Rays leave a surface this far above it, relative to the largest coordinate of its triangle. Double precision is off by
/// some 2⁻⁵¹ of that coordinate; what single-precision meshes can mean is above 2⁻²⁴ of it.
const LIFT: f64 = 1.0 / (1u64 << 36) as f64;

/// A point of a surface as seen from one side.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// Relative to the scene's origin.
    pub position: DVec3,
    /// Where rays start: `position`, lifted off the surface towards the viewer.
    pub ray_origin: DVec3,
    /// Unit normal of the triangle, on the viewer's side.
    pub geometric: DVec3,
    /// Unit shading normal, on the same side.
    pub normal: DVec3,
    /// Diffuse reflectance.
    pub albedo: DVec3,
    /// Radiance towards the viewer, W·sr⁻¹·m⁻².
    pub emission: DVec3,
    /// The material emits here, to this side or the other, and reflects nothing.
    pub emitter: bool,
    /// Index into the scene's triangles.
    pub triangle: u32,
}

/// Position of a point on a triangle relative to the scene's origin, exact to double precision. `b1` and `b2` are the
/// weights of corners 1 and 2.
pub fn position(scene: &Scene, triangle: u32, (b1, b2): (f64, f64)) -> DVec3 {
    let [a, b, c] = scene.corners(triangle).map(|p| p.as_dvec3());
    a * (1.0 - b1 - b2) + b * b1 + c * b2
}

/// Barycentric coordinates as the scene's own lookups take them.
pub fn single((b1, b2): (f64, f64)) -> Vec2 {
    Vec2::new(b1 as f32, b2 as f32)
}

/// A triangle's plane, in double precision.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Unit normal of the front.
    pub front: DVec3,
    /// Square scene units.
    pub area: f64,
    /// Height at which rays leave the surface.
    lift: f64,
}

impl Plane {
    /// Of a triangle of the scene.
    pub fn new(scene: &Scene, triangle: u32) -> Self {
        let [a, b, c] = scene.corners(triangle).map(|p| p.as_dvec3());
        let cross = (b - a).cross(c - a);
        let length = cross.length();
        let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
        Self { front: cross / length, area: 0.5 * length, lift: LIFT * reach }
    }
}

/// The surface at `hit`, seen by a ray of the given direction.
pub fn evaluate(scene: &Scene, plane: &Plane, hit: &Hit, direction: DVec3) -> SurfacePoint {
    let seen = scene.surface(hit.triangle, single(hit.barycentric));
    let from_front = plane.front.dot(direction) < 0.0;
    let geometric = if from_front { plane.front } else { -plane.front };
    let shading = seen.shading_normal.as_dvec3().normalize();
    let position = position(scene, hit.triangle, hit.barycentric);
    let emits = from_front || scene.materials[seen.material as usize].double_sided;
    SurfacePoint {
        position,
        ray_origin: position + geometric * plane.lift,
        geometric,
        normal: if shading.dot(geometric) < 0.0 { -shading } else { shading },
        albedo: seen.albedo.as_dvec3(),
        emission: if emits { seen.emission.as_dvec3() } else { DVec3::ZERO },
        emitter: seen.emission != Vec3::ZERO && seen.albedo == Vec3::ZERO,
        triangle: hit.triangle,
    }
}

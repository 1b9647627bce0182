//! What a ray finds where it meets a triangle.

use super::bvh::Hit;
use super::texture::{Encoding, lookup};
use crate::scene::{Material, Scene, TextureRef};
use glam::{DVec3, Vec2, Vec4};

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
    /// Diffuse reflectance; 0 where the point emits.
    pub albedo: DVec3,
    /// Radiance towards the viewer, W·sr⁻¹·m⁻².
    pub emission: DVec3,
    /// The material emits here, to this side or the other: the point does not reflect.
    pub emitter: bool,
    /// Index into the scene's triangles.
    pub triangle: u32,
}

/// Corner indices and weights of a point on a triangle, to interpolate vertex streams with.
#[derive(Clone, Copy)]
pub struct Interpolation {
    corners: [u32; 3],
    weights: [f64; 3],
}

impl Interpolation {
    /// `barycentric` belongs to corners 1 and 2.
    pub fn new(scene: &Scene, triangle: u32, (b1, b2): (f64, f64)) -> Self {
        Self { corners: scene.triangles[triangle as usize], weights: [1.0 - b1 - b2, b1, b2] }
    }

    fn sum<T, S: std::iter::Sum>(&self, stream: &[T], scale: impl Fn(&T, f64) -> S) -> S {
        self.corners.iter().zip(self.weights).map(|(&i, w)| scale(&stream[i as usize], w)).sum()
    }

    /// Position relative to the scene's origin, exact to double precision.
    pub fn position(&self, scene: &Scene) -> DVec3 {
        self.sum(&scene.positions, |p, w| p.as_dvec3() * w)
    }

    fn uv(&self, scene: &Scene, set: u32) -> Vec2 {
        let stream = &scene.uvs[set as usize];
        if stream.is_empty() { Vec2::ZERO } else { self.sum(stream, |t, w| *t * w as f32) }
    }

    fn texture(&self, scene: &Scene, reference: TextureRef, encoding: Encoding) -> Vec4 {
        lookup(scene, reference, self.uv(scene, reference.set), encoding)
    }

    /// Linear albedo (RGB) and alpha: base colour × texture × vertex colour.
    pub fn base_color(&self, scene: &Scene, material: &Material) -> Vec4 {
        let mut color = material.base_color;
        if let Some(reference) = material.base_texture {
            color *= self.texture(scene, reference, Encoding::Srgb);
        }
        if !scene.colors.is_empty() {
            color *= self.sum(&scene.colors, |c, w| *c * w as f32);
        }
        color
    }

    /// Emitted radiance on an emitting side, W·sr⁻¹·m⁻².
    pub fn emission(&self, scene: &Scene, material: &Material) -> DVec3 {
        match material.emission_texture {
            Some(reference) => {
                (material.emission * self.texture(scene, reference, Encoding::Srgb).truncate()).as_dvec3()
            }
            None => material.emission.as_dvec3(),
        }
    }

    /// Shading normal on the triangle's front, with the normal map; `geometric` where the mesh gives none.
    fn normal(&self, scene: &Scene, material: &Material, geometric: DVec3) -> DVec3 {
        let smooth = self.sum(&scene.normals, |n, w| n.as_dvec3() * w).try_normalize().unwrap_or(geometric);
        let Some(reference) = material.normal_texture.filter(|_| !scene.tangents.is_empty()) else { return smooth };
        let map = self.texture(scene, reference, Encoding::Linear).truncate().as_dvec3() * 2.0 - 1.0;
        let tangent = self.sum(&scene.tangents, |t, w| t.truncate().as_dvec3() * w);
        let handedness = f64::from(scene.tangents[self.corners[0] as usize].w);
        let bitangent = smooth.cross(tangent) * handedness;
        let scale = f64::from(material.normal_scale);
        let mapped = tangent * (map.x * scale) + bitangent * (map.y * scale) + smooth * map.z;
        mapped.try_normalize().unwrap_or(smooth)
    }
}

/// Unit normal of the triangle's front, twice its area, and the largest coordinate of its corners.
pub fn triangle_plane(scene: &Scene, triangle: u32) -> (DVec3, f64, f64) {
    let [a, b, c] = scene.triangles[triangle as usize].map(|i| scene.positions[i as usize].as_dvec3());
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
    (cross / length, length, reach)
}

/// The surface at `hit`, seen by a ray of the given direction.
pub fn evaluate(scene: &Scene, material: &Material, hit: &Hit, direction: DVec3) -> SurfacePoint {
    let at = Interpolation::new(scene, hit.triangle, hit.barycentric);
    let (front, _, reach) = triangle_plane(scene, hit.triangle);
    let from_front = front.dot(direction) < 0.0;
    let side = if from_front { 1.0 } else { -1.0 };
    let geometric = front * side;
    let mut normal = at.normal(scene, material, front);
    if normal.dot(geometric) < 0.0 {
        normal = -normal;
    }
    let position = at.position(scene);
    let emission = at.emission(scene, material);
    let emitter = emission != DVec3::ZERO;
    let albedo = if emitter { DVec3::ZERO } else { at.base_color(scene, material).truncate().as_dvec3() };
    SurfacePoint {
        position,
        ray_origin: position + geometric * (LIFT * reach),
        geometric,
        normal,
        albedo,
        emission: if from_front || material.double_sided { emission } else { DVec3::ZERO },
        emitter,
        triangle: hit.triangle,
    }
}

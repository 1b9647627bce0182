//! What a scene is like at a point of a triangle, for users on the CPU.
//!
//! Textures are read as Vulkan reads level 0: texel centres at half integers, bilinear or nearest, wrapping before the
//! fetch; sRGB is decoded before filtering.

use super::{Material, Scene, Texture, TextureRef, Wrap};
use crate::math::core::Core;
use glam::{DVec3, Vec2, Vec3, Vec4, Vec4Swizzles};
use std::sync::LazyLock;

/// sRGB bytes as linear values (IEC 61966-2-1).
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let c = i as f64 / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

/// How the colour of a texture is stored. Alpha is linear in either case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Base colour and emission.
    Srgb,
    /// Normal maps.
    Linear,
}

impl Texture {
    /// The texture at `uv`, filtered as its sampler says, linear values.
    pub fn sample(&self, uv: Vec2, encoding: Encoding) -> Vec4 {
        // A texture transform can carry finite coordinates out of range.
        let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
        let size = Vec2::new(self.width as f32, self.height as f32);
        // Far coordinates lose their fraction anyway; the clamp keeps integers in range.
        let at = (uv * size).clamp(Vec2::splat(-1e9), Vec2::splat(1e9));
        if self.nearest {
            return self.texel(at.x.floor() as i64, at.y.floor() as i64, encoding);
        }
        let corner = (at - 0.5).floor();
        let f = at - 0.5 - corner;
        let (x, y) = (corner.x as i64, corner.y as i64);
        let row = |y| self.texel(x, y, encoding).lerp(self.texel(x + 1, y, encoding), f.x);
        row(y).lerp(row(y + 1), f.y)
    }

    fn texel(&self, x: i64, y: i64, encoding: Encoding) -> Vec4 {
        let (x, y) = (self.wrap[0].apply(x, self.width), self.wrap[1].apply(y, self.height));
        let [r, g, b, a] = self.rgba[y * self.width as usize + x];
        let linear = |c: u8| f32::from(c) / 255.0;
        let color = |c: u8| if encoding == Encoding::Srgb { SRGB[usize::from(c)] } else { linear(c) };
        Vec4::new(color(r), color(g), color(b), linear(a))
    }
}

impl Wrap {
    /// The texel in `0..size` that stands at integer coordinate `i` (Vulkan 1.3, 16.6.2).
    pub fn apply(self, i: i64, size: u32) -> usize {
        let size = i64::from(size);
        let i = match self {
            Self::Repeat => i.rem_euclid(size),
            Self::ClampToEdge => i.clamp(0, size - 1),
            Self::MirroredRepeat => {
                let m = i.rem_euclid(2 * size);
                if m < size { m } else { 2 * size - 1 - m }
            }
        };
        i as usize
    }
}

/// A point of a surface. Vectors are in world space, positions relative to [`Scene::origin`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Place.
    pub position: Vec3,
    /// Unit normal of the triangle, on its front (counter-clockwise) side.
    pub geometric_normal: Vec3,
    /// Unit interpolated normal with the normal map applied; where that has no direction, the geometric normal.
    pub shading_normal: Vec3,
    /// Diffuse reflectance, each in [0, 1]; zero where the point emits.
    pub albedo: Vec3,
    /// Radiance that the front side emits (the back too if the material is double-sided), W·sr⁻¹·m⁻².
    pub emission: Vec3,
    /// Coverage; the surface is absent where it falls below the material's cutoff.
    pub alpha: f32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// A triangle that emits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emitter {
    /// Index into [`Scene::triangles`].
    pub triangle: u32,
    /// Mean emitted radiance over the triangle, W·sr⁻¹·m⁻²: exact where the emission has no texture and no mask. It may be 0
    /// where a few texels shine.
    pub radiance: Vec3,
    /// Area in square scene units.
    pub area: f32,
    /// Emits from its back too.
    pub double_sided: bool,
}

impl Scene {
    /// Smallest and largest corner of the box about all triangles, relative to the origin. Zeros without any.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let corners = self.triangles.iter().flatten().map(|v| self.positions[*v as usize]);
        let (low, high) = corners.fold(empty, |(low, high), p| (low.min(p), high.max(p)));
        if low.x <= high.x { (low, high) } else { (Vec3::ZERO, Vec3::ZERO) }
    }

    /// The ball about what lies together in a far larger scene, or about all of it.
    pub fn core(&self) -> Core {
        let corners = |t: &[u32; 3]| t.map(|v| self.positions[v as usize]);
        self.core_of_whole.unwrap_or_else(|| Core::of(self.triangles.iter().map(corners)))
    }

    /// Corners of a triangle, relative to the origin.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// Area of a triangle in square scene units, by double precision: zero only where single precision underflows.
    pub fn area(&self, triangle: u32) -> f32 {
        (0.5 * self.cross(triangle).length()) as f32
    }

    /// Unit normal of a triangle on its front side.
    pub fn geometric_normal(&self, triangle: u32) -> Vec3 {
        let cross = self.cross(triangle);
        (cross / cross.abs().max_element()).normalize_or_zero().as_vec3()
    }

    fn cross(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle).map(|p| p.as_dvec3());
        (b - a).cross(c - a)
    }

    /// Index of a triangle's material.
    pub fn material_of(&self, triangle: u32) -> u32 {
        let part = self.parts.partition_point(|p| p.first_triangle <= triangle).saturating_sub(1);
        self.parts[part].material
    }

    /// The surface at a point of a triangle; `barycentrics` are the weights of its second and third vertex.
    pub fn surface(&self, triangle: u32, barycentrics: Vec2) -> SurfacePoint {
        let place = Place::new(self, triangle, barycentrics);
        let material_index = self.material_of(triangle);
        let material = &self.materials[material_index as usize];
        let geometric_normal = self.geometric_normal(triangle);
        let base = self.base_color(material, &place);
        let emission = self.emission(material, &place);
        SurfacePoint {
            position: place.mix(&self.positions),
            geometric_normal,
            shading_normal: self.shading_normal(material, &place).unwrap_or(geometric_normal),
            albedo: base.xyz(),
            emission,
            alpha: base.w,
            material: material_index,
        }
    }

    /// Whether the surface is there at a point of a triangle: false where its alpha mask cuts it away.
    pub fn is_present(&self, triangle: u32, barycentrics: Vec2) -> bool {
        let material = &self.materials[self.material_of(triangle) as usize];
        let alpha = || self.alpha(material, self.triangles[triangle as usize], barycentrics);
        material.alpha_cutoff.is_none_or(|cutoff| alpha() >= cutoff)
    }

    /// Coverage at a point of the triangle of three vertices.
    pub(super) fn alpha(&self, material: &Material, vertices: [u32; 3], barycentrics: Vec2) -> f32 {
        self.base_color(material, &Place::among(vertices, barycentrics)).w
    }

    /// Diffuse reflectance at a point of the triangle of three vertices, each in [0, 1]; `None` where the surface is absent.
    pub(crate) fn albedo_at(&self, material: u32, vertices: [u32; 3], barycentrics: Vec2) -> Option<Vec3> {
        let material = &self.materials[material as usize];
        let place = Place::among(vertices, barycentrics);
        let base = self.base_color(material, &place);
        if material.alpha_cutoff.is_some_and(|cutoff| base.w < cutoff) {
            return None;
        }
        Some(base.xyz().clamp(Vec3::ZERO, Vec3::ONE))
    }

    /// Whether the reflectance of a material changes over a triangle.
    pub(crate) fn albedo_varies(&self, material: u32) -> bool {
        let material = &self.materials[material as usize];
        material.base_texture.is_some() || !self.colors.is_empty()
    }

    /// All triangles that emit, in order.
    pub fn emitters(&self) -> Vec<Emitter> {
        let triangles = self.parts.iter().filter(|part| self.emits(part)).flat_map(|part| part.triangles());
        let emitter = |triangle| {
            let material = &self.materials[self.material_of(triangle) as usize];
            let (area, double_sided) = (self.area(triangle), material.double_sided);
            Emitter { triangle, radiance: self.mean_emission(material, triangle), area, double_sided }
        };
        triangles.map(emitter).collect()
    }

    /// Emission averaged over the pieces of an even subdivision: exact where it is even, else good to choose triangles by.
    fn mean_emission(&self, material: &Material, triangle: u32) -> Vec3 {
        const FINEST: u32 = 5;
        if !self.emission_varies(triangle) {
            return material.emission;
        }
        let pieces = self.emission_of_pieces(triangle, self.emission_level(triangle, FINEST));
        pieces.iter().sum::<Vec3>() / pieces.len() as f32
    }

    fn base_color(&self, material: &Material, place: &Place) -> Vec4 {
        let vertex = if self.colors.is_empty() { Vec4::ONE } else { place.mix(&self.colors) };
        material.base_color * vertex * self.lookup(material.base_texture, place, Encoding::Srgb)
    }

    /// Radiance that a triangle emits at a point, wherever its mask cuts it away.
    pub(super) fn surface_emission(&self, triangle: u32, barycentrics: Vec2) -> Vec3 {
        let material = &self.materials[self.material_of(triangle) as usize];
        self.emission(material, &Place::new(self, triangle, barycentrics))
    }

    fn emission(&self, material: &Material, place: &Place) -> Vec3 {
        if material.emission == Vec3::ZERO {
            return Vec3::ZERO;
        }
        material.emission * self.lookup(material.emission_texture, place, Encoding::Srgb).xyz()
    }

    /// Interpolated normal, bent by the normal map (glTF 2.0 §3.9.3); `None` where it has no direction.
    fn shading_normal(&self, material: &Material, place: &Place) -> Option<Vec3> {
        let normal = place.mix(&self.normals).try_normalize()?;
        let Some(map) = material.normal_texture.filter(|_| !self.tangents.is_empty()) else { return Some(normal) };
        let texel = self.lookup(Some(map), place, Encoding::Linear).xyz() * 2.0 - 1.0;
        let bent = texel * Vec3::new(material.normal_scale, material.normal_scale, 1.0);
        let tangent = place.mix(&self.tangents);
        let along = (tangent.xyz() - normal * normal.dot(tangent.xyz())).try_normalize();
        let Some(along) = along else { return Some(normal) };
        let across = normal.cross(along) * if tangent.w < 0.0 { -1.0 } else { 1.0 };
        (along * bent.x + across * bent.y + normal * bent.z).try_normalize().or(Some(normal))
    }

    fn lookup(&self, texture: Option<TextureRef>, place: &Place, encoding: Encoding) -> Vec4 {
        let Some(texture) = texture else { return Vec4::ONE };
        let uv = place.mix(&self.uvs[texture.set as usize]);
        self.textures[texture.texture as usize].sample(texture.transform.transform_point2(uv), encoding)
    }
}

/// Three vertices and their weights.
struct Place {
    vertices: [u32; 3],
    weights: [f32; 3],
}

impl Place {
    fn new(scene: &Scene, triangle: u32, b: Vec2) -> Self {
        Self::among(scene.triangles[triangle as usize], b)
    }

    fn among(vertices: [u32; 3], b: Vec2) -> Self {
        Self { vertices, weights: [1.0 - b.x - b.y, b.x, b.y] }
    }

    /// Weighted sum of the vertices' entries in a stream.
    fn mix<T>(&self, stream: &[T]) -> T
    where
        T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
    {
        let [a, b, c] = self.vertices.map(|v| stream[v as usize]);
        let [wa, wb, wc] = self.weights;
        a * wa + b * wb + c * wc
    }
}

#[cfg(test)]
#[path = "sample_tests.rs"]
mod tests;

//! What is rendered: triangles, materials, lights, cameras and the background, with nothing of the GPU in it.
//!
//! A [`Scene`] is flat: node transforms and instances are applied, so that each triangle has its place in the world and
//! can carry its own lit radiance. Lengths are the file's units; radiometric values are RGB without hidden scale (glTF's
//! candela, lux and nits are taken as W·sr⁻¹, W·m⁻² and W·sr⁻¹·m⁻²).
//!
//! [`load()`] reads one from glTF ([`mod@load`] says what is read and what is tolerated); [`cornell()`] is built in.

mod background;
pub mod build;
mod camera;
mod change;
mod cornell;
pub mod emission;
mod error;
mod fingerprint;
mod gltf;
pub mod load;
pub mod opacity;
mod sample;
mod tessellate;
mod whiten;

pub use camera::{LARGEST_SIDE, frame, image_size};
pub use cornell::cornell;
pub use error::SceneError;
pub use load::{Limits, Options, Pose, Resolver, load, load_from_slice, load_with};
pub use sample::{Emitter, Encoding, SurfacePoint};
pub use tessellate::SideLimit;

use crate::math::core::Core;
use glam::{DMat4, DVec3, Mat3, Vec2, Vec3, Vec4};
use std::ops::Range;

/// A whole scene, in world space relative to [`Scene::origin`].
///
/// Vertex streams have one entry a vertex, or none where the scene does not need the stream.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The file's stem, or the built-in's name.
    pub name: String,
    /// World position of the point that every position of the scene is relative to. Zero unless the scene lies far from
    /// zero compared with its size, where single precision would lose its detail.
    pub origin: DVec3,
    /// Vertex positions, relative to `origin`. All finite.
    pub positions: Vec<Vec3>,
    /// Unit shading normals; computed from the triangles where the file has none.
    pub normals: Vec<Vec3>,
    /// Unit tangents, handedness ±1 in `w`; empty unless a material has a normal map.
    pub tangents: Vec<Vec4>,
    /// Texture coordinate sets 0 and 1; empty unless a texture reads the set.
    pub uvs: [Vec<Vec2>; 2],
    /// Vertex colours (linear RGBA), factors of the base colour; empty unless the file has some.
    pub colors: Vec<Vec4>,
    /// Vertex indices, grouped by material as `parts` says; every index is in range and no triangle has zero area.
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// A partition of `triangles` in order, one part a material that is used.
    pub parts: Vec<Part>,
    /// Materials, named by [`Part::material`].
    pub materials: Vec<Material>,
    /// Decoded textures, named by [`TextureRef::texture`].
    pub textures: Vec<Texture>,
    /// The core of the surface before it was cut ([`Scene::tessellated`]); none where it was not.
    pub core_of_whole: Option<Core>,
    /// Punctual lights.
    pub lights: Vec<Light>,
    /// Cameras; empty where the file has none.
    pub cameras: Vec<Camera>,
    /// Animations of the file, whether or not one of them is shown.
    pub animations: Vec<Animation>,
    /// Radiance that arrives from outside all geometry.
    pub background: Background,
    /// What was tolerated or left out while loading, a line each, for the user.
    pub notes: Vec<String>,
}

impl Part {
    /// Its triangles among [`Scene::triangles`].
    pub fn triangles(&self) -> Range<u32> {
        self.first_triangle..self.first_triangle + self.triangle_count
    }
}

impl Scene {
    /// Corners of the part's triangles.
    pub fn triangles_of(&self, part: &Part) -> &[[u32; 3]] {
        let Range { start, end } = part.triangles();
        &self.triangles[start as usize..end as usize]
    }

    /// Whether the scene has no light: no lamp, no emissive surface, no background.
    pub fn is_dark(&self) -> bool {
        let lit = |light: &Light| match light {
            Light::Point { intensity, .. } | Light::Spot { intensity, .. } => *intensity != Vec3::ZERO,
            Light::Directional { irradiance, .. } => *irradiance != Vec3::ZERO,
        };
        !self.lights.iter().any(lit) && !self.parts.iter().any(|part| self.emits(part)) && self.background.is_black()
    }

    /// Whether the part's surface shines.
    pub fn emits(&self, part: &Part) -> bool {
        self.materials[part.material as usize].emission != Vec3::ZERO
    }

    /// Whether the part's surface is absent in places.
    pub fn is_masked(&self, part: &Part) -> bool {
        self.materials[part.material as usize].alpha_cutoff.is_some()
    }

    /// Number of triangles without an alpha mask.
    pub fn opaque_count(&self) -> u32 {
        self.parts.iter().filter(|part| !self.is_masked(part)).map(|part| part.triangle_count).sum()
    }
}

/// An animation of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Name in the file; empty where it has none.
    pub name: String,
    /// Time of its last key, in seconds.
    pub seconds: f64,
}

/// A run of triangles with one material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// First triangle of the run.
    pub first_triangle: u32,
    /// Number of triangles; at least one.
    pub triangle_count: u32,
}

/// A Lambertian surface, two-sided in reflection.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the file; empty where it has none.
    pub name: String,
    /// Linear diffuse albedo (RGB) and alpha, factors of the texture and of the vertex colour.
    pub base_color: Vec4,
    /// Base colour texture (sRGB colour, linear alpha).
    pub base_texture: Option<TextureRef>,
    /// Tangent-space normal map (linear).
    pub normal_texture: Option<TextureRef>,
    /// Factor of the normal map's X and Y.
    pub normal_scale: f32,
    /// Emitted radiance, W·sr⁻¹·m⁻², emissive strength included; a factor of the texture. A point that emits
    /// reflects as well.
    pub emission: Vec3,
    /// Emission texture (sRGB).
    pub emission_texture: Option<TextureRef>,
    /// Surface is absent where alpha falls below this; `None` is opaque.
    pub alpha_cutoff: Option<f32>,
    /// Emits from both sides. Reflection is two-sided in any case.
    pub double_sided: bool,
}

/// A use of a texture by a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::textures`].
    pub texture: u32,
    /// Texture coordinate set, 0 or 1.
    pub set: u32,
    /// Applied to (u, v, 1): KHR_texture_transform.
    pub transform: Mat3,
}

/// Texels and the way they are read: 8-bit RGBA, row 0 at v = 0, magnification filter at level 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// File name or the image's name.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width × height` RGBA texels as stored in the file: sRGB or linear, by their use.
    pub rgba: Vec<[u8; 4]>,
    /// Wrapping along u and v.
    pub wrap: [Wrap; 2],
    /// Nearest texel instead of bilinear.
    pub nearest: bool,
}

/// What a texture shows outside [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Wrap {
    /// Tiles.
    #[default]
    Repeat,
    /// Tiles, every second one mirrored.
    MirroredRepeat,
    /// The border texel goes on.
    ClampToEdge,
}

/// A punctual light (KHR_lights_punctual), as radiometric RGB. `range` is not applied: it is a hint for culling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Radiant intensity in all directions.
    Point {
        /// Relative to the scene's origin.
        position: Vec3,
        /// W·sr⁻¹.
        intensity: Vec3,
    },
    /// A cone with a smooth edge: intensity × clamp((cosθ − cos_outer)/(cos_inner − cos_outer), 0, 1)².
    Spot {
        /// Relative to the scene's origin.
        position: Vec3,
        /// Unit direction of the axis, away from the light.
        direction: Vec3,
        /// W·sr⁻¹ on the axis.
        intensity: Vec3,
        /// Cosine of the half angle within which the intensity is full.
        cos_inner: f64,
        /// Cosine of the half angle outside which it is zero; `cos_inner` or below: a hard edge where both are the same.
        cos_outer: f64,
    },
    /// Parallel light.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// W·m⁻² on a surface that faces the light.
        irradiance: Vec3,
    },
}

/// A view. `camera_to_world` is relative to the scene's origin; the camera looks along −Z, +Y up, without scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Name of the node or camera; empty where the file has none.
    pub name: String,
    /// Rigid transform.
    pub camera_to_world: DMat4,
    /// Projection.
    pub lens: Lens,
}

/// A camera's projection. Its clip planes are not used: the renderer needs none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// Vertical field of view in radians; the horizontal one follows from the image's shape.
    Perspective {
        /// Full vertical angle.
        yfov: f64,
        /// Width over height that the file asks for, if it does: the default image shape.
        aspect: Option<f64>,
    },
    /// Half height of the view in scene units; the half width follows from the image's shape.
    Orthographic {
        /// Width over height that the file asks for, if it does: the default image shape.
        aspect: Option<f64>,
        /// Half height.
        ymag: f64,
    },
}

/// Radiance from outside the scene, W·sr⁻¹·m⁻².
#[derive(Debug, Clone, Default)]
pub enum Background {
    /// Nothing.
    #[default]
    Black,
    /// The same in all directions.
    Constant(Vec3),
    /// An equirectangular map.
    Map(EnvironmentMap),
}

/// Equirectangular radiance: row 0 at the top (+Y), the centre column looks along −Z, columns go right to +X.
#[derive(Debug, Clone)]
pub struct EnvironmentMap {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width × height` linear RGB, finite and not negative.
    pub rgb: Vec<[f32; 3]>,
}

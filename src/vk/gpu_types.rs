//! Structs shared with the shaders (`glsl/shared/types.glsl`), their layouts asserted at compile time.

use bytemuck::{Pod, Zeroable};

/// A place to look from; `Frame` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Origin; near distance.
    pub origin: [f32; 4],
    /// First axis; projection scale along it.
    pub tangent: [f32; 4],
    /// Second axis; projection scale along it.
    pub bitangent: [f32; 4],
    /// Axis of the view; 1/depth range of an orthographic view, of a perspective one the share of its depth that matters.
    pub normal: [f32; 4],
    /// Plane below which nothing is seen.
    pub horizon: [f32; 4],
}

/// Place and validity of a record of a batch; `Record` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Record {
    /// Position; R in world units, without any limit.
    pub position: [f32; 4],
    /// Shading normal; 1/R, unclamped.
    pub normal: [f32; 4],
    /// Geometric normal.
    pub geometric: [f32; 4],
}

/// A record that is kept; `Kept` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Kept {
    /// Position; R in world units, without any limit.
    pub position: [f32; 4],
    /// Shading normal; largest 1/(forward distance) of the horizon.
    pub normal: [f32; 4],
    /// First axis of the capture; the second is normal × tangent.
    pub tangent: [f32; 4],
}

/// What an index of records holds of each; `Entry` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Entry {
    /// Position; R, negative for what is not a number.
    pub place: [f32; 4],
    /// Shading normal, octahedral; number of the record; its reach as its neighbours clamp it (bits).
    pub about: [u32; 4],
}

/// What a record carries; `Payload` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Payload {
    /// Irradiance, W·m⁻².
    pub irradiance: [f32; 4],
    /// Rotation gradient a channel; the most that the channel can be.
    pub rotation: [[f32; 4]; 3],
    /// Translation gradient a channel.
    pub translation: [[f32; 4]; 3],
}

/// What a kept record carries; `KeptPayload` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct KeptPayload {
    /// Irradiance, W·m⁻²; the most that red can be.
    pub irradiance: [f32; 4],
    /// A channel: rotation gradient (x, y) and translation gradient (x, y) along the axes of the capture.
    pub change: [[f32; 4]; 3],
    /// The most that green and blue can be.
    pub most: [f32; 4],
}

/// One sample of a light; `LightSample` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightSample {
    /// Position; squared disc radius of an area sample.
    pub position: [f32; 4],
    /// Axis; 1 − cos of a spot's outer angle.
    pub direction: [f32; 4],
    /// Irradiance, intensity, or radiance × area; a spot's falloff scale.
    pub power: [f32; 4],
    /// Inner and outer radius of the shell about the scene's core that its shadow view is for; 0 where there is no end.
    pub shell: [f32; 4],
}

/// An emissive triangle seen from the side that emits; `EmitterFace` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct EmitterFace {
    /// First corner; share of the triangle's samples that the batch holds.
    pub a: [f32; 4],
    /// Second corner; first of its samples in the batch, as bits.
    pub b: [f32; 4],
    /// Third corner; number of its samples in the batch, as bits.
    pub c: [f32; 4],
}

/// A material; `Material` in GLSL.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Albedo and alpha.
    pub base_color: [f32; 4],
    /// Emitted radiance; normal map scale.
    pub emission: [f32; 4],
    /// Rows of the base texture's transform; texture coordinate set.
    pub base_uv: [[f32; 4]; 2],
    /// The normal map's.
    pub normal_uv: [[f32; 4]; 2],
    /// The emission texture's.
    pub emission_uv: [[f32; 4]; 2],
    /// Alpha cutoff; 1 if the back emits too.
    pub alpha: [f32; 4],
}

/// A texel of a capture: two values of `texels` in `glsl/integrate`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Texel {
    /// Cosine-weighted solid angle; ∫ n×ω dω (x, y); layer, row and column packed (bits).
    pub weights: [f32; 4],
    /// Local unit direction; the fourth is not used.
    pub direction: [f32; 4],
}

/// An edge between two texels of a capture: three values of `edges` in `glsl/integrate`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Edge {
    /// Factor of the translation gradient, local (x, y); the two texels (bits).
    pub step: [f32; 4],
    /// Local unit direction between the texels' own.
    pub between: [f32; 4],
    /// Factors of the second derivatives xx, xy and yy.
    pub bend: [f32; 4],
}

/// A texel of a face that is summed where it is rasterised: four values of `texel_table` in `glsl/capture_compute`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FaceTexel {
    /// Cosine-weighted solid angle; ∫ n×ω dω (x, y).
    pub weights: [f32; 4],
    /// Edge to the left: factor of the translation gradient, local (x, y); 1/distance of its middle; factor of ∂²E/∂x².
    pub left: [f32; 4],
    /// Edge above, likewise.
    pub up: [f32; 4],
    /// Factors of ∂²E/∂x∂y and ∂²E/∂y² of both.
    pub bend: [f32; 4],
}

const _: () = {
    assert!(size_of::<Frame>() == 80);
    assert!(size_of::<Record>() == 48);
    assert!(size_of::<Kept>() == 48);
    assert!(size_of::<Entry>() == 32);
    assert!(size_of::<Payload>() == 112);
    assert!(size_of::<KeptPayload>() == 80);
    assert!(size_of::<LightSample>() == 64);
    assert!(size_of::<EmitterFace>() == 48);
    assert!(size_of::<Material>() == 144);
    assert!(size_of::<Texel>() == 32);
    assert!(size_of::<Edge>() == 48);
    assert!(size_of::<FaceTexel>() == 64);
};

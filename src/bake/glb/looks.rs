//! Materials, textures and vertex colours.

use super::{Extras, Glb};
use crate::scene::{Material, Scene, Texture, TextureRef, Wrap};
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};
use std::f32::consts::PI;
use std::io;

/// What the file's materials may name.
pub struct Textures {
    any_transform: bool,
}

impl Textures {
    /// Adds all of the scene's textures, each with an image and a sampler of its own.
    pub fn add(file: &mut Glb, scene: &Scene) -> io::Result<Self> {
        let (mut images, mut samplers, mut textures) = (Vec::new(), Vec::new(), Vec::new());
        for (index, texture) in scene.textures.iter().enumerate() {
            let view = file.view(&png(texture)?, None);
            images.push(json!({"name": texture.name, "bufferView": view, "mimeType": "image/png"}));
            samplers.push(sampler(texture));
            textures.push(json!({"source": index, "sampler": index}));
        }
        if !textures.is_empty() {
            file.root.insert("images".into(), images.into());
            file.root.insert("samplers".into(), samplers.into());
            file.root.insert("textures".into(), textures.into());
        }
        let used = |m: &Material| [m.base_texture, m.normal_texture, m.emission_texture];
        let moved = |t: &TextureRef| t.transform != glam::Mat3::IDENTITY;
        let any_transform = scene.materials.iter().flat_map(used).flatten().any(|t| moved(&t));
        if any_transform {
            file.uses("KHR_texture_transform");
        }
        Ok(Self { any_transform })
    }

    fn named(&self, used: &TextureRef) -> Value {
        let mut named = json!({"index": used.texture, "texCoord": used.set});
        if self.any_transform {
            named["extensions"] = json!({"KHR_texture_transform": transform(used)});
        }
        named
    }
}

/// The parts of what the loader multiplies: offset · rotation · scale.
fn transform(used: &TextureRef) -> Value {
    let [x, y, offset] = [used.transform.x_axis, used.transform.y_axis, used.transform.z_axis].map(|v| v.truncate());
    let flip = if x.perp_dot(y) < 0.0 { -1.0 } else { 1.0 };
    let scale = Vec2::new(x.length(), flip * y.length());
    json!({"offset": offset.to_array(), "rotation": -x.y.atan2(x.x), "scale": scale.to_array()})
}

fn png(texture: &Texture) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new(&mut bytes);
    let written =
        encoder.write_image(texture.rgba.as_flattened(), texture.width, texture.height, ExtendedColorType::Rgba8);
    written.map_err(io::Error::other)?;
    Ok(bytes)
}

fn sampler(texture: &Texture) -> Value {
    let wrap = texture.wrap.map(|wrap| match wrap {
        Wrap::ClampToEdge => 33071,
        Wrap::MirroredRepeat => 33648,
        Wrap::Repeat => 10497,
    });
    let filter = if texture.nearest { 9728 } else { 9729 };
    json!({"wrapS": wrap[0], "wrapT": wrap[1], "magFilter": filter, "minFilter": filter})
}

/// A material; unlit with an exposure.
pub fn material(material: &Material, textures: &Textures, unlit_stops: Option<f32>) -> Value {
    let Material { base_color, emission, .. } = *material;
    let shines = emission != Vec3::ZERO;
    let shown = |stops: f32| (emission * stops.exp2()).min(Vec3::ONE).extend(base_color.w);
    let base = unlit_stops.filter(|_| shines).map_or(base_color, shown);
    let mut pbr = json!({"baseColorFactor": base.to_array(), "metallicFactor": 0.0, "roughnessFactor": 1.0});
    if let Some(used) = &material.base_texture {
        pbr["baseColorTexture"] = textures.named(used);
    }
    let mut written = json!({"pbrMetallicRoughness": pbr, "doubleSided": material.double_sided});
    if !material.name.is_empty() {
        written["name"] = json!(material.name);
    }
    if let Some(used) = &material.normal_texture {
        written["normalTexture"] = textures.named(used);
        written["normalTexture"]["scale"] = material.normal_scale.into();
    }
    if let Some(cutoff) = material.alpha_cutoff {
        written["alphaMode"] = "MASK".into();
        written["alphaCutoff"] = cutoff.into();
    }
    let mut extensions = json!({});
    // What is unlit shows its base colour alone.
    if shines && unlit_stops.is_none() {
        let strength = emission.max_element().max(1.0);
        written["emissiveFactor"] = json!((emission / strength).to_array());
        if strength > 1.0 {
            extensions["KHR_materials_emissive_strength"] = json!({"emissiveStrength": strength});
        }
        if let Some(used) = &material.emission_texture {
            written["emissiveTexture"] = textures.named(used);
        }
    }
    if unlit_stops.is_some() {
        extensions["KHR_materials_unlit"] = json!({});
    }
    if extensions.as_object().is_some_and(|e| !e.is_empty()) {
        written["extensions"] = extensions;
    }
    written
}

/// Extensions that the materials name.
pub fn extensions(scene: &Scene, unlit: bool) -> impl Iterator<Item = &'static str> {
    let strong = scene.materials.iter().any(|m| m.emission.max_element() > 1.0);
    let strength = (strong && !unlit).then_some("KHR_materials_emissive_strength");
    strength.into_iter().chain(unlit.then_some("KHR_materials_unlit"))
}

/// Colours of the vertices: the scene's own, times the light where that is shown.
pub fn colors(scene: &Scene, extras: &Extras) -> Option<Vec<[f32; 4]>> {
    let own = |vertex: usize| scene.colors.get(vertex).copied().unwrap_or(Vec4::ONE);
    let Some((irradiance, stops)) = extras.irradiance.as_ref().zip(extras.unlit_stops) else {
        return (!scene.colors.is_empty()).then(|| scene.colors.iter().map(|c| c.to_array()).collect());
    };
    let mut shines = vec![false; scene.positions.len()];
    for part in scene.parts.iter().filter(|part| scene.emits(part)) {
        scene.triangles_of(part).iter().flatten().for_each(|v| shines[*v as usize] = true);
    }
    let lit = |(vertex, e): (usize, &Vec3)| {
        let light = if shines[vertex] { Vec3::ONE } else { *e * (stops.exp2() / PI) };
        (own(vertex).xyz() * light).min(Vec3::ONE).extend(own(vertex).w).to_array()
    };
    Some(irradiance.iter().enumerate().map(lit).collect())
}

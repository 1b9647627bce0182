//! Materials as Lambertian surfaces: base colour is the albedo; metallic, roughness and occlusion are not used.

use super::document::{Document, item};
use super::error::{Fault, Kind, Result, Within};
use super::{Notes, textures::TextureStore};
use crate::scene::{Material, TextureRef};
use glam::{Mat3, Vec2, Vec3, Vec4};
use gltf::json;
use json::extensions::texture::TextureTransform;
use json::material::AlphaMode;
use json::validation::Checked;
use serde::Deserialize;

/// Alpha below which a blended surface is absent.
const BLEND_CUTOFF: f32 = 0.5;

/// KHR_materials_pbrSpecularGlossiness, its diffuse part.
#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
struct Diffuse {
    diffuse_factor: Option<[f32; 4]>,
    diffuse_texture: Option<json::texture::Info>,
}

/// glTF's default material: white.
pub fn default_material() -> Material {
    Material {
        name: String::new(),
        base_color: Vec4::ONE,
        base_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
        emission: Vec3::ZERO,
        emission_texture: None,
        alpha_cutoff: None,
        double_sided: false,
    }
}

/// Converts the document's material `index`.
pub fn convert(
    document: &Document,
    index: usize,
    store: &mut TextureStore<'_, '_>,
    notes: &mut Notes,
) -> Result<Material> {
    let material = item(&document.materials, "material", index)?;
    convert_one(material, store, notes).within(|| document.material_label(index))
}

fn convert_one(material: &json::Material, store: &mut TextureStore<'_, '_>, notes: &mut Notes) -> Result<Material> {
    let (base_color, base_texture) = base(material)?;
    let emission = emission(material)?;
    let emission_texture = material.emissive_texture.as_ref().filter(|_| emission != Vec3::ZERO);
    let normal = material.normal_texture.as_ref();
    Ok(Material {
        name: material.name.clone().unwrap_or_default(),
        base_color: clamp_color(base_color, notes)?,
        base_texture: or_none(base_texture.map(|t| texture(&t, store).within(|| "base colour")), notes)?,
        normal_texture: or_none(normal.map(|t| normal_texture(t, store).within(|| "normal map")), notes)?,
        normal_scale: normal.map_or(1.0, |t| if t.scale.is_finite() { t.scale } else { 1.0 }),
        emission,
        emission_texture: or_none(emission_texture.map(|t| texture(t, store).within(|| "emission")), notes)?,
        alpha_cutoff: alpha_cutoff(material, notes),
        double_sided: material.double_sided,
    })
}

/// The texture that a material reads; a note where that shows no image.
fn or_none(texture: Option<Result<Option<TextureRef>>>, notes: &mut Notes) -> Result<Option<TextureRef>> {
    let Some(texture) = texture.transpose()? else { return Ok(None) };
    notes.add_if("textures without an image are left out", texture.is_none());
    Ok(texture)
}

/// Base colour, from the specular-glossiness extension where the material has it.
fn base(material: &json::Material) -> Result<(Vec4, Option<json::texture::Info>)> {
    let name = "KHR_materials_pbrSpecularGlossiness";
    if let Some(value) = material.extensions.as_ref().and_then(|e| e.others.get(name)) {
        let diffuse = Diffuse::deserialize(value).map_err(|e| Fault::invalid(format!("{name}: {e}")))?;
        return Ok((diffuse.diffuse_factor.unwrap_or([1.0; 4]).into(), diffuse.diffuse_texture));
    }
    let pbr = &material.pbr_metallic_roughness;
    Ok((pbr.base_color_factor.0.into(), pbr.base_color_texture.clone()))
}

fn clamp_color(color: Vec4, notes: &mut Notes) -> Result<Vec4> {
    if !color.is_finite() {
        return Err(Fault::invalid(format!("base colour {color} is not finite")));
    }
    let clamped = color.clamp(Vec4::ZERO, Vec4::ONE);
    if clamped != color {
        notes.add("base colours outside [0, 1] are clamped");
    }
    Ok(clamped)
}

fn emission(material: &json::Material) -> Result<Vec3> {
    let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |s| s.emissive_strength.0);
    let emission = Vec3::from(material.emissive_factor.0) * strength;
    if emission.is_finite() && emission.cmpge(Vec3::ZERO).all() {
        return Ok(emission);
    }
    Err(Fault::invalid(format!("emission {emission} is negative or not finite")))
}

fn alpha_cutoff(material: &json::Material, notes: &mut Notes) -> Option<f32> {
    match material.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => Some(material.alpha_cutoff.map_or(0.5, |c| c.0)),
        Checked::Valid(AlphaMode::Blend) => {
            notes.add(format!("blended surfaces are cut off where alpha is below {BLEND_CUTOFF}"));
            Some(BLEND_CUTOFF)
        }
        _ => None,
    }
}

fn texture(info: &json::texture::Info, store: &mut TextureStore<'_, '_>) -> Result<Option<TextureRef>> {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    texture_ref(info.index.value(), info.tex_coord, transform, store)
}

fn normal_texture(
    info: &json::material::NormalTexture,
    store: &mut TextureStore<'_, '_>,
) -> Result<Option<TextureRef>> {
    let name = "KHR_texture_transform";
    let value = info.extensions.as_ref().and_then(|e| e.others.get(name));
    let transform = value.map(TextureTransform::deserialize).transpose();
    let transform = transform.map_err(|e| Fault::invalid(format!("{name}: {e}")))?;
    texture_ref(info.index.value(), info.tex_coord, transform.as_ref(), store)
}

fn texture_ref(
    index: usize,
    set: u32,
    transform: Option<&TextureTransform>,
    store: &mut TextureStore<'_, '_>,
) -> Result<Option<TextureRef>> {
    let set = transform.and_then(|t| t.tex_coord).unwrap_or(set);
    if set > 1 {
        let what = format!("texture coordinate set {set} is not supported; use set 0 or 1");
        return Err(Fault::new(Kind::Unsupported, what));
    }
    let transform = transform.map_or(Mat3::IDENTITY, matrix);
    if !transform.is_finite() {
        return Err(Fault::invalid("its texture transform is not finite"));
    }
    Ok(store.get(index)?.map(|texture| TextureRef { texture, set, transform }))
}

/// Scale, then rotation, then offset (KHR_texture_transform). v points down, so the rotation that looks
/// counter-clockwise has the signs of a clockwise one; the extension's GLSL listing misses this (KhronosGroup/glTF#1563),
/// its text and other implementations do not.
fn matrix(t: &TextureTransform) -> Mat3 {
    Mat3::from_translation(Vec2::from(t.offset.0))
        * Mat3::from_rotation_z(-t.rotation.0)
        * Mat3::from_scale(Vec2::from(t.scale.0))
}

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
    let label = || document.material_label(index);
    convert_one(material, &label, store, notes).within(label)
}

fn convert_one(
    material: &json::Material,
    label: &dyn Fn() -> String,
    store: &mut TextureStore<'_, '_>,
    notes: &mut Notes,
) -> Result<Material> {
    let (base_color, base_info) = base(material)?;
    let sets = coordinate_sets(material);
    let emission = emission(material)?;
    let emission_info = material.emissive_texture.as_ref().filter(|_| emission != Vec3::ZERO);
    let normal = material.normal_texture.as_ref();
    let mut base_color = clamp_color(base_color, label, notes)?;
    let base_found = texture(base_info.as_ref().map(plain_use), sets, store).within(|| "base colour")?;
    let normal_found = texture(normal.map(normal_use), sets, store).within(|| "normal map")?;
    let emission_found = texture(emission_info.map(plain_use), sets, store).within(|| "emission")?;
    let dark = matches!(emission_found, Found::Missing(_));
    Ok(Material {
        name: material.name.clone().unwrap_or_default(),
        base_texture: base_picture(base_found, &mut base_color, notes),
        base_color,
        normal_texture: normal_found.or_noted("the surface is smooth in its place", notes),
        normal_scale: normal.map_or(1.0, |t| if t.scale.is_finite() { t.scale } else { 1.0 }),
        emission: if dark { Vec3::ZERO } else { emission },
        emission_texture: emission_found.or_noted("it does not shine", notes),
        alpha_cutoff: alpha_cutoff(material, notes),
        double_sided: material.double_sided,
    })
}

/// What stands for a picture that cannot be shown.
const STAND_IN: f32 = 0.5;

/// The base colour's texture. Where its picture cannot be shown, grey stands for it.
fn base_picture(found: Found, color: &mut Vec4, notes: &mut Notes) -> Option<TextureRef> {
    if let Found::Missing(what) = &found {
        notes.add(format!("{what}: grey of {STAND_IN} in its place"));
        *color *= Vec4::new(STAND_IN, STAND_IN, STAND_IN, 1.0);
    }
    found.shown(notes)
}

impl Found {
    /// The use of a texture that there is.
    fn shown(self, notes: &mut Notes) -> Option<TextureRef> {
        notes.add_if("textures without an image are left out", matches!(self, Self::Nothing));
        if let Self::Texture(texture) = self { Some(texture) } else { None }
    }

    /// The same, with a note on what is missing.
    fn or_noted(self, without: &str, notes: &mut Notes) -> Option<TextureRef> {
        if let Self::Missing(what) = &self {
            notes.add(format!("{what}: {without}"));
        }
        self.shown(notes)
    }
}

/// What a material finds where it names a texture.
enum Found {
    Texture(TextureRef),
    /// A texture that shows no image.
    Nothing,
    /// One that cannot be shown, and why.
    Missing(String),
    /// The material names none.
    Unnamed,
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

fn clamp_color(color: Vec4, label: &dyn Fn() -> String, notes: &mut Notes) -> Result<Vec4> {
    if !color.is_finite() {
        return Err(Fault::invalid(format!("base colour {color} is not finite")));
    }
    let clamped = color.clamp(Vec4::ZERO, Vec4::ONE);
    if clamped != color {
        notes.add(format!("the base colour of {} is outside [0, 1] and is clamped", label()));
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

/// Where a texture's coordinates are from: the info's set and transform.
type Use = (usize, u32, Option<TextureTransform>);

fn plain_use(info: &json::texture::Info) -> Result<Use> {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.clone());
    Ok((info.index.value(), info.tex_coord, transform))
}

fn normal_use(info: &json::material::NormalTexture) -> Result<Use> {
    let name = "KHR_texture_transform";
    let value = info.extensions.as_ref().and_then(|e| e.others.get(name));
    let transform = value.map(TextureTransform::deserialize).transpose();
    Ok((info.index.value(), info.tex_coord, transform.map_err(|e| Fault::invalid(format!("{name}: {e}")))?))
}

fn set_of((_, set, transform): &Use) -> u32 {
    transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(*set)
}

/// The coordinate sets that the material's textures read, in the places that they have in a scene. Sets 0 and 1 keep
/// theirs; a higher one takes what is free.
pub fn coordinate_sets(material: &json::Material) -> [u32; 2] {
    let mut sets: Vec<u32> = uses(material).iter().flatten().map(set_of).collect();
    sets.sort_unstable();
    sets.dedup();
    match sets[..] {
        [] | [0] | [1] => [0, 1],
        [1, high] => [high, 1],
        [low, high, ..] => [low, high],
        [high] => [high, 1],
    }
}

/// Uses of base colour, normal map and emission, as far as they can be read.
fn uses(material: &json::Material) -> [Option<Use>; 3] {
    let base = base(material).ok().and_then(|(_, info)| plain_use(&info?).ok());
    let normal = material.normal_texture.as_ref().and_then(|info| normal_use(info).ok());
    let emission = material.emissive_texture.as_ref().filter(|_| emission(material).is_ok_and(|e| e != Vec3::ZERO));
    [base, normal, emission.and_then(|info| plain_use(info).ok())]
}

fn texture(used: Option<Result<Use>>, sets: [u32; 2], store: &mut TextureStore<'_, '_>) -> Result<Found> {
    let Some(used) = used.transpose()? else { return Ok(Found::Unnamed) };
    let set = set_of(&used);
    let Some(place) = sets.iter().position(|s| *s == set) else {
        let what = format!("texture coordinate sets {} and {}, and {set}: two can be read at once", sets[0], sets[1]);
        return Err(Fault::new(Kind::Unsupported, what));
    };
    let (index, _, transform) = used;
    let transform = transform.as_ref().map_or(Mat3::IDENTITY, matrix);
    if !transform.is_finite() {
        return Err(Fault::invalid("its texture transform is not finite"));
    }
    match store.get(index) {
        Ok(Some(texture)) => Ok(Found::Texture(TextureRef { texture, set: place as u32, transform })),
        Ok(None) => Ok(Found::Nothing),
        Err(fault) if matches!(fault.kind, Kind::TooLarge | Kind::Unsupported) => Err(fault),
        Err(fault) => Ok(Found::Missing(fault.what)),
    }
}

/// Scale, then rotation, then offset (KHR_texture_transform). v points down, so the rotation that looks
/// counter-clockwise has the signs of a clockwise one; the extension's GLSL listing misses this (KhronosGroup/glTF#1563),
/// its text and other implementations do not.
fn matrix(t: &TextureTransform) -> Mat3 {
    Mat3::from_translation(Vec2::from(t.offset.0))
        * Mat3::from_rotation_z(-t.rotation.0)
        * Mat3::from_scale(Vec2::from(t.scale.0))
}

//! Materials on the GPU: constants, textures, and the variant of a shader that a material needs.

use super::geometry::Streams;
use crate::scene::{Material, Scene, Texture, TextureRef, Wrap};
use crate::vk::{Binding, DescriptorSet, Device, Image, Result, Specialisation, gpu_types};
use ash::vk;
use glam::Mat3;
use std::collections::HashMap;
use std::sync::Arc;

/// What a material needs of the shaders that evaluate it; a pipeline is built for each variant that the scene has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Base colour, normal and emission textures.
    pub textures: [bool; 3],
    /// Alpha mask.
    pub masked: bool,
}

impl Variant {
    /// What `material` needs.
    pub fn of(material: &Material) -> Self {
        let textures = references(material).map(|t| t.is_some());
        Self { textures, masked: material.alpha_cutoff.is_some() }
    }

    /// Whether any texture is read.
    pub fn is_textured(&self) -> bool {
        self.textures.contains(&true)
    }

    /// Constants 0–7 of `glsl/inc/material_constants.glsl`, then `rest`.
    pub fn constants(&self, streams: Streams, rest: &[u32]) -> Specialisation {
        let own = [self.textures[0], self.textures[1], self.textures[2], self.masked]
            .into_iter()
            .chain([streams.uvs[0], streams.uvs[1], streams.tangents, streams.colors])
            .map(u32::from);
        Specialisation(own.chain(rest.iter().copied()).collect())
    }
}

fn references(material: &Material) -> [Option<TextureRef>; 3] {
    [material.base_texture, material.normal_texture, material.emission_texture]
}

/// Constants of a material as the shaders read them.
pub(super) fn gpu_material(material: &Material) -> gpu_types::Material {
    let [base, normal, emission] = references(material).map(rows);
    let c = material.base_color;
    let e = material.emission;
    gpu_types::Material {
        base_color: c.to_array(),
        emission: [e.x, e.y, e.z, material.normal_scale],
        base_uv: base,
        normal_uv: normal,
        emission_uv: emission,
        alpha: [material.alpha_cutoff.unwrap_or(0.0), f32::from(u8::from(material.double_sided)), 0.0, 0.0],
    }
}

fn rows(texture: Option<TextureRef>) -> [[f32; 4]; 2] {
    let transform = texture.map_or(Mat3::IDENTITY, |t| t.transform);
    let set = texture.map_or(0.0, |t| t.set as f32);
    let row = |index: usize| transform.row(index).to_array();
    let ([a, b, c], [d, e, f]) = (row(0), row(1));
    [[a, b, c, set], [d, e, f, 0.0]]
}

/// Texture images, samplers, and a descriptor set for each textured material. Built only for scenes with textures.
pub struct Textures {
    /// Layout of the sets.
    pub layout: crate::vk::SetLayout,
    sets: HashMap<u32, DescriptorSet>,
    _images: HashMap<(u32, bool), Image>,
    _samplers: Samplers,
}

impl Textures {
    /// Uploads the textures that materials in use read; `None` if there are none.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Option<Self>> {
        let used: Vec<u32> = scene
            .parts
            .iter()
            .map(|part| part.material)
            .filter(|m| Variant::of(&scene.materials[*m as usize]).is_textured())
            .collect();
        if used.is_empty() {
            return Ok(None);
        }
        let kinds = [vk::DescriptorType::COMBINED_IMAGE_SAMPLER; 3];
        let layout = crate::vk::SetLayout::new(device, &kinds)?;
        let mut samplers = Samplers { by_mode: HashMap::new(), device: device.clone() };
        let mut images = HashMap::new();
        for material in &used {
            for (slot, reference) in references(&scene.materials[*material as usize]).into_iter().enumerate() {
                let Some(reference) = reference else { continue };
                let srgb = slot != 1;
                if let std::collections::hash_map::Entry::Vacant(entry) = images.entry((reference.texture, srgb)) {
                    entry.insert(upload(device, &scene.textures[reference.texture as usize], srgb)?);
                }
                samplers.add(&scene.textures[reference.texture as usize])?;
            }
        }
        let mut sets = HashMap::new();
        for material in used {
            let set = material_set(scene, &scene.materials[material as usize], &layout, &images, &samplers)?;
            sets.insert(material, set);
        }
        Ok(Some(Self { layout, sets, _images: images, _samplers: samplers }))
    }

    /// The set of a textured material.
    pub fn set(&self, material: u32) -> &DescriptorSet {
        &self.sets[&material]
    }
}

fn upload(device: &Arc<Device>, texture: &Texture, srgb: bool) -> Result<Image> {
    Image::with_texels(device, "textures", [texture.width, texture.height], &texture.rgba, srgb)
}

fn material_set(
    scene: &Scene,
    material: &Material,
    layout: &crate::vk::SetLayout,
    images: &HashMap<(u32, bool), Image>,
    samplers: &Samplers,
) -> Result<DescriptorSet> {
    let slots = references(material);
    let binding = |slot: usize| {
        // A texture that the material lacks is never read: bind one that it has.
        let (slot, reference) = match slots[slot] {
            Some(reference) => (slot, reference),
            None => slots.iter().enumerate().find_map(|(i, t)| t.map(|t| (i, t))).expect("the material is textured"),
        };
        let image = &images[&(reference.texture, slot != 1)];
        Binding::Sampled(image, samplers.get(&scene.textures[reference.texture as usize]))
    };
    DescriptorSet::new(layout, &[binding(0), binding(1), binding(2)])
}

type Mode = ([Wrap; 2], bool);

struct Samplers {
    by_mode: HashMap<Mode, crate::vk::Sampler>,
    device: Arc<Device>,
}

impl Samplers {
    fn add(&mut self, texture: &Texture) -> Result<()> {
        let mode = (texture.wrap, texture.nearest);
        if let std::collections::hash_map::Entry::Vacant(entry) = self.by_mode.entry(mode) {
            entry.insert(crate::vk::Sampler::new(&self.device, texture.wrap.map(address_mode), texture.nearest)?);
        }
        Ok(())
    }

    fn get(&self, texture: &Texture) -> vk::Sampler {
        self.by_mode[&(texture.wrap, texture.nearest)].raw()
    }
}

fn address_mode(wrap: Wrap) -> vk::SamplerAddressMode {
    match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::MirroredRepeat => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    }
}

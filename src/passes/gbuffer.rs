//! The G-buffer: one MRT pass over the visible triangles at pixel centres.

use super::fan_on;
use super::geometry::Geometry;
use super::material::{Textures, Variant};
use crate::scene::Scene;
use crate::vk::{
    Attachment, Commands, Device, Framebuffer, GraphicsDesc, GraphicsPipeline, Image, ImageDesc, Load, PipelineLayout,
    RenderPass, RenderPassDesc, Result, VertexInput, spirv,
};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};
use std::collections::HashMap;
use std::sync::Arc;

/// What the pass draws from.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    world_to_clip: [f32; 16],
    eye: [f32; 4],
    material: u32,
    pad: [u32; 3],
}

/// Attachments that the rest of the frame reads.
pub struct Targets {
    /// Position; w: 0 nothing, 1 reflects, 2 emits.
    pub position: Image,
    /// Shading and geometric normal, octahedral.
    pub normals: Image,
    /// Albedo.
    pub albedo: Image,
    /// Emitted radiance, in scenes that emit.
    pub emission: Option<Image>,
    depth: Image,
}

/// The pass.
pub struct GBuffer {
    /// What it draws into.
    pub targets: Targets,
    framebuffer: Framebuffer,
    pass: RenderPass,
    pipelines: HashMap<Variant, GraphicsPipeline>,
    plain: Arc<PipelineLayout>,
    textured: Option<Arc<PipelineLayout>>,
    /// Triangles that one of the scene's is drawn as.
    fan: u32,
}

impl GBuffer {
    /// Builds targets of `size` pixels, and a pipeline for each variant of material in use.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        geometry: &Geometry,
        textures: Option<&Textures>,
        size: [u32; 2],
        emission: bool,
    ) -> Result<Self> {
        let formats = [
            vk::Format::R32G32B32A32_SFLOAT,
            vk::Format::R32G32_UINT,
            vk::Format::R16G16B16A16_SFLOAT,
            vk::Format::R32G32B32A32_SFLOAT,
        ];
        let colors = if emission { 4 } else { 3 };
        let mut attachments: Vec<_> = formats[..colors]
            .iter()
            .map(|format| Attachment { format: *format, load: Load::Clear, store: true })
            .collect();
        attachments.push(Attachment { format: vk::Format::D32_SFLOAT, load: Load::Clear, store: false });
        let pass =
            RenderPass::new(device, &RenderPassDesc { name: "gbuffer", attachments: &attachments, view_masks: &[0] })?;
        let targets = Targets::new(device, &formats, size, emission)?;
        let framebuffer = Framebuffer::new(&pass, &targets.in_order())?;

        let push = size_of::<Push>() as u32;
        let plain = PipelineLayout::new(device, &[&geometry.set_layout], push)?;
        let textured =
            textures.map(|t| PipelineLayout::new(device, &[&geometry.set_layout, &t.layout], push)).transpose()?;
        let mut this =
            Self { targets, framebuffer, pass, pipelines: HashMap::new(), plain, textured, fan: fan_on(device) };
        for part in &geometry.parts {
            let variant = Variant::of(&scene.materials[part.material as usize]);
            if !this.pipelines.contains_key(&variant) {
                let pipeline = this.pipeline(variant, geometry, emission)?;
                this.pipelines.insert(variant, pipeline);
            }
        }
        Ok(this)
    }

    fn pipeline(&self, variant: Variant, geometry: &Geometry, emission: bool) -> Result<GraphicsPipeline> {
        let (layout, vertex) = match (&self.textured, variant.is_textured()) {
            (Some(layout), true) => (layout, spirv!("gbuffer", "textured.vert")),
            _ => (&self.plain, spirv!("gbuffer", "plain.vert")),
        };
        let fragment = match (variant.is_textured(), emission) {
            (true, true) => spirv!("gbuffer", "textured_emission.frag"),
            (true, false) => spirv!("gbuffer", "textured.frag"),
            (false, true) => spirv!("gbuffer", "plain_emission.frag"),
            (false, false) => spirv!("gbuffer", "plain.frag"),
        };
        let desc = GraphicsDesc {
            name: "gbuffer",
            vertex,
            fragment: Some(fragment),
            constants: variant.constants(geometry.streams, &[u32::from(self.fan > 1)]).into(),
            input: VertexInput::None,
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            additive: false,
        };
        GraphicsPipeline::new(layout, &self.pass, 0, &desc)
    }

    /// Draws all triangles, a draw a material. `eye`: position and 1, or the direction to the viewer and 0.
    pub fn record(
        &self,
        commands: &Commands,
        scene: &Scene,
        geometry: &Geometry,
        textures: Option<&Textures>,
        world_to_clip: Mat4,
        eye: Vec4,
    ) {
        self.pass.begin(commands, &self.framebuffer);
        for part in &geometry.parts {
            let variant = Variant::of(&scene.materials[part.material as usize]);
            let pipeline = &self.pipelines[&variant];
            match textures.filter(|_| variant.is_textured()) {
                Some(textures) => pipeline.bind(commands, &[&geometry.set, textures.set(part.material)]),
                None => pipeline.bind(commands, &[&geometry.set]),
            }
            let push = Push {
                world_to_clip: world_to_clip.to_cols_array(),
                eye: eye.to_array(),
                material: part.material,
                pad: [0; 3],
            };
            pipeline.layout.push(commands, &push);
            let corners = 3 * self.fan;
            pipeline.draw_from(commands, part.first_triangle * corners, part.triangle_count * corners);
        }
        self.pass.end(commands);
    }
}

impl Targets {
    fn new(device: &Arc<Device>, formats: &[vk::Format; 4], size: [u32; 2], emission: bool) -> Result<Self> {
        let color = |format| {
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
            Image::new(device, ImageDesc { used_for: "G-buffer", format, size, layers: None, usage })
        };
        let depth = ImageDesc {
            used_for: "G-buffer",
            format: vk::Format::D32_SFLOAT,
            size,
            layers: None,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        };
        Ok(Self {
            position: color(formats[0])?,
            normals: color(formats[1])?,
            albedo: color(formats[2])?,
            emission: emission.then(|| color(formats[3])).transpose()?,
            depth: Image::new(device, depth)?,
        })
    }

    fn in_order(&self) -> Vec<&Image> {
        let mut images = vec![&self.position, &self.normals, &self.albedo];
        images.extend(&self.emission);
        images.push(&self.depth);
        images
    }
}

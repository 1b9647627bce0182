//! Pipelines of a capture: one for opaque triangles, one for masked ones with a texture and one for those without.

use super::{CaptureDesc, FramesBy, Push, Views};
use crate::passes::geometry::{CLUSTER, DrawRange, Geometry};
use crate::passes::material::{Textures, Variant};
use crate::scene::Scene;
use crate::vk::{
    Device, GraphicsDesc, GraphicsPipeline, PipelineLayout, RenderPass, Result, SetLayout, Shader, Specialisation,
    VertexInput, spirv,
};
use ash::vk;
use std::sync::Arc;

/// What draw ranges share a pipeline by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Opaque triangles.
    Opaque,
    /// Masked ones by their vertices' alpha alone.
    Masked,
    /// Masked ones by the texture of their base colour.
    Textured,
}

impl Kind {
    pub(super) fn of(scene: &Scene, textures: Option<&Textures>, range: &DrawRange) -> Self {
        match range.masked.map(|material| &scene.materials[material as usize]) {
            None => Self::Opaque,
            Some(material) if textures.is_some() && material.base_texture.is_some() => Self::Textured,
            Some(_) => Self::Masked,
        }
    }
}

/// Builds the pipelines.
pub(super) struct PipelineBuilder<'a> {
    pub(super) device: &'a Arc<Device>,
    pub(super) geometry: &'a Geometry,
    pub(super) textures: Option<&'a Textures>,
    pub(super) desc: &'a CaptureDesc,
    pub(super) fan: u32,
    pub(super) pass: &'a RenderPass,
    pub(super) frames: &'a SetLayout,
}

impl PipelineBuilder<'_> {
    pub(super) fn pipeline(&self, kind: Kind) -> Result<GraphicsPipeline> {
        match kind {
            Kind::Opaque => self.opaque(),
            Kind::Masked => self.masked(None),
            Kind::Textured => self.masked(self.textures),
        }
    }

    /// A vertex shader, by what frames find their tiles.
    fn vertices<'b>(&self, by_viewports: &'b Shader, by_instances: &'b Shader) -> &'b Shader {
        match self.desc.frames {
            FramesBy::Viewports => by_viewports,
            FramesBy::Instances => by_instances,
        }
    }

    fn opaque(&self) -> Result<GraphicsPipeline> {
        let flat = spirv!("capture", "identity_flat.frag");
        let fans = [spirv!("capture", "capture_fan.vert"), spirv!("capture", "capture_fan_instances.vert")];
        let shared = [spirv!("capture", "capture.vert"), spirv!("capture", "capture_instances.vert")];
        let unshared = [spirv!("capture", "capture_flat.vert"), spirv!("capture", "capture_flat_instances.vert")];
        let ([viewports, instances], fragment, input) = match (self.fan > 1, self.device.capabilities.primitive_id) {
            (true, _) => (fans, flat, VertexInput::None),
            (_, true) => (shared, spirv!("capture", "identity.frag"), VertexInput::Positions),
            (_, false) => (unshared, flat, VertexInput::Positions),
        };
        let of_scene = (self.fan > 1).then_some(&self.geometry.set_layout);
        let sets: Vec<_> = of_scene.into_iter().chain([self.frames]).collect();
        let shaders = (self.vertices(viewports, instances), fragment);
        self.made(&sets, shaders, input, Specialisation(self.constants().to_vec()))
    }

    fn masked(&self, textures: Option<&Textures>) -> Result<GraphicsPipeline> {
        let sets: Vec<_> = std::iter::once(&self.geometry.set_layout)
            .chain(textures.map(|textures| &textures.layout))
            .chain([self.frames])
            .collect();
        let shaders = match textures {
            Some(_) => (
                self.vertices(
                    spirv!("capture", "masked_textured.vert"),
                    spirv!("capture", "masked_textured_instances.vert"),
                ),
                spirv!("capture", "masked_textured.frag"),
            ),
            None => (
                self.vertices(spirv!("capture", "masked_plain.vert"), spirv!("capture", "masked_plain_instances.vert")),
                spirv!("capture", "masked_plain.frag"),
            ),
        };
        // The alpha test reads no other texture.
        let variant = Variant { textures: [textures.is_some(), false, false], masked: true };
        let constants = variant.constants(self.geometry.streams, &self.constants());
        self.made(&sets, shaders, VertexInput::None, constants)
    }

    /// Those of `glsl/capture/frames.glsl`. Only views that reach below a horizon are cut there; what a plane sees below it is
    /// left out when integrated.
    fn constants(&self) -> [u32; 4] {
        let has_horizon = matches!(self.desc.views, Views::Hemicube | Views::Hemisphere);
        let cluster = if self.desc.culled { CLUSTER } else { 0 };
        [self.desc.views.code(), u32::from(has_horizon), u32::from(self.fan > 1), cluster]
    }

    fn made(
        &self,
        sets: &[&SetLayout],
        (vertex, fragment): (&Shader, &Shader),
        input: VertexInput,
        constants: Specialisation,
    ) -> Result<GraphicsPipeline> {
        let layout = PipelineLayout::new(self.device, sets, size_of::<Push>() as u32)?;
        let desc = GraphicsDesc {
            name: self.desc.name,
            vertex,
            fragment: Some(fragment),
            constants: constants.into(),
            input,
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            additive: false,
        };
        GraphicsPipeline::new(&layout, self.pass, 0, &desc)
    }
}

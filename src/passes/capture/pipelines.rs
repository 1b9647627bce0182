//! Pipelines of a capture: opaque triangles by identity or depth alone, masked ones a material each.

use super::{CaptureDesc, RangePipelines, Views};
use crate::passes::geometry::{DrawRange, Geometry};
use crate::passes::material::{Textures, Variant};
use crate::scene::Scene;
use crate::vk::{
    Device, GraphicsDesc, GraphicsPipeline, PipelineLayout, RenderPass, Result, SetLayout, Shader, Specialisation,
    VertexInput, spirv,
};
use ash::vk;
use std::sync::Arc;

/// Builds the pipelines of the draw ranges.
pub(super) struct PipelineBuilder<'a> {
    pub(super) device: &'a Arc<Device>,
    pub(super) scene: &'a Scene,
    pub(super) geometry: &'a Geometry,
    pub(super) textures: Option<&'a Textures>,
    pub(super) desc: &'a CaptureDesc,
    pub(super) fan: u32,
    pub(super) pass: &'a RenderPass,
    pub(super) frames: &'a SetLayout,
}

impl PipelineBuilder<'_> {
    /// Those of one range, a subpass each.
    pub(super) fn range(&self, range: &DrawRange, subpasses: u32) -> Result<RangePipelines> {
        let (by_subpass, textured) = match range.masked {
            None => (self.opaque(subpasses)?, false),
            Some(material) => self.masked(material, subpasses)?,
        };
        Ok(RangePipelines { range: range.clone(), by_subpass, textured })
    }

    /// Only views that reach below a horizon pay for its clip plane; what a plane sees below it is left out when
    /// integrated.
    fn has_horizon(&self) -> u32 {
        u32::from(matches!(self.desc.views, Views::Hemicube | Views::Hemisphere))
    }

    fn opaque(&self, subpasses: u32) -> Result<Vec<GraphicsPipeline>> {
        let constants = |rest: &[u32]| Specialisation(rest.to_vec());
        if self.fan > 1 {
            let layout = PipelineLayout::new(self.device, &[&self.geometry.set_layout, self.frames], 8)?;
            let fragment = self.desc.identity.then_some(spirv!("capture", "identity_flat.frag"));
            let vertex = spirv!("capture", "capture_fan.vert");
            return self.pipelines(&layout, subpasses, vertex, fragment, VertexInput::None, constants);
        }
        let layout = PipelineLayout::new(self.device, &[self.frames], 8)?;
        let (vertex, fragment) = match (self.desc.identity, self.device.capabilities.primitive_id) {
            (false, _) => (spirv!("capture", "depth.vert"), None),
            (true, true) => (spirv!("capture", "capture.vert"), Some(spirv!("capture", "identity.frag"))),
            (true, false) => (spirv!("capture", "capture_flat.vert"), Some(spirv!("capture", "identity_flat.frag"))),
        };
        self.pipelines(&layout, subpasses, vertex, fragment, VertexInput::Positions, constants)
    }

    fn masked(&self, material: u32, subpasses: u32) -> Result<(Vec<GraphicsPipeline>, bool)> {
        let variant = Variant::of(&self.scene.materials[material as usize]);
        let textures = self.textures.filter(|_| variant.is_textured());
        let sets = match textures {
            Some(t) => vec![&self.geometry.set_layout, &t.layout, self.frames],
            None => vec![&self.geometry.set_layout, self.frames],
        };
        let (vertex, fragment) = match (self.desc.identity, textures.is_some()) {
            (true, true) => {
                (spirv!("capture", "masked_identity_textured.vert"), spirv!("capture", "masked_identity_textured.frag"))
            }
            (true, false) => {
                (spirv!("capture", "masked_identity_plain.vert"), spirv!("capture", "masked_identity_plain.frag"))
            }
            (false, true) => {
                (spirv!("capture", "masked_depth_textured.vert"), spirv!("capture", "masked_depth_textured.frag"))
            }
            (false, false) => {
                (spirv!("capture", "masked_depth_plain.vert"), spirv!("capture", "masked_depth_plain.frag"))
            }
        };
        let layout = PipelineLayout::new(self.device, &sets, 8)?;
        let constants = |rest: &[u32]| variant.constants(self.geometry.streams, rest);
        let pipelines = self.pipelines(&layout, subpasses, vertex, Some(fragment), VertexInput::None, constants)?;
        Ok((pipelines, textures.is_some()))
    }

    fn pipelines(
        &self,
        layout: &Arc<PipelineLayout>,
        subpasses: u32,
        vertex: &Shader,
        fragment: Option<&Shader>,
        input: VertexInput,
        constants: impl Fn(&[u32]) -> Specialisation,
    ) -> Result<Vec<GraphicsPipeline>> {
        let desc = GraphicsDesc {
            name: self.desc.name,
            vertex,
            fragment,
            constants: constants(&[self.desc.views.code(), self.has_horizon(), u32::from(self.fan > 1)]).into(),
            input,
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            additive: false,
        };
        (0..subpasses).map(|subpass| GraphicsPipeline::new(layout, self.pass, subpass, &desc)).collect()
    }
}

//! Direct irradiance of each pixel by a batch of shadow-mapped light samples.

use super::gbuffer::Targets;
use super::groups;
use super::shadow::{Lift, Shadow};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Image, ImageDesc, PipelineLayout, Result,
    SetLayout, Specialisation, spirv,
};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    width: u32,
    height: u32,
    count: u32,
    lift: f32,
    ball: [f32; 4],
}

/// The image of direct irradiance that the pass adds into, four floats a pixel; an image, so that no limit of buffers holds
/// for its size.
pub fn direct_image(device: &Arc<Device>, size: [u32; 2]) -> Result<Image> {
    let (format, usage) = (vk::Format::R32G32B32A32_SFLOAT, vk::ImageUsageFlags::STORAGE);
    Image::new(device, ImageDesc { used_for: "direct irradiance", format, size, layers: None, usage })
}

/// The pass for one kind of light.
pub struct PixelLight {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    size: [u32; 2],
    _layout: SetLayout,
}

impl PixelLight {
    /// Adds into `direct` ([`direct_image`]). With `faces`, the samples of each emissive triangle stand together.
    pub fn new(
        device: &Arc<Device>,
        gbuffer: &Targets,
        shadow: &Shadow<'_>,
        faces: Option<&Buffer>,
        direct: &Image,
    ) -> Result<Self> {
        let own = [
            Binding::Texels(&gbuffer.position),
            Binding::Texels(&gbuffer.normals),
            Binding::Stored(direct),
            Binding::Storage(faces.unwrap_or(shadow.lights)),
        ];
        let bindings: Vec<_> = shadow.bindings().into_iter().chain(own).collect();
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let has_faces = u32::from(faces.is_some());
        let constants = Specialisation(shadow.constants().into_iter().chain([has_faces]).collect());
        let code = spirv!("pixel_light", "pixel_light.comp");
        let pipeline = ComputePipeline::new("pixel_light", &pipeline_layout, code, &constants)?;
        Ok(Self { pipeline, set, size: gbuffer.position.desc.size, _layout: layout })
    }

    /// Adds the light of the first `count` faces, or samples where there are no faces.
    pub fn record(&self, commands: &Commands, count: u32, lift: Lift) {
        let [width, height] = self.size;
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &Push { width, height, count, lift: lift.share, ball: lift.ball });
        self.pipeline.dispatch(commands, groups(width * height, 64));
    }
}

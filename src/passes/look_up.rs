//! Looks up what the texels of captures by render passes see, for [`super::project`]; captures in compute have it already.

use super::capture::Capture;
use super::gathered::Gathered;
use super::geometry::Geometry;
use super::integrate::{scene_bindings, texel_on_device};
use crate::math::capture::{Projection, Table};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    texel_count: u32,
    tile_size: u32,
    columns: u32,
}

/// The pass.
pub struct LookUp {
    pipeline: ComputePipeline,
    sets: [DescriptorSet; 2],
    push: Push,
    _texels: Buffer,
    _layouts: [SetLayout; 2],
}

impl LookUp {
    /// Looks up in `geometry` and the `sky` what `capture`, whose texels are those of `table`, shows; writes it to `gathered`.
    pub fn new(
        device: &Arc<Device>,
        geometry: &Geometry,
        capture: &Capture,
        (projection, table): (Projection, &Table),
        gathered: &Gathered,
        sky: Option<&Buffer>,
    ) -> Result<Self> {
        let texels: Vec<_> = table.texels.iter().map(texel_on_device).collect();
        let texels = Buffer::with_data(device, "capture tables", &texels)?;
        let own = [&capture.frames, &texels, gathered.buffer()].map(Binding::Storage);
        let of_scene = scene_bindings(geometry, capture, None, sky);
        let layouts = [SetLayout::of(device, &own)?, SetLayout::of(device, &of_scene)?];
        let sets = [DescriptorSet::new(&layouts[0], &own)?, DescriptorSet::new(&layouts[1], &of_scene)?];
        let layout = PipelineLayout::new(device, &[&layouts[0], &layouts[1]], size_of::<Push>() as u32)?;
        let (has_sky, has_translation) = (sky.is_some(), gathered.kinds.planes);
        let is_curved = projection == Projection::Hemisphere;
        let constants = Specialisation([has_sky, has_translation, is_curved].map(u32::from).to_vec());
        let pipeline = ComputePipeline::new("look_up", &layout, spirv!("look_up", "look_up.comp"), &constants)?;
        let push =
            Push { texel_count: table.texels.len() as u32, tile_size: capture.desc.size, columns: capture.columns };
        Ok(Self { pipeline, sets, push, _texels: texels, _layouts: layouts })
    }

    /// Looks up the first `count` captures.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.sets[0], &self.sets[1]]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count, 1, 1]);
    }
}

//! Clamps the zones of new records by those of their neighbours.

use super::gbuffer::Targets;
use super::groups;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, barrier, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    first: u32,
    count: u32,
    width: u32,
    tile: u32,
    tiles: [u32; 2],
    min_radius: f32,
}

/// Limits of a zone's radius, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Smallest radius, which clamping keeps.
    pub min: f32,
    /// Largest radius: neighbours beyond it change nothing.
    pub max: f32,
}

/// The pass: two dispatches of one shader.
pub struct ClampRecords {
    phases: [ComputePipeline; 2],
    set: DescriptorSet,
    push: Push,
    heads: Buffer,
    _nodes: Buffer,
    _layout: SetLayout,
}

impl ClampRecords {
    /// Clamps `records`, whose pixels are in `found`; with `has_sky` each has two payloads.
    pub fn new(
        device: &Arc<Device>,
        gbuffer: &Targets,
        found: &Buffer,
        (records, payloads): (&Buffer, &Buffer),
        has_sky: bool,
        reach: Reach,
    ) -> Result<Self> {
        let [width, height] = gbuffer.position.desc.size;
        let tile = (reach.max.ceil() as u32).clamp(1, width.max(height));
        let tiles = [width.div_ceil(tile), height.div_ceil(tile)];
        let heads = Buffer::new(device, "neighbours", u64::from(tiles[0] * tiles[1]) * 4, Memory::Device)?;
        let nodes = Buffer::new(device, "neighbours", u64::from(width) * u64::from(height) * 8, Memory::Device)?;
        let bindings = [
            Binding::Texels(&gbuffer.position),
            Binding::Texels(&gbuffer.normals),
            Binding::Storage(found),
            Binding::Storage(payloads),
            Binding::Storage(records),
            Binding::Storage(&heads),
            Binding::Storage(&nodes),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let phase = |index| {
            let code = spirv!("clamp_records", "clamp_records.comp");
            let constants = Specialisation(vec![index, u32::from(has_sky)]);
            ComputePipeline::new("clamp_records", &pipeline_layout, code, &constants)
        };
        let push = Push { first: 0, count: 0, width, tile, tiles, min_radius: reach.min };
        Ok(Self { phases: [phase(0)?, phase(1)?], set, push, heads, _nodes: nodes, _layout: layout })
    }

    /// Forgets all records.
    pub fn record_clear(&self, commands: &Commands) {
        commands.fill(&self.heads, 0);
    }

    /// Clamps `count` records, those of the pixels from the `first` of the found ones on.
    pub fn record(&self, commands: &Commands, first: u32, count: u32) {
        let push = Push { first, count, ..self.push };
        for phase in &self.phases {
            phase.bind(commands, &[&self.set]);
            phase.layout.push(commands, &push);
            phase.dispatch(commands, groups(count, 64));
            barrier::dispatches(commands);
        }
    }
}

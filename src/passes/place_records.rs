//! Puts records and their capture frames on chosen pixels.

use super::gbuffer::Targets;
use super::groups;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Push constants of the pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Placement {
    /// First of the found pixels.
    pub first: u32,
    /// Number of records.
    pub count: u32,
    /// Image width.
    pub width: u32,
    /// Seed of the hemicubes' turn.
    pub seed: u32,
    /// Near distance of the captures.
    pub near: f32,
    /// How far a capture stands off its surface, relative to the size of what is near.
    pub lift: f32,
    /// Scale of a capture's axes: 1/half width of a plane.
    pub scale: f32,
    /// Edge of the cubes of space in which captures have one turn each.
    pub grain: f32,
    /// Centre and radius of the scene's core.
    pub core: [f32; 4],
}

/// The pass.
pub struct PlaceRecords {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    _layout: SetLayout,
}

impl PlaceRecords {
    /// Takes pixels from `found`, writes `frames` and `records`.
    pub fn new(
        device: &Arc<Device>,
        gbuffer: &Targets,
        found: &Buffer,
        frames: &Buffer,
        records: &Buffer,
    ) -> Result<Self> {
        let bindings = [
            Binding::Texels(&gbuffer.position),
            Binding::Texels(&gbuffer.normals),
            Binding::Storage(found),
            Binding::Storage(frames),
            Binding::Storage(records),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Placement>() as u32)?;
        let code = spirv!("place_records", "place_records.comp");
        let pipeline = ComputePipeline::new("place_records", &pipeline_layout, code, Specialisation::default())?;
        Ok(Self { pipeline, set, _layout: layout })
    }

    /// Places `placement.count` records.
    pub fn record(&self, commands: &Commands, placement: Placement) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &placement);
        self.pipeline.dispatch(commands, groups(placement.count, 64));
    }
}

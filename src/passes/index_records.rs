//! Sorts the entries of kept records by place and bounds groups of them, so that neighbours are found.

use super::groups;
use crate::vk::gpu_types::Entry;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, barrier, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Entries of a group (`GROUP` in `glsl/inc/index.glsl`).
pub(super) const GROUP: u32 = 64;
const THREADS: u32 = 128;
const CELLS: u64 = 1 << 15;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    count: u32,
}

/// Entries in the order of the store and sorted by place, and boxes about groups of the latter.
pub struct Index {
    /// In the order of the store.
    pub entries: Buffer,
    /// Sorted by place.
    pub sorted: Buffer,
    /// Boxes.
    pub groups: Buffer,
    cells: Buffer,
    /// Entries that fit in.
    pub capacity: u32,
}

impl Index {
    /// Room for `capacity` entries.
    pub fn new(device: &Arc<Device>, capacity: u32) -> Result<Self> {
        let buffer = |bytes: u64| Buffer::new(device, "record index", bytes, Memory::Device);
        let entries = u64::from(capacity) * size_of::<Entry>() as u64;
        Ok(Self {
            entries: buffer(entries)?,
            sorted: buffer(entries)?,
            groups: buffer(u64::from(capacity.div_ceil(GROUP)) * 32)?,
            cells: buffer(32 + CELLS * 4)?,
            capacity,
        })
    }

    fn bindings(&self) -> [Binding<'_>; 4] {
        [&self.entries, &self.sorted, &self.groups, &self.cells].map(Binding::Storage)
    }
}

/// The pass: five dispatches of one shader.
pub struct IndexRecords {
    phases: [ComputePipeline; 5],
    layout: SetLayout,
}

impl IndexRecords {
    /// Builds the pass; it needs an `index` to know what it binds.
    pub fn new(device: &Arc<Device>, index: &Index) -> Result<Self> {
        let layout = SetLayout::of(device, &index.bindings())?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let phase = |phase| {
            let code = spirv!("index_records", "index_records.comp");
            ComputePipeline::new("index_records", &pipeline_layout, code, Specialisation(vec![phase]))
        };
        Ok(Self { phases: [phase(0)?, phase(1)?, phase(2)?, phase(3)?, phase(4)?], layout })
    }

    /// The buffers of `index`.
    pub fn set(&self, index: &Index) -> Result<DescriptorSet> {
        DescriptorSet::new(&self.layout, &index.bindings())
    }

    /// Indexes the first `count` entries, at least one.
    pub fn record(&self, commands: &Commands, index: &Index, set: &DescriptorSet, count: u32) {
        commands.fill(&index.cells, 0);
        barrier::full(commands);
        let each = count.div_ceil(THREADS);
        let sizes = [1, each, 1, each, count.div_ceil(GROUP).div_ceil(THREADS)];
        for (phase, size) in self.phases.iter().zip(sizes) {
            phase.bind(commands, &[set]);
            phase.layout.push(commands, &Push { count });
            phase.dispatch(commands, groups(size, 1));
            barrier::dispatches(commands);
        }
    }
}

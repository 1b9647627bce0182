//! Radii of the zones of kept records in a view: by their R, their neighbours and the view's limits in pixels.

use super::groups;
use super::index_records::{GROUP, Index};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, PipelineLayout, Result, SetLayout,
    Specialisation, barrier, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;
use std::sync::Arc;

/// Groups that a dispatch looks at: in the worst case a loop goes over each of them and over each of their entries, and no device
/// ends one of so few rounds (llvmpipe does at 65,535).
const GROUPS_AT_ONCE: u32 = 512;

/// Limits of a view.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Reach {
    /// Ward's a: zones have the radius a·R, where nothing limits them.
    pub accuracy: f32,
    /// Smallest radius in pixels, which clamping keeps.
    pub min: f32,
    /// Largest radius in pixels.
    pub max: f32,
}

/// The camera, as far as the size of a pixel on a surface depends on it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Footprint {
    /// Eye; w: 0 for parallel views.
    pub eye: [f32; 4],
    /// Axis of the camera; w: footprint of a pixel at distance 1.
    pub forward: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    footprint: Footprint,
    first: u32,
    count: u32,
    records: u32,
    group: u32,
    end: u32,
    is_last: u32,
    is_new: u32,
    reach: Reach,
}

/// Which records a view asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whose {
    /// Records of this view, whose reach is yet to be clamped by that of so many indexed ones.
    New {
        /// Records in the index, the new ones among them.
        indexed: u32,
    },
    /// Records of earlier views.
    Old,
}

/// The pass.
pub struct ClampRecords {
    pipeline: ComputePipeline,
    layout: SetLayout,
    clamped: bool,
}

impl ClampRecords {
    /// With `clamped` neighbours count, else R and the limits alone.
    pub fn new(device: &Arc<Device>, (index, zones): (&Index, &Buffer), clamped: bool) -> Result<Self> {
        let layout = SetLayout::of(device, &bindings(index, zones))?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let code = spirv!("clamp_records", "clamp_records.comp");
        let constants = Specialisation(vec![u32::from(clamped)]);
        let pipeline = ComputePipeline::new("clamp_records", &pipeline_layout, code, constants)?;
        Ok(Self { pipeline, layout, clamped })
    }

    /// The buffers of `index`, and where radii go.
    pub fn set(&self, index: &Index, zones: &Buffer) -> Result<DescriptorSet> {
        DescriptorSet::new(&self.layout, &bindings(index, zones))
    }

    /// Radii of a range of records.
    pub fn record(
        &self,
        commands: &Commands,
        set: &DescriptorSet,
        (view, reach): (&Footprint, Reach),
        of: Range<u32>,
        whose: Whose,
    ) {
        self.pipeline.bind(commands, &[set]);
        let (is_new, records) = match whose {
            Whose::New { indexed } => (1, indexed),
            Whose::Old => (0, 0),
        };
        let groups_of_all = if self.clamped { records.div_ceil(GROUP).max(1) } else { 1 };
        for group in (0..groups_of_all).step_by(GROUPS_AT_ONCE as usize) {
            let end = (group + GROUPS_AT_ONCE).min(groups_of_all);
            let push = Push {
                footprint: *view,
                first: of.start,
                count: of.len() as u32,
                records,
                group,
                end,
                is_last: u32::from(end == groups_of_all),
                is_new,
                reach,
            };
            self.pipeline.layout.push(commands, &push);
            self.pipeline.dispatch(commands, groups(push.count, 64));
            barrier::dispatches(commands);
        }
    }
}

fn bindings<'a>(index: &'a Index, zones: &'a Buffer) -> [Binding<'a>; 4] {
    [&index.entries, &index.sorted, &index.groups, zones].map(Binding::Storage)
}

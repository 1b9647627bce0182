//! Culling: which clusters each view of each frame sees, as indirect draws.

use super::counter::Counter;
use super::geometry::{CLUSTER, Geometry};
use super::groups;
use super::views::Views;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

const DRAW_BYTES: u64 = 20;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    frame_count: u32,
    range_count: u32,
    cluster_count: u32,
    cluster_size: u32,
}

/// The pass.
pub struct Cull {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    views: u32,
    range_count: u32,
    cluster_count: u32,
    /// Indirect draws, by frame, view and cluster.
    pub draws: Buffer,
    /// Number of draws, by frame, view and range.
    pub counts: Buffer,
    _ranges: Buffer,
    _layout: SetLayout,
}

impl Cull {
    /// Bytes of draws that one frame needs.
    pub fn bytes_per_frame(geometry: &Geometry, views: Views) -> u64 {
        u64::from(views.count()) * u64::from(geometry.cluster_count) * DRAW_BYTES
    }

    /// Culls for up to `capacity` of `frames`; each triangle that is seen is drawn as `fan` of them, and adds to `drawn`.
    pub fn new(
        device: &Arc<Device>,
        geometry: &Geometry,
        frames: &Buffer,
        (views, fan): (Views, u32),
        capacity: u32,
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let ranges: Vec<[u32; 4]> = geometry
            .ranges
            .iter()
            .map(|r| [r.clusters.start, r.clusters.len() as u32, r.triangles.start, r.triangles.end])
            .collect();
        let ranges = Buffer::with_data(device, "draw ranges", &ranges)?;
        let bytes = Self::bytes_per_frame(geometry, views) * u64::from(capacity);
        let draws = Buffer::new(device, "indirect draws", bytes, Memory::Device)?;
        let count_bytes = u64::from(capacity * views.count()) * geometry.ranges.len() as u64 * 4;
        let counts = Buffer::new(device, "indirect draws", count_bytes, Memory::Device)?;
        let bindings = [
            Binding::Storage(frames),
            Binding::Storage(&geometry.clusters),
            Binding::Storage(&ranges),
            Binding::Storage(&draws),
            Binding::Storage(&counts),
            // Not written where nothing is counted.
            Binding::Storage(drawn.map_or(&counts, Counter::buffer)),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let clear_rest = u32::from(!device.capabilities.draw_indirect_count);
        let constants = Specialisation(vec![views.code(), views.count(), clear_rest, fan, u32::from(drawn.is_some())]);
        Ok(Self {
            pipeline: ComputePipeline::new("cull", &pipeline_layout, spirv!("cull", "cull.comp"), &constants)?,
            set,
            views: views.count(),
            range_count: geometry.ranges.len() as u32,
            cluster_count: geometry.cluster_count,
            draws,
            counts,
            _ranges: ranges,
            _layout: layout,
        })
    }

    /// Writes the draws of the first `frame_count` frames.
    pub fn record(&self, commands: &Commands, frame_count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        let push = Push {
            frame_count,
            range_count: self.range_count,
            cluster_count: self.cluster_count,
            cluster_size: CLUSTER,
        };
        self.pipeline.layout.push(commands, &push);
        self.pipeline.dispatch(commands, groups(frame_count * self.views * self.range_count, 32));
    }

    /// Byte offsets of the draws and of the count of a frame's view of a range.
    pub fn offsets(&self, frame: u32, view: u32, range: u32, first_cluster: u32) -> (u64, u64) {
        let frame_view = u64::from(frame * self.views + view);
        let draw = frame_view * u64::from(self.cluster_count) + u64::from(first_cluster);
        (draw * DRAW_BYTES, (frame_view * u64::from(self.range_count) + u64::from(range)) * 4)
    }
}

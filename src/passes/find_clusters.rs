//! Finds the clusters that each face of each hemicube may see, for captures in compute: a bit a cluster.

use super::cluster_tree::ClusterTree;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Faces of a hemicube.
pub const FACES: u32 = 5;
/// Invocations of a workgroup.
const THREADS: u32 = 32;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    cluster_count: u32,
    word_count: u32,
}

/// The pass.
pub struct FindClusters {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    /// A bit a cluster, by frame, face and word of 32 clusters.
    pub visible: Buffer,
    _layout: SetLayout,
}

impl FindClusters {
    /// Words of bits that one face needs.
    pub fn words(tree: &ClusterTree) -> u32 {
        tree.group_count
    }

    /// Bytes that one frame needs.
    pub fn bytes_per_frame(tree: &ClusterTree) -> u64 {
        u64::from(FACES * Self::words(tree)) * 4
    }

    /// Finds clusters for up to `capacity` of `frames`, whose faces have `size` texels a side; the first face's are those of
    /// all where one view projects the hemisphere onto a `disc`.
    pub fn new(
        device: &Arc<Device>,
        tree: &ClusterTree,
        frames: &Buffer,
        (size, disc): (u32, bool),
        capacity: u32,
    ) -> Result<Self> {
        let bytes = Self::bytes_per_frame(tree) * u64::from(capacity);
        let visible = Buffer::new(device, "visible clusters", bytes, Memory::Device)?;
        let bindings = [
            Binding::Storage(frames),
            Binding::TexelBuffer(&tree.groups),
            Binding::TexelBuffer(&tree.clusters),
            Binding::Storage(&visible),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let code = spirv!("find_clusters", "find_clusters.comp");
        let pipeline = ComputePipeline::new(
            "find_clusters",
            &pipeline_layout,
            code,
            &Specialisation(vec![size, 0, u32::from(disc)]),
        )?;
        let push = Push { cluster_count: tree.cluster_count, word_count: Self::words(tree) };
        Ok(Self { pipeline, set, push, visible, _layout: layout })
    }

    /// Finds the clusters of the first `count` frames.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [self.push.word_count.div_ceil(THREADS).max(1), count, 1]);
    }
}

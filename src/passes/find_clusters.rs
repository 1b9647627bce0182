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
    /// Error that is allowed at distance 1.
    allowed_error: f32,
}

/// What clusters are found for.
#[derive(Clone, Copy, Debug)]
pub struct Finds {
    /// Texels a side of a face.
    pub size: u32,
    /// One view projects the hemisphere onto a disc; what it sees stands in the first face's place.
    pub is_disc: bool,
    /// Coarse clusters are good enough if they are wrong by so many texels, at most.
    pub lod_error: f32,
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

    /// Finds clusters for up to `capacity` of `frames`; coarse ones where they are good enough.
    pub fn new(device: &Arc<Device>, tree: &ClusterTree, frames: &Buffer, finds: Finds, capacity: u32) -> Result<Self> {
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
        let Finds { size, is_disc, lod_error } = finds;
        let constants = Specialisation(vec![size, u32::from(tree.has_levels()), u32::from(is_disc)]);
        let pipeline = ComputePipeline::new("find_clusters", &pipeline_layout, code, &constants)?;
        let push = Push {
            cluster_count: tree.cluster_count,
            word_count: Self::words(tree),
            // A face is 2 wide at distance 1.
            allowed_error: lod_error * 2.0 / size as f32,
        };
        Ok(Self { pipeline, set, push, visible, _layout: layout })
    }

    /// Finds the clusters of the first `count` frames.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [self.push.word_count.div_ceil(THREADS).max(1), count, 1]);
    }
}

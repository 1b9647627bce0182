//! The fused capture: hemicubes rasterised in compute, in shared memory.
//!
//! The same texels as [`super::capture`] sees, within the rasterisation rules: texels whose centre lies on an edge may fall
//! to either side, and of two surfaces whose distances differ by less than one step of the key either may be seen
//! (2^−(22 − bits of a triangle's number) of the distance: 1/32 % for 131,072 triangles).

use super::geometry::{CLUSTER, Geometry};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, gpu_types::Frame, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Nearest depth that is told from nearer ones, relative to the scene's size: 16 octaves down from four times its radius.
const NEAREST: f32 = 4.0 / 65536.0;
/// Most bits of a triangle's number, so that depth keeps 2¹¹ steps an octave at least.
const MOST_ID_BITS: u32 = 19;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    cluster_count: u32,
    triangle_count: u32,
    nearest: f32,
    texel_count: u32,
}

/// The pass.
pub struct CaptureCompute {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    /// Frames to look from.
    pub frames: Buffer,
    /// What each texel sees: triangle + 1 with the front in bit 31, and 1/distance.
    pub seen: Buffer,
    _layout: SetLayout,
}

impl CaptureCompute {
    /// What keeps hemicubes of `size` texels a side in a scene of so many triangles from fitting, if something does: a
    /// face must fit into shared memory, a triangle's number beside its depth. (Alpha masks are not tested here: the plan
    /// knows of them.)
    pub fn misfit(device: &Device, triangles: usize, size: u32) -> Option<String> {
        let (shared, most) = (size * size * 4 + 8, device.capabilities.limits.max_compute_shared_memory_size);
        if shared > most {
            return Some(format!("a face of {size} × {size} texels does not fit into {most} bytes of shared memory"));
        }
        let too_many = id_bits(triangles as u32) > MOST_ID_BITS;
        too_many.then(|| format!("{triangles} triangles are more than a texel's key can number: 2^{MOST_ID_BITS}"))
    }

    /// Captures up to `capacity` hemicubes of `size` texels a side.
    pub fn new(device: &Arc<Device>, geometry: &Geometry, size: u32, capacity: u32) -> Result<Self> {
        let texel_count = 3 * size * size;
        let frames = u64::from(capacity) * size_of::<Frame>() as u64;
        let frames = Buffer::new(device, "capture frames", frames, Memory::Device)?;
        let seen = Buffer::new(device, "capture", u64::from(capacity * texel_count) * 8, Memory::Device)?;
        let corners = geometry.corners.as_ref().expect("geometry was made for captures in compute");
        let bindings = [&frames, &geometry.clusters, corners, &seen].map(Binding::Storage);
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let constants = Specialisation(vec![size, id_bits(geometry.triangle_count)]);
        let code = spirv!("capture_compute", "capture_compute.comp");
        let push = Push {
            cluster_count: geometry.cluster_count,
            triangle_count: geometry.triangle_count,
            nearest: geometry.radius * NEAREST,
            texel_count,
        };
        let pipeline = ComputePipeline::new("capture_compute", &pipeline_layout, code, &constants)?;
        Ok(Self { pipeline, set, push, frames, seen, _layout: layout })
    }

    /// Captures the first `count` frames.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count * 5, 1, 1]);
    }
}

/// Bits that number every triangle; at least 5, so that depth takes the other 27.
fn id_bits(triangles: u32) -> u32 {
    const { assert!(CLUSTER == 64, "a workgroup takes a cluster") };
    (u32::BITS - triangles.leading_zeros()).max(5)
}

//! The fused capture: hemicubes, or hemispheres on a disc, rasterised in compute, in shared memory.
//!
//! The same texels as [`super::capture`] sees, within the rasterisation rules: texels whose centre lies on an edge may fall
//! to either side, and of two surfaces whose distances differ by less than 2⁻¹¹ of the distance either may be seen. Alpha
//! masks are bits on the triangles ([`crate::scene::opacity`]): their borders are half a texel of the texture off at most,
//! or a 64th of the triangle's side.

use super::cluster_tree::ClusterTree;
use super::find_clusters::{FACES, FindClusters, Finds};
use super::gathered::{Gathered, Kinds};
use super::geometry::{CLUSTER, Geometry};
use crate::math::capture::{Projection, Texel};
use crate::scene::Scene;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, TexelBuffer, gpu_types::Frame, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Words of clusters' bits that are listed at once (`WORDS` of the shader).
const LISTED_WORDS: u32 = 63;
/// Nearest depth that is told from nearer ones, relative to the scene's size: 16 octaves down from four times its radius.
const NEAREST: f32 = 4.0 / 65536.0;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    nearest: f32,
    word_count: u32,
    texel_count: u32,
    /// Cells from here on are coarse ones.
    first_coarse_cell: u32,
}

/// How a record looks.
pub struct Looks {
    size: u32,
    lod_error: f32,
    /// Texels of a record.
    pub texels: u32,
    /// Of each texel of a disc, its direction and its place in the square (bits).
    disc: Option<Vec<[f32; 4]>>,
}

impl Looks {
    /// By `projection`, a hemicube or a hemisphere, with `size` texels a side; coarse triangles, where the scene has levels
    /// of detail, are wrong by `lod_error` texels at most.
    pub fn new(projection: Projection, size: u32, lod_error: f32) -> Self {
        let texels = projection.table(size).texels;
        let spot = |t: &Texel| t.direction.as_vec3().extend(f32::from_bits(t.y * size + t.x)).to_array();
        let disc = (projection == Projection::Hemisphere).then(|| texels.iter().map(spot).collect());
        Self { size, lod_error, texels: texels.len() as u32, disc }
    }

    fn finds(&self) -> Finds {
        Finds { size: self.size, is_disc: self.disc.is_some(), lod_error: self.lod_error }
    }
}

/// The pass.
pub struct CaptureCompute {
    find: FindClusters,
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    /// Frames to look from.
    pub frames: Buffer,
    views: u32,
    _disc: Option<TexelBuffer>,
    _layout: SetLayout,
}

impl CaptureCompute {
    /// What keeps captures by `projection` with `size` texels a side in `scene` from fitting, if something does: a face must
    /// fit into shared memory, tables and corners into buffers, the alpha masks into their budget.
    pub fn misfit(device: &Device, scene: &Scene, projection: Projection, size: u32) -> Option<String> {
        let triangles = scene.triangles.len();
        let most = device.capabilities.limits.max_compute_shared_memory_size;
        if shared_bytes(size) > most {
            return Some(format!("a face of {size} × {size} texels does not fit into {most} bytes of shared memory"));
        }
        if u64::from(tables(projection, size)) > Gathered::most_viewed(device, Kinds { sky: false, planes: false }) {
            return Some(format!("tables of {size} × {size} texels do not fit into a texel buffer of the device"));
        }
        let too_many = !ClusterTree::holds(device, triangles);
        let corners = || format!("the corners of {triangles} triangles do not fit into a texel buffer of the device");
        too_many.then(corners).or_else(|| scene.too_many_masked())
    }

    /// Captures up to `capacity` times what `looks` says, of the triangles in `tree`, into `gathered`; `sky` where that keeps
    /// it.
    pub fn new(
        device: &Arc<Device>,
        (geometry, tree): (&Geometry, &ClusterTree),
        (gathered, sky): (&Gathered, Option<&Buffer>),
        looks: &Looks,
        capacity: u32,
    ) -> Result<Self> {
        let (size, is_disc) = (looks.size, looks.disc.is_some());
        let frames = u64::from(capacity) * size_of::<Frame>() as u64;
        let frames = Buffer::new(device, "capture frames", frames, Memory::Device)?;
        let find = FindClusters::new(device, tree, &frames, looks.finds(), capacity)?;
        let disc =
            looks.disc.as_ref().map(|disc| TexelBuffer::with_data(device, "capture tables", disc)).transpose()?;
        let bindings = [
            Binding::Storage(&frames),
            Binding::Storage(&find.visible),
            Binding::TexelBuffer(&tree.corners),
            // What the scene does not have is never read.
            Binding::TexelBuffer(tree.masks.as_ref().unwrap_or(&tree.corners)),
            Binding::Storage(&geometry.first_cell),
            Binding::Storage(&geometry.cell_radiance),
            Binding::Storage(sky.unwrap_or(&geometry.first_cell)),
            Binding::Storage(gathered.buffer()),
            Binding::TexelBuffer(disc.as_ref().unwrap_or(&tree.corners)),
            Binding::Storage(tree.shown_cell.as_ref().unwrap_or(&geometry.first_cell)),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let code = spirv!("capture_compute", "capture_compute.comp");
        let push = Push {
            nearest: geometry.radius * NEAREST,
            word_count: FindClusters::words(tree),
            texel_count: looks.texels,
            first_coarse_cell: geometry.cell_count,
        };
        let kinds = gathered.kinds;
        let flags = [tree.masks.is_some(), kinds.sky, kinds.planes, is_disc, tree.has_levels()].map(u32::from);
        let constants = Specialisation([size].into_iter().chain(flags).collect());
        let pipeline = ComputePipeline::new("capture_compute", &pipeline_layout, code, &constants)?;
        let views = if is_disc { 1 } else { FACES };
        Ok(Self { find, pipeline, set, push, frames, views, _disc: disc, _layout: layout })
    }

    /// Finds the clusters that the first `count` frames see.
    pub fn record_find(&self, commands: &Commands, count: u32) {
        self.find.record(commands, count);
    }

    /// Captures the first `count` frames, after [`Self::record_find`].
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count * self.views, 1, 1]);
    }
}

/// Values of the larger table that [`super::integrate`] fetches, at most: three for each of two edges a texel.
fn tables(projection: Projection, size: u32) -> u32 {
    let squares = if projection == Projection::Hemicube { 3 } else { 1 };
    3 * 2 * squares * size * size
}

/// Shared memory of a workgroup: keys, and the list of clusters with the counts that order it.
fn shared_bytes(size: u32) -> u32 {
    4 * (size * size + LISTED_WORDS * u32::BITS + CLUSTER)
}

//! The fused capture: hemicubes, or hemispheres on a disc, rasterised in compute, in shared memory.
//!
//! The same texels as [`super::capture`] sees, within the rasterisation rules: texels whose centre lies on an edge may fall
//! to either side, and of two surfaces whose distances differ by less than 2⁻¹³ of the distance either may be seen. Alpha
//! masks are bits on the triangles ([`crate::scene::opacity`]): their borders are half a texel of the texture off at most,
//! or a 64th of the triangle's side.

use super::cluster_tree::ClusterTree;
use super::counter::Counter;
use super::gathered::{Gathered, Kinds};
use super::geometry::Geometry;
use crate::math::capture::{Projection, Texel};
use crate::scene::Scene;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, TexelBuffer, gpu_types::Frame, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Octets that are listed at once (`LIST` of the shader).
const LISTED: u32 = 2016;
/// Triangles without levels of detail, at most, that one subgroup draws at 32² texels.
const MOST_EXACT: u64 = 1 << 17;
/// Invocations of a workgroup that is no subgroup.
const THREADS: u32 = 64;
/// Nearest depth that is told from nearer ones, relative to the scene's radius: 32 octaves from there on are told apart, up to
/// 2¹⁴ times the radius.
const NEAREST: f32 = 1.0 / (1 << 18) as f32;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    nearest: f32,
    /// Error of coarse triangles that is allowed at distance 1.
    allowed_error: f32,
    texel_count: u32,
    /// Cells from here on are coarse ones.
    first_coarse_cell: u32,
    /// Clusters of the tree.
    clusters: u32,
    /// Children of its root.
    root: u32,
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
}

/// The pass.
pub struct CaptureCompute {
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
    /// it. What is drawn, triangles times views by octets, adds to `drawn`.
    pub fn new(
        device: &Arc<Device>,
        (geometry, tree): (&Geometry, &ClusterTree),
        (gathered, sky): (&Gathered, Option<&Buffer>),
        looks: &Looks,
        capacity: u32,
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let (size, is_disc) = (looks.size, looks.disc.is_some());
        let frames = u64::from(capacity) * size_of::<Frame>() as u64;
        let frames = Buffer::new(device, "capture frames", frames, Memory::Device)?;
        let disc =
            looks.disc.as_ref().map(|disc| TexelBuffer::with_data(device, "capture tables", disc)).transpose()?;
        let bindings = [
            Binding::Storage(&frames),
            Binding::TexelBuffer(&tree.octets),
            Binding::TexelBuffer(&tree.corners),
            // What the scene does not have is never read.
            Binding::TexelBuffer(tree.masks.as_ref().unwrap_or(&tree.corners)),
            Binding::Storage(&geometry.first_cell),
            Binding::Storage(&geometry.cell_radiance),
            Binding::Storage(sky.unwrap_or(&geometry.first_cell)),
            Binding::Storage(gathered.buffer()),
            Binding::TexelBuffer(disc.as_ref().unwrap_or(&tree.corners)),
            Binding::Storage(tree.shown_cell.as_ref().unwrap_or(&geometry.first_cell)),
            Binding::TexelBuffer(&tree.nodes),
            Binding::Storage(drawn.map_or(&frames, Counter::buffer)),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let push = Push {
            nearest: geometry.radius * NEAREST,
            // A face is 2 wide at distance 1.
            allowed_error: looks.lod_error * 2.0 / size as f32,
            texel_count: looks.texels,
            first_coarse_cell: geometry.cell_count,
            clusters: tree.clusters,
            root: tree.root.unwrap_or(0),
        };
        let kinds = gathered.kinds;
        let flags = [tree.masks.is_some(), kinds.sky, kinds.planes, is_disc, tree.has_levels()].map(u32::from);
        let (threads, code) = match device.capabilities.subgroup.filter(|_| !is_disc) {
            Some(threads) if by_subgroups(device, threads, (geometry, tree), size) => {
                (threads, spirv!("capture_compute", "subgroup.comp"))
            }
            _ => (THREADS, spirv!("capture_compute", "workgroup.comp")),
        };
        let constants =
            Specialisation([size].into_iter().chain(flags).chain([threads, u32::from(drawn.is_some())]).collect());
        let pipeline = ComputePipeline::new("capture_compute", &pipeline_layout, code, &constants)?;
        let views = if is_disc { 1 } else { 5 };
        Ok(Self { pipeline, set, push, frames, views, _disc: disc, _layout: layout })
    }

    /// Captures the first `count` frames.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count * self.views, 1, 1]);
    }
}

/// Whether a workgroup is to be one subgroup, of so many invocations: on a CPU whose vector unit runs one. A driver that has to
/// stop and go on with invocations keeps their variables in memory (llvmpipe: 1.4 times the time). But all of a view's work falls
/// to one then, and llvmpipe ends every loop of an invocation after 65,535 rounds of all its loops together: only where few
/// triangles are drawn as they are, the fewer the more texels they have.
fn by_subgroups(device: &Device, threads: u32, (geometry, tree): (&Geometry, &ClusterTree), size: u32) -> bool {
    // Of levels of detail a view draws and visits a small part: the same is seen by whole workgroups of 4 million triangles.
    let share = |masked: bool| if tree.has_levels() && !masked { 64 } else { 1 };
    let drawn = geometry.ranges.iter().map(|r| r.triangles.len() as u64 / share(r.masked.is_some())).sum::<u64>();
    let few = drawn * u64::from(size * size) <= MOST_EXACT * 32 * 32 && size <= 64;
    few && device.is_cpu() && threads >= 8 && THREADS.is_multiple_of(threads)
}

/// Values of the larger table that [`super::integrate`] fetches, at most: three for each of two edges a texel.
fn tables(projection: Projection, size: u32) -> u32 {
    let squares = if projection == Projection::Hemicube { 3 } else { 1 };
    3 * 2 * squares * size * size
}

/// Shared memory of a workgroup: keys, octets, clusters, the walk's stack, and two words for counting.
fn shared_bytes(size: u32) -> u32 {
    4 * (size * size + LISTED + 2 * THREADS + 10 * THREADS + 2)
}

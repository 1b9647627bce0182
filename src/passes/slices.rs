//! Slices of the scene along its three axes, as voxels with a value for each of their six sides (Fournier and Péroche 2005, 5.3):
//! what stands for all that is far from a record in [`super::capture_compute`].
//!
//! Of each side the radiance that leaves the surfaces it shows, averaged over its area, and the share of that which they cover:
//! by samples at a higher resolution, as the paper's section 7 proposes. Masks count as what they leave of the samples.
//!
//! A wall along the axes is met whole by every line. What lies obliquely is whole on average only: of lines that pass a plane at 45°
//! up to a half miss the middles of its voxels' sides, so that of a sphere's inside a seventh of the light that is not drawn is
//! lost. Closed cubes in their place lose nothing, but show all larger, and err more in all scenes measured.

use super::cluster_tree::ClusterTree;
use super::geometry::{CLUSTER, Geometry};
use super::groups;
use crate::math::slices::{Grid, SAMPLES};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Shader, Specialisation, TexelBuffer, barrier, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Rows of samples that an invocation draws (`BAND` of the shader).
const BAND: u32 = 32;
/// Bytes of a sample: a distance and a cell to either side.
const SAMPLE_BYTES: u64 = 16;
/// Bytes of a voxel: radiance and coverage of six sides.
const VOXEL_BYTES: u64 = 6 * 16;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    low: [f32; 3],
    /// Voxels in a unit of length.
    per_length: [f32; 3],
    dims: [u32; 3],
    axis: u32,
    phase: u32,
    triangles: u32,
    first_coarse_cell: u32,
}

/// The pass and what it makes.
pub struct Slices {
    /// Its voxels.
    pub grid: Grid,
    /// Radiance times coverage, and coverage: of all voxels their sides to below and to above along x, then y, then z.
    pub sides: TexelBuffer,
    rasterise: Dispatch,
    average: Dispatch,
    samples: Buffer,
    push: Push,
}

struct Dispatch {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    _layout: SetLayout,
}

impl Dispatch {
    fn new(device: &Arc<Device>, bindings: &[Binding<'_>], code: &Shader, constants: Vec<u32>) -> Result<Self> {
        let layout = SetLayout::of(device, bindings)?;
        let set = DescriptorSet::new(&layout, bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let pipeline = ComputePipeline::new("slices", &pipeline_layout, code, Specialisation(constants))?;
        Ok(Self { pipeline, set, _layout: layout })
    }

    fn record(&self, commands: &Commands, push: &Push, groups: [u32; 3]) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, push);
        self.pipeline.dispatch(commands, groups);
    }
}

impl Slices {
    /// Uses and bytes of the two buffers of a grid: what sides show, and samples of one axis.
    pub fn needs(grid: &Grid) -> [(&'static str, u64); 2] {
        let samples = SAMPLE_BYTES * u64::from(SAMPLES * SAMPLES);
        [("slices", VOXEL_BYTES * grid.voxels()), ("slice samples", samples * grid.voxels())]
    }

    /// Bytes that the device allows either.
    pub fn most_bytes(device: &Device) -> u64 {
        let limits = &device.capabilities.limits;
        u64::from(limits.max_storage_buffer_range).min(u64::from(limits.max_texel_buffer_elements) * 16)
    }

    /// What keeps a grid's slices from fitting into the device, if something does.
    pub fn misfit(device: &Device, grid: &Grid) -> Option<String> {
        let (bytes, most) = (Self::needs(grid).map(|(_, bytes)| bytes).into_iter().max()?, Self::most_bytes(device));
        let [x, y, z] = grid.dims.to_array();
        (bytes > most).then(|| {
            format!("slices of {x} × {y} × {z} voxels take {bytes} bytes, above the {most} that this device allows one buffer")
        })
    }

    /// Of the triangles in `tree`.
    pub fn new(device: &Arc<Device>, (geometry, tree): (&Geometry, &ClusterTree), grid: Grid) -> Result<Self> {
        let [(of_sides, sides), (of_samples, samples)] = Self::needs(&grid);
        let sides = TexelBuffer::new(device, of_sides, sides)?;
        let samples = Buffer::new(device, of_samples, samples, Memory::Device)?;
        let drawn = [
            Binding::TexelBuffer(&tree.corners),
            // What the scene does not have is never read.
            Binding::TexelBuffer(tree.masks.as_ref().unwrap_or(&tree.corners)),
            Binding::Storage(&samples),
        ];
        let has_masks = u32::from(tree.masks.is_some());
        let rasterise = Dispatch::new(device, &drawn, spirv!("slices", "rasterise.comp"), vec![has_masks])?;
        let averaged =
            [Binding::Storage(&samples), Binding::Storage(&geometry.cell_radiance), Binding::Storage(&sides.buffer)];
        let average = Dispatch::new(device, &averaged, spirv!("slices", "average.comp"), Vec::new())?;
        let push = Push {
            low: grid.low.to_array(),
            per_length: grid.voxel.recip().to_array(),
            dims: grid.dims.to_array(),
            axis: 0,
            phase: 0,
            triangles: tree.clusters * CLUSTER,
            first_coarse_cell: geometry.cell_count,
        };
        Ok(Self { grid, sides, rasterise, average, samples, push })
    }

    /// Draws the slices, of the surfaces' light as it is by then.
    pub fn record(&self, commands: &Commands) {
        let dims = self.push.dims;
        for axis in 0..3 {
            let push = Push { axis: axis as u32, ..self.push };
            commands.fill(&self.samples, 0);
            barrier::dispatches(commands);
            let [x, y, _] = groups(push.triangles, 64);
            let bands = (dims[(axis + 2) % 3] * SAMPLES).div_ceil(BAND);
            for phase in 0..2 {
                self.rasterise.record(commands, &Push { phase, ..push }, [x, y, bands]);
                barrier::dispatches(commands);
            }
            self.average.record(commands, &push, groups(self.grid.voxels() as u32, 64));
            // The next axis's samples take these ones' place.
            barrier::full(commands);
        }
    }
}

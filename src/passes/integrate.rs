//! Integrates a batch of captures: irradiance, gradients, harmonic mean distance, radius.

use super::capture::Capture;
use super::capture_compute::CaptureCompute;
use super::geometry::Geometry;
use crate::math::capture::{self, Projection, Table};
use crate::vk::gpu_types::{Edge, Texel};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Push constants of the pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Push {
    texel_count: u32,
    edge_count: u32,
    tile_size: u32,
    columns: u32,
    /// 1/Σ of the cosine weights.
    inverse_weight: f32,
    limits: Limits,
}

/// How far records reach.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Limits {
    /// Ward's a.
    pub accuracy: f32,
    /// Smallest radius of a zone of influence, in pixels.
    pub min_radius: f32,
    /// Largest, in pixels.
    pub max_radius: f32,
    /// Mean distance of a record that sees nothing.
    pub scene_radius: f32,
}

/// Which gradients are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gradients {
    /// By turning the normal.
    pub rotation: bool,
    /// By moving the point.
    pub translation: bool,
}

/// What a record's R is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radius {
    /// The harmonic mean distance of what it sees, limited by E/‖∇E‖ (Ward 1988; Křivánek et al. 2005).
    Harmonic,
    /// By the second derivatives of E, which are what extrapolation by gradients leaves out (Jarosz et al. 2012). Without
    /// the translation gradient the harmonic one.
    Hessian,
}

/// Where captures come from.
pub enum CapturedBy<'a> {
    /// Render passes.
    Render(&'a Capture),
    /// Compute.
    Compute(&'a CaptureCompute),
}

/// Captures to integrate.
pub struct Captured<'a> {
    /// Where they come from.
    pub by: CapturedBy<'a>,
    /// How directions became texels.
    pub projection: Projection,
    /// Texels a side.
    pub size: u32,
    /// Records of a batch.
    pub capacity: u32,
}

/// The pass.
pub struct Integrate {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    scene_set: DescriptorSet,
    push: Push,
    /// Of each texel of each record of a batch, `stride` values: radiance and 1/distance first.
    pub gathered: Buffer,
    /// Values of four floats that a texel has in `gathered`.
    pub stride: u32,
    _tables: [Buffer; 2],
    _layouts: [SetLayout; 2],
}

impl Integrate {
    /// Integrates captures into `records` and `payloads`; with `sky`, each record has a second payload.
    pub fn new(
        device: &Arc<Device>,
        geometry: &Geometry,
        captured: &Captured<'_>,
        (records, payloads): (&Buffer, &Buffer),
        sky: Option<&Buffer>,
        (gradients, radius): (Gradients, Radius),
        limits: Limits,
    ) -> Result<Self> {
        let table = captured.projection.table(captured.size);
        let texels = Buffer::with_data(device, "capture tables", &gpu_texels(&table))?;
        let edges = Buffer::with_data(device, "capture tables", &gpu_edges(&table, gradients))?;
        let stride = 1 + u32::from(sky.is_some()) + u32::from(gradients.translation);
        let per_record = table.texels.len() as u64 * 16 * u64::from(stride);
        let gathered_bytes = per_record * u64::from(captured.capacity);
        let gathered = Buffer::new(device, "gathered radiance", gathered_bytes, Memory::Device)?;

        let (positions, indices) = (&geometry.positions, &geometry.indices);
        let scene_bindings = [positions, indices, &geometry.first_cell, &geometry.cell_radiance].map(Binding::Storage);
        let scene_layout = SetLayout::of(device, &scene_bindings)?;
        let scene_set = DescriptorSet::new(&scene_layout, &scene_bindings)?;
        let (inputs, frames, code, columns) = match captured.by {
            CapturedBy::Render(capture) => {
                let identity = capture.identity.as_ref().expect("captures for integration keep identities");
                let images = [Binding::Texels(identity), Binding::Texels(&capture.depth)];
                (images, &capture.frames, spirv!("integrate", "from_render.comp"), capture.columns)
            }
            CapturedBy::Compute(capture) => {
                // The second place is an image's in the other shader, and free in this one.
                let buffers = [Binding::Storage(&capture.seen), Binding::Storage(&capture.seen)];
                (buffers, &capture.frames, spirv!("integrate", "from_compute.comp"), 1)
            }
        };
        let bindings = [
            inputs[0],
            inputs[1],
            Binding::Storage(frames),
            Binding::Storage(&texels),
            Binding::Storage(&edges),
            Binding::Storage(&gathered),
            Binding::Storage(records),
            Binding::Storage(payloads),
            Binding::Storage(sky.unwrap_or(&texels)),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&scene_layout, &layout], size_of::<Push>() as u32)?;
        let is_curved = captured.projection == Projection::Hemisphere;
        let by_hessian = radius == Radius::Hessian && gradients.translation;
        let flags = [sky.is_some(), gradients.rotation, gradients.translation, is_curved, by_hessian];
        let constants = Specialisation(flags.map(u32::from).to_vec());
        let pipeline = ComputePipeline::new("integrate", &pipeline_layout, code, &constants)?;
        let push = Push {
            texel_count: table.texels.len() as u32,
            edge_count: table.edges.len() as u32,
            tile_size: captured.size,
            columns,
            inverse_weight: table.weight().recip() as f32,
            limits,
        };
        Ok(Self {
            pipeline,
            set,
            scene_set,
            push,
            gathered,
            stride,
            _tables: [texels, edges],
            _layouts: [scene_layout, layout],
        })
    }

    /// Integrates the first `count` captures.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.scene_set, &self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count, 1, 1]);
    }
}

fn gpu_texels(table: &Table) -> Vec<Texel> {
    let texel = |t: &capture::Texel| {
        let (d, turn) = (t.direction.as_vec3(), t.turn().as_vec3());
        Texel {
            direction: [d.x, d.y, d.z, t.weight() as f32],
            place: [t.layer << 16 | t.y << 8 | t.x, (t.forward as f32).to_bits(), turn.x.to_bits(), turn.y.to_bits()],
        }
    };
    table.texels.iter().map(texel).collect()
}

fn gpu_edges(table: &Table, gradients: Gradients) -> Vec<Edge> {
    let edge = |e: &capture::Edge| {
        let s = e.step.as_vec3();
        let m = e.middle.as_vec3();
        Edge { step: [s.x, s.y, s.z, 0.0], texels: [e.i, e.j, m.x.to_bits(), m.y.to_bits()] }
    };
    if gradients.translation { table.edges.iter().map(edge).collect() } else { vec![Edge::default()] }
}

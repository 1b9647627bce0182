//! Integrates a batch of captures: irradiance, gradients, harmonic mean distance, radius.

use super::capture::Capture;
use super::capture_compute::CaptureCompute;
use super::gathered::Gathered;
use super::geometry::Geometry;
use crate::math::capture::{self, Faces, Projection, Table};
use crate::vk::gpu_types::{Edge, Texel};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, PipelineLayout, Result, SetLayout,
    Specialisation, TexelBuffer, spirv,
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

/// How far records are good for. Views limit that by their pixels when they use them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Limits {
    /// R of a record that sees nothing.
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
    /// Render passes; with neighbours ([`Geometry::neighbours`]) outlines are followed over the triangles' edges.
    Render(&'a Capture, Option<&'a Buffer>),
    /// Compute, by whose neighbours outlines are followed, unless it has summed faces.
    Compute(&'a CaptureCompute),
}

/// Captures to integrate.
pub struct Captured<'a> {
    /// Where they come from.
    pub by: CapturedBy<'a>,
    /// What their texels see.
    pub gathered: &'a Gathered,
    /// How directions became texels.
    pub projection: Projection,
    /// Texels a side.
    pub size: u32,
}

/// The pass.
pub struct Integrate {
    pipeline: ComputePipeline,
    sets: Vec<DescriptorSet>,
    push: Push,
    _tables: Tables,
    _layouts: Vec<SetLayout>,
}

/// Texels and edges on the device.
enum Tables {
    Plain([Buffer; 2]),
    Viewed([TexelBuffer; 2]),
}

impl Tables {
    const NAME: &str = "capture tables";

    fn new(device: &Arc<Device>, viewed: bool, texels: &[Texel], edges: &[Edge]) -> Result<Self> {
        Ok(if viewed {
            let texels = TexelBuffer::with_data(device, Self::NAME, texels)?;
            Self::Viewed([texels, TexelBuffer::with_data(device, Self::NAME, edges)?])
        } else {
            let texels = Buffer::with_data(device, Self::NAME, texels)?;
            Self::Plain([texels, Buffer::with_data(device, Self::NAME, edges)?])
        })
    }

    fn bindings(&self) -> [Binding<'_>; 2] {
        match self {
            Self::Plain(tables) => tables.each_ref().map(Binding::Storage),
            Self::Viewed(tables) => tables.each_ref().map(Binding::TexelBuffer),
        }
    }
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
        let (frames, code, columns) = match captured.by {
            CapturedBy::Render(capture, _) => {
                (&capture.frames, spirv!("integrate", "from_render.comp"), capture.columns)
            }
            CapturedBy::Compute(capture) => (&capture.frames, spirv!("integrate", "from_compute.comp"), 1),
        };
        let view = captured.gathered.view();
        let sums = captured.gathered.sums.as_ref();
        let (gpu_texels, gpu_edges) = tables(&table, sums.is_some(), gradients);
        let tables = Tables::new(device, view.is_some(), &gpu_texels, &gpu_edges)?;
        let [texels, edges] = tables.bindings();
        let of_captures = [
            Binding::Storage(frames),
            Binding::Storage(records),
            Binding::Storage(payloads),
            texels,
            edges,
            view.map_or(Binding::Storage(captured.gathered.buffer()), Binding::TexelBuffer),
        ];
        let follows = captured.by.is_to_follow(sums.is_some());
        let of_scene = match captured.by {
            CapturedBy::Render(capture, neighbours) => scene_bindings(geometry, capture, neighbours, sky),
            CapturedBy::Compute(_) => vec![],
        };
        let of_compute = view.map(|view| compute_bindings(geometry, captured, (records, view), follows));
        let own: Vec<_> = of_captures.into_iter().chain(of_compute.into_iter().flatten()).collect();
        let all = [&own[..], &of_scene].into_iter().filter(|bindings| !bindings.is_empty());
        let layouts = all.clone().map(|bindings| SetLayout::of(device, bindings)).collect::<Result<Vec<_>>>()?;
        let sets = all.zip(&layouts).map(|(bindings, layout)| DescriptorSet::new(layout, bindings));
        let sets = sets.collect::<Result<Vec<_>>>()?;
        let layout_refs: Vec<_> = layouts.iter().collect();
        let pipeline_layout = PipelineLayout::new(device, &layout_refs, size_of::<Push>() as u32)?;
        let is_curved = captured.projection == Projection::Hemisphere;
        let by_hessian = radius == Radius::Hessian && gradients.translation;
        let flags = [sky.is_some(), gradients.rotation, gradients.translation, is_curved, by_hessian];
        let parts = sums.map_or(0, |sums| sums.part_count);
        let constants = flags.map(u32::from).into_iter().chain([parts, u32::from(follows)]);
        let constants = Specialisation(constants.collect());
        let pipeline = ComputePipeline::new("integrate", &pipeline_layout, code, &constants)?;
        let push = Push {
            texel_count: gpu_texels.len() as u32,
            edge_count: gpu_edges.len() as u32,
            tile_size: captured.size,
            columns,
            inverse_weight: table.weight().recip() as f32,
            limits,
        };
        Ok(Self { pipeline, sets, push, _tables: tables, _layouts: layouts })
    }

    /// Integrates the first `count` captures.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &self.sets.iter().collect::<Vec<_>>());
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count, 1, 1]);
    }
}

impl CapturedBy<'_> {
    /// Whether outlines are to be followed between the texels that are integrated; `summed` faces have been.
    fn is_to_follow(&self, summed: bool) -> bool {
        match self {
            Self::Render(_, neighbours) => neighbours.is_some(),
            Self::Compute(capture) => !summed && capture.neighbours.is_some(),
        }
    }
}

/// Sums of a capture in compute, and what outlines are followed by; where there are none, what is never read.
fn compute_bindings<'a>(
    geometry: &'a Geometry,
    captured: &Captured<'a>,
    (storage, view): (&'a Buffer, &'a TexelBuffer),
    follows: bool,
) -> [Binding<'a>; 4] {
    let (tree, neighbours) = match captured.by {
        CapturedBy::Compute(capture) if follows => (geometry.tree.as_ref(), capture.neighbours.as_ref()),
        _ => (None, None),
    };
    [
        Binding::Storage(captured.gathered.sums.as_ref().map_or(storage, |sums| &sums.parts)),
        Binding::TexelBuffer(tree.map_or(view, |tree| &tree.corners)),
        Binding::TexelBuffer(neighbours.unwrap_or(view)),
        Binding::Storage(if follows { &geometry.cell_radiance } else { storage }),
    ]
}

/// What texels see is looked up in the scene, where the capture has not done so.
pub(super) fn scene_bindings<'a>(
    geometry: &'a Geometry,
    capture: &'a Capture,
    neighbours: Option<&'a Buffer>,
    sky: Option<&'a Buffer>,
) -> Vec<Binding<'a>> {
    let (positions, indices) = (&geometry.positions, &geometry.indices);
    vec![
        Binding::Storage(positions),
        Binding::Storage(indices),
        Binding::Storage(&geometry.first_cell),
        Binding::Storage(&geometry.cell_radiance),
        Binding::Texels(&capture.identity),
        Binding::Storage(sky.unwrap_or(positions)),
        Binding::Storage(neighbours.unwrap_or(positions)),
    ]
}

/// A texel as shaders read it.
pub(super) fn texel_on_device(t: &capture::Texel) -> Texel {
    let (d, turn) = (t.direction.as_vec3(), t.turn().as_vec3());
    let place = f32::from_bits(t.layer << 16 | t.y << 8 | t.x);
    Texel { weights: [t.weight() as f32, turn.x, turn.y, place], direction: [d.x, d.y, d.z, 0.0] }
}

/// Texels and edges that the shader goes through; of faces that are summed those at borders.
fn tables(table: &Table, summed: bool, gradients: Gradients) -> (Vec<Texel>, Vec<Edge>) {
    let edge = |e: &capture::Edge, [i, j]: [u32; 2]| Edge {
        step: [e.step.x as f32, e.step.y as f32, f32::from_bits(i), f32::from_bits(j)],
        between: table.between(e).normalize().as_vec3().extend(0.0).to_array(),
        bend: e.bend().as_vec3().extend(0.0).to_array(),
    };
    let (texels, edges) = if summed {
        let faces = Faces::of(table);
        let number = |i: u32| faces.border[i as usize].expect("seams touch texels at borders");
        let edges = faces.seams.iter().map(|e| edge(e, [e.i, e.j].map(number))).collect();
        (vec![Texel::default(); faces.border_count as usize], edges)
    } else {
        let edges = table.edges.iter().map(|e| edge(e, [e.i, e.j])).collect();
        (table.texels.iter().map(texel_on_device).collect(), edges)
    };
    (texels, if gradients.translation { edges } else { vec![Edge::default()] })
}

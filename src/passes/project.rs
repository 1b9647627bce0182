//! Projects captures onto a basis: coefficients, their gradients, and the harmonic mean distance. [`super::integrate`] is the same
//! for the cosine alone, with what records of the cache need besides.

use super::gathered::Gathered;
use crate::math::capture::{Basis, Projection, Table, Weights};
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Coefficients of a workgroup (`COEFFICIENTS` of the shader).
const TILE: usize = 4;
/// Sums of each coefficient (`SUMS_OF_TILE`): values of three channels, their gradients along three axes, 1/R.
const SUMS: usize = 13;
/// The last of them (`DISTANCE`).
const DISTANCE: usize = 12;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    texel_count: u32,
    edge_count: u32,
    tiles: u32,
}

/// What a capture sees, in a basis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Projected {
    /// ∫ L·B dω of each coefficient, a colour channel each, W·m⁻².
    pub coefficients: Vec<Vec3>,
    /// Their gradients along the frame's own x, y and z, W·m⁻² per unit of length. Zero if not asked for.
    pub gradients: Vec<[Vec3; 3]>,
    /// 1/R: the harmonic mean of the distances that are seen, cosine-weighted over a hemisphere, else by solid angle.
    pub inverse_distance: f32,
}

/// The pass.
pub struct Project {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    basis: Basis,
    results: Buffer,
    readback: Buffer,
    _tables: [Buffer; 4],
    _layout: SetLayout,
}

impl Project {
    /// Projects what up to `capacity` captures have `gathered`, by `projection` with `size` texels a side, onto `basis`; `gradients`
    /// need the planes of the surfaces.
    pub fn new(
        device: &Arc<Device>,
        gathered: &Gathered,
        (projection, size, table): (Projection, u32, &Table),
        (basis, gradients): (Basis, bool),
        capacity: u32,
    ) -> Result<Self> {
        let weights = Weights::new(projection, size, table, basis);
        let tiles = basis.count().div_ceil(TILE);
        let tables = tables(device, table, &weights, tiles)?;
        let bytes = u64::from(capacity) * (tiles * TILE * SUMS * 4) as u64;
        let [results, readback] =
            [Memory::Device, Memory::Readback].map(|memory| Buffer::new(device, "coefficients", bytes, memory));
        let (results, readback) = (results?, readback?);
        let view = gathered.view();
        let bindings: Vec<_> = [view.map_or(Binding::Storage(gathered.buffer()), Binding::TexelBuffer)]
            .into_iter()
            .chain(tables.iter().chain([&results]).map(Binding::Storage))
            .collect();
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let flags = [gathered.kinds.sky, gathered.kinds.planes, gradients];
        let constants = Specialisation(flags.map(u32::from).to_vec());
        let code = match view {
            Some(_) => spirv!("project", "from_compute.comp"),
            None => spirv!("project", "from_render.comp"),
        };
        let pipeline = ComputePipeline::new("project", &pipeline_layout, code, &constants)?;
        let push =
            Push { texel_count: table.texels.len() as u32, edge_count: table.edges.len() as u32, tiles: tiles as u32 };
        Ok(Self { pipeline, set, push, basis, results, readback, _tables: tables, _layout: layout })
    }

    /// Projects the first `count` captures.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count, self.push.tiles, 1]);
    }

    /// Copies the results to where [`Self::read`] finds them.
    pub fn record_readback(&self, commands: &Commands) {
        commands.copy_buffer(&self.results, &self.readback, self.results.size);
    }

    /// The results of the first `count` captures.
    pub fn read(&self, count: usize) -> Vec<Projected> {
        let floats = self.push.tiles as usize * TILE * SUMS;
        let all: Vec<f32> = self.readback.read(count * floats);
        all.chunks(floats).map(|sums| projected(sums, self.basis.count())).collect()
    }
}

/// By the shader's sums of one capture.
fn projected(sums: &[f32], count: usize) -> Projected {
    let at = |coefficient: usize, sum: usize| {
        let (tile, place) = (coefficient / TILE, coefficient % TILE);
        sums[(tile * SUMS + sum) * TILE + place]
    };
    let channels = |coefficient, first| Vec3::from([0_usize, 1, 2].map(|channel| at(coefficient, first + channel)));
    Projected {
        coefficients: (0..count).map(|c| channels(c, 0)).collect(),
        gradients: (0..count).map(|c| [3, 6, 9].map(|first| channels(c, first))).collect(),
        inverse_distance: at(0, DISTANCE),
    }
}

/// Weights, places, middles and steps as the shader reads them.
fn tables(device: &Arc<Device>, table: &Table, weights: &Weights, tiles: usize) -> Result<[Buffer; 4]> {
    let count = weights.basis.count();
    let tile_of = |values: &[f64], tile: usize| {
        let value = |c: usize| values.get(tile * TILE + c).map_or(0.0, |v| *v as f32);
        [0, 1, 2, 3].map(value)
    };
    let of_texels = (0..tiles).flat_map(|tile| weights.texels.chunks(count).map(move |w| tile_of(w, tile)));
    let shares = weights.distance.iter().map(|share| [*share as f32, 0.0, 0.0, 0.0]);
    let of_texels: Vec<[f32; 4]> = of_texels.chain(shares).collect();
    let places: Vec<[u32; 2]> = table.edges.iter().map(|edge| [edge.i, edge.j]).collect();
    let middle = |edge| table.between(edge).normalize().as_vec3().extend(0.0).to_array();
    let middles: Vec<[f32; 4]> = table.edges.iter().map(middle).collect();
    let along = |steps: &[DVec3], axis: usize| steps.iter().map(|step| step[axis]).collect::<Vec<_>>();
    let of_edges: Vec<[f32; 4]> = (0..tiles)
        .flat_map(|tile| {
            let edge = move |steps| [0, 1, 2].map(|axis| tile_of(&along(steps, axis), tile));
            weights.edges.chunks(count).flat_map(edge)
        })
        .collect();
    let name = "capture tables";
    Ok([
        Buffer::with_data(device, name, &of_texels)?,
        Buffer::with_data(device, name, &places)?,
        Buffer::with_data(device, name, &middles)?,
        Buffer::with_data(device, name, &of_edges)?,
    ])
}

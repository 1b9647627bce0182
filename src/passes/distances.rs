//! Distances that captures see, by direction. They show whether a place is inside of geometry, and which samples of a volume a wall
//! hides from a point. The directions are cells of an octahedral map ([`octahedron`]).

use super::gathered::Gathered;
use crate::math::capture::Table;
use crate::math::octahedron;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::f32::consts::PI;
use std::sync::Arc;

/// Number of the map's cells (`CELLS` of the shader).
pub const CELLS: usize = octahedron::CELLS;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    texel_count: u32,
    farthest: f32,
}

/// The distances in the directions of one cell of the map.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Distances {
    /// Mean of the distance and mean of its square, weighted by solid angle over the distance's square. No distance is longer than
    /// the pass's farthest one.
    pub moments: [f32; 2],
    /// Solid angle of backs of triangles, sr.
    pub backs: f32,
    /// 1/distance of the nearest surface; 0 where only the sky is seen.
    pub nearness: f32,
}

/// Share of the whole sphere that backs of triangles fill.
pub fn back_share(cells: &[Distances]) -> f32 {
    cells.iter().map(|cell| cell.backs).sum::<f32>() / (4.0 * PI)
}

/// The pass.
pub struct DistancesPass {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    results: Buffer,
    readback: Buffer,
    _tables: [Buffer; 2],
    _layout: SetLayout,
}

impl DistancesPass {
    /// Sums up what up to `capacity` captures of the whole sphere, with the texels of `table`, have `gathered`. Distances longer
    /// than `farthest`, and the sky's, are taken as that.
    pub fn new(device: &Arc<Device>, gathered: &Gathered, table: &Table, farthest: f32, capacity: u32) -> Result<Self> {
        let (starts, members) = cells_of(table);
        let name = "capture tables";
        let tables = [Buffer::with_data(device, name, &starts)?, Buffer::with_data(device, name, &members)?];
        let bytes = u64::from(capacity) * (CELLS * size_of::<Distances>()) as u64;
        let [results, readback] =
            [Memory::Device, Memory::Readback].map(|memory| Buffer::new(device, "distances", bytes, memory));
        let (results, readback) = (results?, readback?);
        let view = gathered.view();
        let seen = view.map_or(Binding::Storage(gathered.buffer()), Binding::TexelBuffer);
        let bindings = [seen, Binding::Storage(&tables[0]), Binding::Storage(&tables[1]), Binding::Storage(&results)];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let code = match view {
            Some(_) => spirv!("distances", "from_compute.comp"),
            None => spirv!("distances", "from_render.comp"),
        };
        let has_sky = u32::from(gathered.kinds.sky);
        let pipeline = ComputePipeline::new("distances", &pipeline_layout, code, [("HAS_SKY", has_sky)])?;
        let push = Push { texel_count: table.texels.len() as u32, farthest };
        Ok(Self { pipeline, set, push, results, readback, _tables: tables, _layout: layout })
    }

    /// Sums up the first `count` captures.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count, 1, 1]);
    }

    /// Copies the results to where [`Self::read`] finds them.
    pub fn record_readback(&self, commands: &Commands) {
        commands.copy_buffer(&self.results, &self.readback, self.results.size);
    }

    /// The results of the first `count` captures, [`CELLS`] each.
    pub fn read(&self, count: usize) -> Vec<Vec<Distances>> {
        self.readback.read::<Distances>(count * CELLS).chunks(CELLS).map(<[Distances]>::to_vec).collect()
    }
}

/// Of each cell where its members begin, and of each member the texel's number (bits) and solid angle.
fn cells_of(table: &Table) -> (Vec<u32>, Vec<[f32; 2]>) {
    let mut of_cells = vec![Vec::new(); CELLS];
    for (texel, number) in table.texels.iter().zip(0_u32..) {
        of_cells[octahedron::cell(texel.direction)].push([f32::from_bits(number), texel.solid_angle as f32]);
    }
    let mut starts = vec![0];
    starts.extend(of_cells.iter().scan(0, |end, cell| {
        *end += cell.len() as u32;
        Some(*end)
    }));
    (starts, of_cells.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::capture::Projection;

    #[test]
    fn every_texel_has_one_cell_and_every_cell_texels() {
        for size in [8, 32] {
            let table = Projection::Cube.table(size);
            let (starts, members) = cells_of(&table);
            assert_eq!((starts.len(), members.len()), (CELLS + 1, table.texels.len()));
            assert!(starts.windows(2).all(|pair| pair[0] < pair[1]), "{size}: an empty cell");
            let whole: f32 = members.iter().map(|member| member[1]).sum();
            assert!((whole - 4.0 * PI).abs() < 1e-3, "{whole}");
        }
    }
}

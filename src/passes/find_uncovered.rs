//! Finds the pixels of a lattice that no record covers yet, or whose records disagree, in scan order.

use super::gbuffer::Targets;
use super::groups;
use super::splat::Sums;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, barrier, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

const GROUP: u32 = 128;
/// Least distance between pixels of a lattice: the list of them is kept short by it.
pub const LEAST_STRIDE: u32 = 4;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    size: [u32; 2],
    offset: [u32; 2],
    lattice: [u32; 2],
    stride: u32,
    covered: f32,
    contrast: f32,
}

/// What makes a pixel of a lattice need a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// A sum of weights below this.
    pub covered: f32,
    /// A standard deviation of what its records say, relative to their mean, above this; 0: they may say anything.
    pub contrast: f32,
}

/// Every `stride`-th pixel of every `stride`-th row from `offset` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Distance between its pixels.
    pub stride: u32,
    /// Its first pixel.
    pub offset: [u32; 2],
}

/// The pass: dispatches of one shader.
pub struct FindUncovered {
    phases: [ComputePipeline; 3],
    /// Marks what is settled, where contrast is looked at.
    mark: Option<ComputePipeline>,
    settled: Buffer,
    set: DescriptorSet,
    size: [u32; 2],
    /// Count, then pixel indices.
    pub found: Buffer,
    readback: Buffer,
    _groups: Buffer,
    _layout: SetLayout,
}

impl FindUncovered {
    /// Reads what was splatted from `sums`; `has_contrast` says that their tally is to be looked at.
    pub fn new(device: &Arc<Device>, gbuffer: &Targets, sums: &Sums, has_contrast: bool) -> Result<Self> {
        let size = gbuffer.position.desc.size;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let counts = Buffer::new(device, "uncovered pixels", pixels.div_ceil(u64::from(GROUP)) * 4, Memory::Device)?;
        let [columns, rows] = size.map(|side| u64::from(side.div_ceil(LEAST_STRIDE)));
        let found = Buffer::new(device, "uncovered pixels", 4 + columns * rows * 4, Memory::Device)?;
        let settled = if has_contrast { pixels.div_ceil(32) * 4 } else { 4 };
        let settled = Buffer::new(device, "uncovered pixels", settled, Memory::Device)?;
        let bindings = [
            Binding::Texels(&gbuffer.position),
            Binding::Texels(&sums.indirect),
            Binding::Storage(&counts),
            Binding::Storage(&found),
            // Not read where it is not looked at.
            Binding::Texels(sums.tally.as_ref().unwrap_or(&sums.indirect)),
            Binding::Storage(&settled),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let phase = |index| {
            let code = spirv!("find_uncovered", "find_uncovered.comp");
            ComputePipeline::new(
                "find_uncovered",
                &pipeline_layout,
                code,
                Specialisation(vec![index, u32::from(has_contrast)]),
            )
        };
        Ok(Self {
            phases: [phase(0)?, phase(1)?, phase(2)?],
            mark: has_contrast.then(|| phase(3)).transpose()?,
            settled,
            set,
            size,
            found,
            readback: Buffer::new(device, "read-back", 4, Memory::Readback)?,
            _groups: counts,
            _layout: layout,
        })
    }

    fn push(&self, lattice: Lattice, need: Need) -> Push {
        let points = |axis: usize| self.size[axis].saturating_sub(lattice.offset[axis]).div_ceil(lattice.stride);
        Push {
            size: self.size,
            offset: lattice.offset,
            lattice: [points(0), points(1)],
            stride: lattice.stride,
            covered: need.covered,
            contrast: need.contrast,
        }
    }

    /// Marks no pixel as settled.
    pub fn record_clear(&self, commands: &Commands) {
        commands.fill(&self.settled, 0);
    }

    /// Marks the pixels that are covered by now as settled: their records may disagree.
    pub fn record_settled(&self, commands: &Commands, covered: f32) {
        let Some(mark) = &self.mark else { return };
        let push = self.push(Lattice { stride: 1, offset: [0; 2] }, Need { covered, contrast: 0.0 });
        mark.bind(commands, &[&self.set]);
        mark.layout.push(commands, &push);
        mark.dispatch(commands, groups(push.lattice[0] * push.lattice[1], GROUP));
    }

    /// Finds the pixels of `lattice` that need a record.
    pub fn record(&self, commands: &Commands, lattice: Lattice, need: Need) {
        assert!(lattice.stride >= LEAST_STRIDE, "{lattice:?} has more pixels than the list holds");
        let push = self.push(lattice, need);
        let all = groups(push.lattice[0] * push.lattice[1], GROUP);
        for (phase, groups) in self.phases.iter().zip([all, [1, 1, 1], all]) {
            phase.bind(commands, &[&self.set]);
            phase.layout.push(commands, &push);
            phase.dispatch(commands, groups);
            barrier::dispatches(commands);
        }
        barrier::full(commands);
        commands.copy_buffer(&self.found, &self.readback, 4);
    }

    /// The number found, once the submission has been waited for: all that the CPU learns of the image.
    pub fn count(&self) -> u32 {
        self.readback.read::<u32>(1)[0]
    }
}

//! Adds the records of a batch to the store.

use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Columns of a side face that a horizon keeps, at most.
const MOST_COLUMNS: u32 = 32;
/// Rows of each column.
const ROWS: u64 = 8;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    from: u32,
    to: u32,
    entry: u32,
}

/// What is kept of the distances that a hemicube saw, to tell what is hidden from a record (`glsl/inc/horizon.glsl`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Horizon {
    /// Texels a side of the hemicubes.
    pub size: u32,
}

impl Horizon {
    /// Columns of each side face.
    pub fn columns(self) -> u32 {
        self.size.min(MOST_COLUMNS)
    }

    /// Bytes of a record.
    pub fn bytes(self) -> u64 {
        u64::from(4 * self.columns()) * ROWS
    }

    /// The constants of shaders that have it: texels a side, columns; 0 texels where there is none.
    pub(super) fn constants(horizon: Option<Self>) -> [u32; 2] {
        horizon.map_or([0, 2], |horizon| [horizon.size, horizon.columns()])
    }
}

/// A batch of records as it was captured and integrated.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    /// Frames of the captures.
    pub frames: &'a Buffer,
    /// Records.
    pub records: &'a Buffer,
    /// Their payloads.
    pub payloads: &'a Buffer,
    /// 1/distance of what each texel saw; [`super::gathered`].
    pub distances: &'a Buffer,
    /// Floats from one to the next.
    pub stride: u32,
}

/// Where a batch is kept.
#[derive(Clone, Copy)]
pub struct Piece<'a> {
    /// Places.
    pub records: &'a Buffer,
    /// Payloads.
    pub payloads: &'a Buffer,
    /// Horizons; anything where none are kept.
    pub horizons: &'a Buffer,
    /// Entries of the index.
    pub entries: &'a Buffer,
}

/// A run of records: where it begins in the batch, in the piece and in the whole store, and how long it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// First record of the batch.
    pub from: u32,
    /// Its place in the piece.
    pub to: u32,
    /// Its number in the store.
    pub number: u32,
    /// Number of records.
    pub count: u32,
}

/// The pass.
pub struct KeepRecords {
    pipeline: ComputePipeline,
    layout: SetLayout,
}

impl KeepRecords {
    /// Keeps records with so many `payloads` each, and their `horizon` of distances that lie `stride` floats apart.
    pub fn new(
        device: &Arc<Device>,
        payloads: u32,
        horizon: Option<Horizon>,
        (batch, piece): (&Batch<'_>, &Piece<'_>),
    ) -> Result<Self> {
        let layout = SetLayout::of(device, &bindings(batch, piece))?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let [size, columns] = Horizon::constants(horizon);
        let constants = Specialisation(vec![payloads, size, columns, batch.stride]);
        let code = spirv!("keep_records", "keep_records.comp");
        let pipeline = ComputePipeline::new("keep_records", &pipeline_layout, code, constants)?;
        Ok(Self { pipeline, layout })
    }

    /// The buffers of a batch and of a piece of the store.
    pub fn set(&self, batch: &Batch<'_>, piece: &Piece<'_>) -> Result<DescriptorSet> {
        DescriptorSet::new(&self.layout, &bindings(batch, piece))
    }

    /// Keeps a run of records.
    pub fn record(&self, commands: &Commands, set: &DescriptorSet, run: Run) {
        self.pipeline.bind(commands, &[set]);
        self.pipeline.layout.push(commands, &Push { from: run.from, to: run.to, entry: run.number });
        self.pipeline.dispatch(commands, [run.count, 1, 1]);
    }
}

fn bindings<'a>(batch: &Batch<'a>, piece: &Piece<'a>) -> [Binding<'a>; 8] {
    [
        Binding::Storage(batch.frames),
        Binding::Storage(batch.records),
        Binding::Storage(batch.payloads),
        Binding::Storage(batch.distances),
        Binding::Storage(piece.records),
        Binding::Storage(piece.payloads),
        Binding::Storage(piece.horizons),
        Binding::Storage(piece.entries),
    ]
}

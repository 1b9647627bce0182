//! Records that outlive the view they were made for: a store that grows, in world units, found by place.
//!
//! A record keeps its place and normals, R without any view's limits, its payload and what it saw of its horizon. Views decide
//! when they use a record how far it reaches ([`crate::passes::clamp_records`]). The store consists of pieces of one size, so that it
//! grows without being copied and no buffer depends on how many records there are; only their entries in the index, 32 bytes each,
//! lie in one buffer.

pub mod file;
mod stored;

pub use stored::Stored;

use crate::passes::index_records::Index;
use crate::passes::keep_records::{Horizon, Piece, Run};
use crate::vk::gpu_types::{Kept, KeptPayload};
use crate::vk::{Buffer, Commands, Device, Memory, Result};
use std::ops::Range;
use std::sync::Arc;

/// Records of a piece, unless the device's buffers are too small for them: at most 20 MB with all that they keep: 16 384 × (48 + 2 × 80 + 1024) bytes.
const PIECE: u32 = 1 << 14;

/// What is kept of every record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Payloads: one for the light by reflection, and where there is a sky one for its own.
    pub payloads: u32,
    /// The horizon, if records are to tell what is hidden from them.
    pub horizon: Option<Horizon>,
}

/// The store.
pub struct Records {
    device: Arc<Device>,
    shape: Shape,
    pieces: Vec<Buffers>,
    /// Records of a piece.
    piece: u32,
    index: Index,
    count: u32,
}

struct Buffers {
    records: Buffer,
    payloads: Buffer,
    horizons: Buffer,
}

impl Records {
    /// An empty store.
    ///
    /// # Errors
    /// The device has no memory left.
    pub fn new(device: &Arc<Device>, shape: Shape) -> Result<Self> {
        let piece = piece_of(device.capabilities.limits.max_storage_buffer_range, shape);
        let (pieces, index) = (vec![Buffers::new(device, shape, piece)?], Index::new(device, piece)?);
        Ok(Self { device: device.clone(), shape, pieces, piece, index, count: 0 })
    }

    /// Number of records.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// What is kept of each.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The device that it is on.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Forgets all records but the first `count`.
    pub fn truncate(&mut self, count: u32) {
        self.count = self.count.min(count);
    }

    /// Where they are found.
    pub fn index(&self) -> &Index {
        &self.index
    }

    /// The pieces of the store, in order.
    pub fn pieces(&self) -> impl Iterator<Item = Piece<'_>> {
        let entries = &self.index.entries;
        self.pieces.iter().map(move |Buffers { records, payloads, horizons }| Piece {
            records,
            payloads,
            horizons,
            entries,
        })
    }

    /// Makes room for `more` records; whether buffers were added or replaced.
    ///
    /// # Errors
    /// The device has no memory left, or the index would exceed the device's largest storage buffer.
    pub fn reserve(&mut self, more: u32) -> Result<bool> {
        let needed = self.count + more;
        let pieces = needed.div_ceil(self.piece) as usize;
        let grows = pieces > self.pieces.len();
        while self.pieces.len() < pieces {
            self.pieces.push(Buffers::new(&self.device, self.shape, self.piece)?);
        }
        if needed > self.index.capacity {
            let index = Index::new(&self.device, needed.next_power_of_two())?;
            copy(&self.device, &self.index.entries, &index.entries)?;
            self.index = index;
        }
        Ok(grows)
    }

    /// Takes `count` records that are about to be kept, for which there is room: their runs, a piece each.
    pub fn take(&mut self, count: u32) -> Vec<(usize, Run)> {
        let first = self.count;
        self.count += count;
        let run = |(piece, range): (usize, Range<u32>)| {
            let number = self.first_of(piece) + range.start;
            (piece, Run { from: number - first, to: range.start, number, count: range.len() as u32 })
        };
        self.by_piece(first..self.count).map(run).collect()
    }

    /// The part of each piece that a range of numbers covers: the piece, the range within it.
    pub fn by_piece(&self, range: Range<u32>) -> impl Iterator<Item = (usize, Range<u32>)> + use<> {
        by_piece(range, self.piece)
    }

    /// Number in the store of the first record of a piece.
    pub fn first_of(&self, piece: usize) -> u32 {
        piece as u32 * self.piece
    }
}

fn by_piece(range: Range<u32>, size: u32) -> impl Iterator<Item = (usize, Range<u32>)> {
    (range.start / size..range.end.div_ceil(size)).map(move |piece| {
        let start = piece * size;
        (piece as usize, range.start.max(start) - start..range.end.min(start + size) - start)
    })
}

/// Records of a piece where a buffer has `range` bytes at most: a power of two.
fn piece_of(range: u32, shape: Shape) -> u32 {
    let largest = size_of::<Kept>().max(shape.payloads as usize * size_of::<KeptPayload>()).max(shape.horizon_bytes());
    1 << PIECE.min(range / largest as u32).max(1).ilog2()
}

/// Copies all of `from` to the start of `to`, and waits.
pub(super) fn copy(device: &Arc<Device>, from: &Buffer, to: &Buffer) -> Result<()> {
    let commands = Commands::begin(device)?;
    commands.copy_buffer(from, to, from.size);
    commands.finish()
}

impl Buffers {
    fn new(device: &Arc<Device>, shape: Shape, piece: u32) -> Result<Self> {
        let buffer = |bytes: u64| Buffer::new(device, "kept records", u64::from(piece) * bytes, Memory::Device);
        Ok(Self {
            records: buffer(size_of::<Kept>() as u64)?,
            payloads: buffer(u64::from(shape.payloads) * size_of::<KeptPayload>() as u64)?,
            horizons: match shape.horizon {
                Some(horizon) => buffer(horizon.bytes())?,
                None => Buffer::new(device, "kept records", 4, Memory::Device)?,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_split_where_pieces_end() {
        let parts: Vec<_> = by_piece(PIECE - 3..2 * PIECE + 5, PIECE).collect();
        assert_eq!(parts, [(0, PIECE - 3..PIECE), (1, 0..PIECE), (2, 0..5)]);
        assert_eq!(by_piece(5..5, PIECE).map(|(_, range)| range.len()).sum::<usize>(), 0);
    }

    #[test]
    fn pieces_fit_into_the_devices_buffers() {
        let shape = |horizon| Shape { payloads: 2, horizon };
        let full = shape(Some(Horizon { size: 32 }));
        assert_eq!([1 << 27, 1_000_000, 3000, 1].map(|range| piece_of(range, full)), [PIECE, 512, 2, 1]);
        assert_eq!(piece_of(1_000_000, shape(None)), 4096);
    }
}

//! Records off the device: all that a store holds, to be put into another one.

use super::{Records, Shape};
use crate::vk::gpu_types::{Entry, Kept, KeptPayload};
use crate::vk::{Buffer, Commands, Device, Memory, Result};
use bytemuck::Pod;
use std::sync::Arc;

/// Words of 32 bits of a record's place: position, R, normal, largest value of the horizon, tangent, the normal as the index has it,
/// reach.
const PLACE: usize = 13;
/// Words of a payload.
const PAYLOAD: usize = 18;

/// Records on the CPU, bit by bit as the passes see them.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// What is kept of each.
    pub shape: Shape,
    /// [`Shape::words`] of each: its place and payloads.
    pub words: Vec<u32>,
    /// [`Shape::horizon_bytes`] of each.
    pub horizons: Vec<u8>,
}

impl Shape {
    /// Words of 32 bits of a record, but for its horizon: 124 bytes, 196 with a sky.
    pub fn words(&self) -> usize {
        PLACE + PAYLOAD * self.payloads as usize
    }

    /// Bytes of a record's horizon.
    pub fn horizon_bytes(&self) -> usize {
        self.horizon.map_or(0, |horizon| horizon.bytes() as usize)
    }
}

impl Stored {
    /// No records.
    pub fn none(shape: Shape) -> Self {
        Self { shape, words: Vec::new(), horizons: Vec::new() }
    }

    /// Number of records.
    pub fn count(&self) -> u32 {
        (self.words.len() / self.shape.words()) as u32
    }

    fn push(&mut self, kept: &Kept, entry: &Entry, payloads: &[KeptPayload]) {
        let place = [&kept.position[..], &kept.normal, &kept.tangent[..3]].concat();
        self.words.extend(place.iter().map(|value| value.to_bits()));
        self.words.extend([entry.about[0], entry.about[2]]);
        for payload in payloads {
            let values = [&payload.irradiance[..], payload.change.as_flattened(), &payload.most[..2]].concat();
            self.words.extend(values.iter().map(|value| value.to_bits()));
        }
    }

    /// The `number`-th record as passes take it.
    fn record(&self, number: u32) -> (Kept, Entry, Vec<KeptPayload>) {
        let size = self.shape.words();
        let words = &self.words[number as usize * size..][..size];
        let four = |at: usize| std::array::from_fn(|i| f32::from_bits(words[at + i]));
        let [x, y, z] = std::array::from_fn(|i| f32::from_bits(words[8 + i]));
        let kept = Kept { position: four(0), normal: four(4), tangent: [x, y, z, 0.0] };
        let entry = Entry { place: kept.position, about: [words[11], number, words[12], 0] };
        let payload = |index| {
            let at = PLACE + PAYLOAD * index as usize;
            let most = [16, 17].map(|i| f32::from_bits(words[at + i]));
            let change = [at + 4, at + 8, at + 12].map(four);
            KeptPayload { irradiance: four(at), change, most: [most[0], most[1], 0.0, 0.0] }
        };
        (kept, entry, (0..self.shape.payloads).map(payload).collect())
    }
}

impl Records {
    /// Reads all records.
    ///
    /// # Errors
    /// The device fails or has no memory left.
    pub fn stored(&self) -> Result<Stored> {
        let mut stored = Stored::none(self.shape);
        let entries: Vec<Entry> = read(&self.device, &self.index.entries, self.count as usize)?;
        let payloads = self.shape.payloads as usize;
        for (piece, range) in self.by_piece(0..self.count) {
            let (buffers, count) = (&self.pieces[piece], range.len());
            let kept: Vec<Kept> = read(&self.device, &buffers.records, count)?;
            let carried: Vec<KeptPayload> = read(&self.device, &buffers.payloads, count * payloads)?;
            let entries = &entries[self.first_of(piece) as usize..];
            for ((kept, entry), carried) in kept.iter().zip(entries).zip(carried.chunks(payloads)) {
                stored.push(kept, entry, carried);
            }
            stored.horizons.extend(read::<u8>(&self.device, &buffers.horizons, count * self.shape.horizon_bytes())?);
        }
        Ok(stored)
    }

    /// Takes over records of the same shape in place of those that there are.
    ///
    /// # Errors
    /// The device fails or has no memory left.
    pub fn replace_by(&mut self, stored: &Stored) -> Result<()> {
        assert_eq!(self.shape, stored.shape, "records of one shape");
        self.count = 0;
        let count = stored.count();
        self.reserve(count)?;
        let mut entries = Vec::with_capacity(count as usize);
        let horizon = self.shape.horizon_bytes();
        for (piece, range) in self.by_piece(0..count) {
            let first = self.first_of(piece);
            let (mut kept, mut payloads) = (Vec::new(), Vec::new());
            for number in first..first + range.len() as u32 {
                let (record, entry, carried) = stored.record(number);
                kept.push(record);
                entries.push(entry);
                payloads.extend(carried);
            }
            let buffers = &self.pieces[piece];
            buffers.records.upload(&kept)?;
            buffers.payloads.upload(&payloads)?;
            buffers.horizons.upload(&stored.horizons[first as usize * horizon..][..range.len() * horizon])?;
        }
        self.index.entries.upload(&entries)?;
        self.count = count;
        Ok(())
    }
}

/// The first `count` values of a buffer.
fn read<T: Pod>(device: &Arc<Device>, buffer: &Buffer, count: usize) -> Result<Vec<T>> {
    let bytes = (count * size_of::<T>()) as u64;
    if bytes == 0 {
        return Ok(Vec::new());
    }
    let readback = Buffer::new(device, "read-back", bytes, Memory::Readback)?;
    let commands = Commands::begin(device)?;
    commands.copy_buffer(buffer, &readback, bytes);
    commands.finish()?;
    Ok(readback.read(count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::keep_records::Horizon;

    #[test]
    fn records_come_back_bit_by_bit() {
        let shape = Shape { payloads: 2, horizon: Some(Horizon { size: 32 }) };
        assert_eq!((4 * shape.words(), shape.horizon_bytes()), (196, 1024));
        assert_eq!(4 * Shape { payloads: 1, horizon: None }.words(), 124);
        let mut stored = Stored::none(shape);
        let kept = |x: f32| Kept {
            position: [x, 2.0, 3.0, -1.0],
            normal: [0.6, 0.8, -0.0, 5.0],
            tangent: [f32::MIN_POSITIVE, 0.25, x, 0.0],
        };
        let payload = |x: f32| KeptPayload {
            irradiance: [x, 1.0, 2.0, 3.0],
            change: [[4.0, 5.0, 6.0, 7.0], [x, 8.0, 9.0, 10.0], [11.0, 12.0, 13.0, x]],
            most: [x, 14.0, 0.0, 0.0],
        };
        for number in 0..3 {
            let x = number as f32 + 0.1;
            let entry = Entry { place: kept(x).position, about: [77, number, 88, 0] };
            stored.push(&kept(x), &entry, &[payload(x), payload(-x)]);
            assert_eq!(stored.record(number), (kept(x), entry, vec![payload(x), payload(-x)]));
        }
        assert_eq!(stored.count(), 3);
    }
}

//! A block of records: their bytes in an order that packs well, packed (DEFLATE, RFC 1951).
//!
//! Records are alike: bytes of one meaning lie side by side. Neighbouring columns of a horizon see the same walls: what is
//! packed is each byte's difference from the one to its left, less what the row below says of it.

use super::parts::{Parts, checksum};
use crate::methods::records::{Shape, Stored};
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use std::io::{self, Read, Write};
use std::ops::Range;

/// Rows of a horizon, a byte each in every column.
const ROWS: usize = 8;

/// Writes a range of records.
pub fn write(sink: &mut Vec<u8>, stored: &Stored, range: Range<u32>) -> io::Result<()> {
    let (count, shape) = (range.len(), stored.shape);
    let at = |size: usize| range.start as usize * size..range.end as usize * size;
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::new(6));
    encoder.write_all(&planes(&stored.words[at(shape.words())], count))?;
    encoder.write_all(&differences(&stored.horizons[at(shape.horizon_bytes())], shape))?;
    let packed = encoder.finish()?;
    let [count, length] = [count as u32, packed.len() as u32].map(u32::to_le_bytes);
    sink.write_all(&count)?;
    sink.write_all(&length)?;
    sink.write_all(&checksum(&[&count, &length, &packed]).to_le_bytes())?;
    sink.write_all(&packed)
}

/// Adds a block of `count` records.
pub fn read(parts: &mut Parts<'_>, stored: &mut Stored, count: u32) -> Result<(), &'static str> {
    const CUT: &str = "it ends";
    const DAMAGED: &str = "it is damaged: there is another checksum";
    let found = parts.word().ok_or(CUT)?;
    let length = parts.word().ok_or(CUT)?;
    let sum = parts.long().ok_or(CUT)?;
    let packed = parts.bytes(length as usize).ok_or(if found == count { CUT } else { DAMAGED })?;
    if found != count || checksum(&[&found.to_le_bytes(), &length.to_le_bytes(), packed]) != sum {
        return Err(DAMAGED);
    }
    let (shape, count) = (stored.shape, count as usize);
    let (words, horizons) = (4 * shape.words() * count, shape.horizon_bytes() * count);
    let mut bytes = Vec::with_capacity(words + horizons);
    let unpacked = DeflateDecoder::new(packed).take((words + horizons) as u64).read_to_end(&mut bytes);
    if unpacked.ok() != Some(words + horizons) {
        return Err(DAMAGED);
    }
    stored.words.extend(from_planes(&bytes[..words], count));
    stored.horizons.extend(from_differences(&bytes[words..], shape));
    Ok(())
}

/// The first bytes of the first words of `count` records, their second bytes, and so on.
fn planes(words: &[u32], count: usize) -> Vec<u8> {
    let size = words.len() / count.max(1);
    let byte = |plane: usize| move |record: usize| words[record * size + plane / 4].to_le_bytes()[plane % 4];
    (0..4 * size).flat_map(|plane| (0..count).map(byte(plane))).collect()
}

fn from_planes(bytes: &[u8], count: usize) -> Vec<u32> {
    let size = bytes.len() / count.max(1) / 4;
    let word = |record: usize, word: usize| {
        u32::from_le_bytes(std::array::from_fn(|byte| bytes[(4 * word + byte) * count + record]))
    };
    (0..count).flat_map(|record| (0..size).map(move |w| word(record, w))).collect()
}

/// What a byte of a horizon is taken to be: the one to its left, and as far from it as the one below is from its own left.
fn guess(row: usize, column: usize, byte: impl Fn(usize, usize) -> u8) -> u8 {
    match (row, column) {
        (0, 0) => 0,
        (0, _) => byte(0, column - 1),
        (_, 0) => byte(row - 1, 0),
        _ => {
            let (left, below, corner) = (byte(row, column - 1), byte(row - 1, column), byte(row - 1, column - 1));
            // The median of left, below and left + below − corner (Weinberger, Seroussi and Sapiro 2000, LOCO-I).
            let (low, high) = (left.min(below), left.max(below));
            let straight = i16::from(left) + i16::from(below) - i16::from(corner);
            straight.clamp(i16::from(low), i16::from(high)) as u8
        }
    }
}

/// The horizons' bytes less what they are taken to be: row by row of one record after the other.
fn differences(horizons: &[u8], shape: Shape) -> Vec<u8> {
    let size = shape.horizon_bytes();
    let mut all = Vec::with_capacity(horizons.len());
    for horizon in horizons.chunks(size.max(1)) {
        let byte = |row: usize, column: usize| horizon[ROWS * column + row];
        for row in 0..ROWS {
            all.extend((0..size / ROWS).map(|column| byte(row, column).wrapping_sub(guess(row, column, byte))));
        }
    }
    all
}

fn from_differences(bytes: &[u8], shape: Shape) -> Vec<u8> {
    let size = shape.horizon_bytes();
    let mut all = vec![0; bytes.len()];
    for (horizon, bytes) in all.chunks_mut(size.max(1)).zip(bytes.chunks(size.max(1))) {
        for row in 0..ROWS {
            for column in 0..size / ROWS {
                let taken = guess(row, column, |row, column| horizon[ROWS * column + row]);
                horizon[ROWS * column + row] = bytes[row * (size / ROWS) + column].wrapping_add(taken);
            }
        }
    }
    all
}

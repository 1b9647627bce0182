//! Records in a file: used again by the next run, and by others.
//!
//! A file begins with eight letters, the order of its bytes, its format and a header: what the records were made of ([`Origin`]), what
//! is kept of each and how many there are. Blocks of records follow. Header and blocks have checksums, and the file ends where they
//! end. It is used whole or not at all: records of another scene, other lights or settings would be wrong light.

mod block;
mod origin;
mod parts;

pub use origin::Origin;

use super::{Shape, Stored};
use crate::image::write::{WriteError, write_atomic};
use crate::passes::keep_records::Horizon;
use parts::Parts;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

const LETTERS: &[u8; 8] = b"hemicube";
/// How this program's bytes are ordered in the file.
const ORDER: [u8; 4] = [4, 3, 2, 1];
/// Number of the format: another one for every change of what the bytes mean.
const FORMAT: u32 = 1;
/// Records of a block.
const BLOCK: u32 = 1024;
/// A header is shorter.
const LONGEST_HEADER: u32 = 1 << 16;

/// A file of records that cannot be used.
#[derive(Debug, Error)]
#[error("cannot use the records in {path:?}: {why}; delete the file or name another one")]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, in words.
    pub why: String,
}

/// What stands before the records.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    origin: Origin,
    payloads: u32,
    /// Texels a side of the hemicubes whose horizons are kept.
    horizon: Option<u32>,
    records: u32,
}

/// Writes records and what they were made of: the whole file, or none of it.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, origin: &Origin, stored: &Stored) -> Result<(), WriteError> {
    Packed::default().write(path, origin, stored)
}

/// Blocks of records that were written before: they are packed once, and more records follow.
#[derive(Default)]
pub struct Packed(Vec<Vec<u8>>);

impl Packed {
    /// Writes records, the first of which are those that it wrote before.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, path: &Path, origin: &Origin, stored: &Stored) -> Result<(), WriteError> {
        let header = Header {
            origin: origin.clone(),
            payloads: stored.shape.payloads,
            horizon: stored.shape.horizon.map(|horizon| horizon.size),
            records: stored.count(),
        };
        write_atomic(path, |sink| {
            let header = serde_json::to_vec(&header).map_err(io::Error::other)?;
            sink.write_all(LETTERS)?;
            sink.write_all(&ORDER)?;
            sink.write_all(&FORMAT.to_le_bytes())?;
            sink.write_all(&(header.len() as u32).to_le_bytes())?;
            sink.write_all(&parts::checksum(&[&header]).to_le_bytes())?;
            sink.write_all(&header)?;
            for number in self.0.len() as u32..stored.count().div_ceil(BLOCK) {
                let first = number * BLOCK;
                let mut block = Vec::new();
                block::write(&mut block, stored, first..(first + BLOCK).min(stored.count()))?;
                self.0.push(block);
            }
            self.0.iter().try_for_each(|block| sink.write_all(block))?;
            // The last one may have room for more.
            self.0.truncate((stored.count() / BLOCK) as usize);
            Ok(())
        })
    }
}

/// Reads records that were made of `origin`.
///
/// # Errors
/// The file cannot be read, is something else, is damaged or cut off, or its records are of another origin.
pub fn read(path: &Path, origin: &Origin) -> Result<Stored, FileError> {
    let read = || {
        let bytes = std::fs::read(path).map_err(|error| format!("it cannot be read ({error})"))?;
        parse(&bytes, origin)
    };
    read().map_err(|why| FileError { path: path.to_owned(), why })
}

fn parse(bytes: &[u8], origin: &Origin) -> Result<Stored, String> {
    let mut parts = Parts(bytes);
    let header = header(&mut parts)?;
    if let Some(difference) = origin.difference(&header.origin) {
        return Err(difference);
    }
    let shape = Shape { payloads: header.payloads, horizon: header.horizon.map(|size| Horizon { size }) };
    let mut stored = Stored::none(shape);
    let blocks = header.records.div_ceil(BLOCK);
    for number in 0..blocks {
        let count = (header.records - number * BLOCK).min(BLOCK);
        let read = block::read(&mut parts, &mut stored, count);
        read.map_err(|fault| format!("{fault} in block {} of {blocks}", number + 1))?;
    }
    if parts.0.is_empty() { Ok(stored) } else { Err("it goes on after its last record".into()) }
}

fn header(parts: &mut Parts<'_>) -> Result<Header, String> {
    let foreign = || String::from("it is no file of records that hemicube wrote");
    if parts.bytes(8).is_none_or(|letters| letters != LETTERS) {
        return Err(foreign());
    }
    let cut = || String::from("it ends in its header");
    let order = parts.bytes(4).ok_or_else(cut)?;
    if order.iter().rev().eq(&ORDER) {
        return Err("it has the byte order of another kind of machine".into());
    }
    if order != ORDER {
        return Err(foreign());
    }
    let format = parts.word().ok_or_else(cut)?;
    if format != FORMAT {
        return Err(format!("it has version {format} of the format, and this hemicube reads version {FORMAT}"));
    }
    let damaged = || String::from("it is damaged: its header does not fit its checksum");
    let length = parts.word().ok_or_else(cut)?;
    if length > LONGEST_HEADER {
        return Err(damaged());
    }
    let checksum = parts.long().ok_or_else(cut)?;
    let text = parts.bytes(length as usize).ok_or_else(cut)?;
    if parts::checksum(&[text]) != checksum {
        return Err(damaged());
    }
    serde_json::from_slice(text).map_err(|_| damaged())
}

#[cfg(test)]
mod tests;

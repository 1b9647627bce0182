//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views that hold meshoptimizer's codes.
//!
//! The two differ in what their encoders may write (newer vertex codes and the colour filter), which the decoder tells
//! from the data itself.

use super::error::{Fault, Kind, Result};
use super::views;
use gltf::json::buffer::View;
use meshopt::ffi;
use serde::Deserialize;
use serde_json::Value;

/// The densest code, a zero block of the vertex codec, holds about this many decoded bytes a byte.
const LARGEST_RATIO: u64 = 2048;
/// Decoded bytes allowed in any case, for short codes.
const SMALL: u64 = 1 << 16;

/// The extension object on a buffer view.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compression {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: usize,
    pub count: u64,
    pub mode: Mode,
    #[serde(default)]
    pub filter: Filter,
}

/// What the code describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What is done to decoded attributes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// The compression of a view, if it has one.
pub fn of_view(view: &View) -> Result<Option<Compression>> {
    let Some(extensions) = &view.extensions else { return Ok(None) };
    let names = ["KHR_meshopt_compression", "EXT_meshopt_compression"];
    let Some((name, value)) = names.iter().find_map(|n| Some((n, extensions.others.get(*n)?))) else {
        return Ok(None);
    };
    parse(value).map(Some).map_err(|f| f.within(name))
}

fn parse(value: &Value) -> Result<Compression> {
    let c = Compression::deserialize(value).map_err(Fault::invalid)?;
    let stride_fits = match c.mode {
        Mode::Attributes => c.byte_stride.is_multiple_of(4) && (4..=256).contains(&c.byte_stride),
        Mode::Triangles => matches!(c.byte_stride, 2 | 4) && c.count.is_multiple_of(3),
        Mode::Indices => matches!(c.byte_stride, 2 | 4),
    };
    let filter_fits = match c.filter {
        Filter::None => true,
        _ if c.mode != Mode::Attributes => false,
        Filter::Octahedral | Filter::Color => matches!(c.byte_stride, 4 | 8),
        Filter::Quaternion => c.byte_stride == 8,
        Filter::Exponential => true,
    };
    if !stride_fits || !filter_fits {
        return Err(Fault::invalid(format!(
            "byteStride {} or count {} does not fit mode {:?} with filter {:?}",
            c.byte_stride, c.count, c.mode, c.filter
        )));
    }
    Ok(c)
}

/// Decoded bytes, aligned as the decoder's word-wise filters want them.
pub struct Decoded {
    words: Vec<u64>,
    length: usize,
}

impl Decoded {
    fn zeros(length: usize) -> Self {
        Self { words: vec![0; length.div_ceil(8)], length }
    }

    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words)[..self.length]
    }
}

/// Decodes a compressed view out of `buffer`.
pub fn decode(c: &Compression, buffer: &[u8]) -> Result<Decoded> {
    let code = views::range(buffer, c.byte_offset, c.byte_length, &format!("buffer {}", c.buffer))?;
    let size = c.count.checked_mul(c.byte_stride as u64);
    let allowed = (code.len() as u64).saturating_mul(LARGEST_RATIO).saturating_add(SMALL);
    let Some(size) = size.filter(|s| *s <= allowed) else {
        let what = format!("claims {} elements of {} bytes from {} bytes of code", c.count, c.byte_stride, code.len());
        return Err(Fault::new(Kind::TooLarge, what));
    };
    let mut out = Decoded::zeros(size as usize);
    if run(c, code, &mut bytemuck::cast_slice_mut(&mut out.words)[..out.length]) != 0 {
        return Err(Fault::invalid("the meshopt code is broken"));
    }
    Ok(out)
}

/// Runs the decoder and the filter; the decoder's result, 0 for success.
fn run(c: &Compression, code: &[u8], out: &mut [u8]) -> i32 {
    let (count, stride) = (c.count as usize, c.byte_stride);
    debug_assert_eq!(out.len(), count * stride);
    let (to, from, length) = (out.as_mut_ptr().cast(), code.as_ptr(), code.len());
    // SAFETY: `out` holds `count × stride` bytes and `code` holds `length`; `parse` has checked the stride against the
    // mode and the filter, which are all that the C functions assert. They are made for untrusted codes.
    unsafe {
        let result = match c.mode {
            Mode::Attributes => ffi::meshopt_decodeVertexBuffer(to, count, stride, from, length),
            Mode::Triangles => ffi::meshopt_decodeIndexBuffer(to, count, stride, from, length),
            Mode::Indices => ffi::meshopt_decodeIndexSequence(to, count, stride, from, length),
        };
        match c.filter {
            _ if result != 0 => {}
            Filter::None => {}
            Filter::Octahedral => ffi::meshopt_decodeFilterOct(to, count, stride),
            Filter::Quaternion => ffi::meshopt_decodeFilterQuat(to, count, stride),
            Filter::Exponential => ffi::meshopt_decodeFilterExp(to, count, stride),
            Filter::Color => ffi::meshopt_decodeFilterColor(to, count, stride),
        }
        result
    }
}

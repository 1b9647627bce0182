//! Buffers and buffer views, read when first used.

use super::accessor::Decompressed;
use super::container::{Container, Resolver, fetch};
use super::document::{Document, item};
use super::error::{Fault, Result, Within, label};
use super::{Notes, compressed, views};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell, RefCell};

/// Largest buffer without URI that is read as zeros.
const NAMELESS: u64 = 1 << 16;

/// Bytes of a view and the distance between its elements, where it states one.
#[derive(Clone, Copy)]
pub struct ViewBytes<'a> {
    pub bytes: &'a [u8],
    pub stride: Option<usize>,
}

/// All buffers of a document. Each buffer is fetched and each compressed view decoded at most once, when first asked
/// for: a fallback buffer that nothing reads need not exist.
pub struct Buffers<'a> {
    document: &'a Document,
    bin: Option<&'a [u8]>,
    is_glb: bool,
    resolve: &'a Resolver<'a>,
    buffers: Vec<OnceCell<Result<Cow<'a, [u8]>>>>,
    decoded: Vec<OnceCell<Result<compressed::Decoded>>>,
    /// What Draco code holds in place of accessors.
    decompressed: Vec<OnceCell<Decompressed>>,
    /// Bytes fetched so far.
    fetched: Cell<u64>,
    /// What was tolerated while fetching.
    notes: RefCell<Notes>,
}

impl<'a> Buffers<'a> {
    pub fn new(document: &'a Document, container: &Container<'a>, resolve: &'a Resolver<'a>) -> Self {
        let buffers = document.buffers.iter().map(|_| OnceCell::new()).collect();
        let decoded = document.views.iter().map(|_| OnceCell::new()).collect();
        Self {
            document,
            bin: container.bin,
            is_glb: container.is_glb,
            resolve,
            buffers,
            decoded,
            decompressed: document.accessors.iter().map(|_| OnceCell::new()).collect(),
            fetched: Cell::new(0),
            notes: RefCell::default(),
        }
    }

    /// Bytes fetched so far: the size of the input that a scene may be in proportion to.
    pub fn fetched_bytes(&self) -> u64 {
        self.fetched.get()
    }

    /// What stands for an accessor, where Draco code held it.
    pub fn decompressed(&self, accessor: usize) -> Option<&Decompressed> {
        self.decompressed.get(accessor)?.get()
    }

    /// Lets `values` stand for an accessor; the first ones count.
    pub fn set_decompressed(&self, accessor: usize, values: Decompressed) {
        self.decompressed.get(accessor).map(|place| place.set(values).ok());
    }

    /// Takes what was tolerated while fetching.
    pub fn take_notes(&self) -> Notes {
        self.notes.take()
    }

    /// The bytes that `uri` names, counted.
    pub fn fetch(&self, uri: &str) -> Result<Vec<u8>> {
        let bytes = fetch(uri, self.resolve, &mut self.notes.borrow_mut())?;
        self.fetched.set(self.fetched.get().saturating_add(bytes.len() as u64));
        Ok(bytes)
    }

    /// Bytes of a view, decompressed where EXT_meshopt_compression says so.
    pub fn view(&self, index: usize) -> Result<ViewBytes<'_>> {
        let view = item(&self.document.views, "bufferView", index)?;
        let at = || label("bufferView", index, view.name.as_deref());
        if let Some(compression) = compressed::of_view(view).within(at)? {
            let decode = || compressed::decode(&compression, self.buffer(compression.buffer)?);
            let decoded = self.decoded[index].get_or_init(decode).as_ref().map_err(Clone::clone).within(at)?;
            return Ok(ViewBytes { bytes: decoded.bytes(), stride: Some(compression.byte_stride) });
        }
        let buffer = self.buffer(view.buffer.value()).within(at)?;
        let offset = view.byte_offset.map_or(0, |o| o.0);
        let bytes = views::range(buffer, offset, view.byte_length.0, &format!("buffer {}", view.buffer.value()));
        Ok(ViewBytes { bytes: bytes.within(at)?, stride: view.byte_stride.map(|s| s.0).filter(|s| *s > 0) })
    }

    /// All bytes of a buffer.
    fn buffer(&self, index: usize) -> Result<&[u8]> {
        let buffer = item(&self.document.buffers, "buffer", index)?;
        let read = || {
            let bytes = match (&buffer.uri, self.bin) {
                (Some(uri), _) => Cow::Owned(self.fetch(uri)?),
                (None, Some(bin)) if index == 0 => Cow::Borrowed(bin),
                // Legal, and its content is nobody's: zeros. A large one is a file that lost its data.
                (None, _) if !self.is_glb && buffer.byte_length.0 <= NAMELESS => {
                    Cow::Owned(vec![0; buffer.byte_length.0 as usize])
                }
                (None, _) => return Err(Fault::invalid("has no URI, and the file has no binary chunk for it")),
            };
            if (bytes.len() as u64) < buffer.byte_length.0 {
                let what = format!("byteLength is {} and there are {} bytes", buffer.byte_length.0, bytes.len());
                return Err(Fault::invalid(what));
            }
            Ok(bytes)
        };
        let bytes = self.buffers[index].get_or_init(read).as_ref().map_err(Clone::clone);
        let bytes = bytes.within(|| label("buffer", index, buffer.name.as_deref()))?;
        Ok(&bytes[..buffer.byte_length.0 as usize])
    }
}

//! Images decoded once, and the samplers that read them.

use super::buffers::Buffers;
use super::document::{Document, item};
use super::error::{Fault, Kind, Result, Within, label};
use crate::scene::{Texture, Wrap};
use gltf::json;
use image::{DynamicImage, ImageDecoder, ImageReader};
use json::texture::{MagFilter, MinFilter, WrappingMode};
use json::validation::Checked;
use std::collections::HashMap;
use std::io::Cursor;

/// Texels that a byte of a compressed image may stand for; beyond this they come from the store's reserve.
const TEXELS_PER_BYTE: u64 = 8192;

/// Wrapping along u and v, and whether the nearest texel is read.
type Sampling = ([Wrap; 2], bool);

/// Textures in the order in which materials ask for them.
pub struct TextureStore<'a, 'b> {
    document: &'a Document,
    buffers: &'a Buffers<'b>,
    /// Decoded textures, to become the scene's.
    pub textures: Vec<Texture>,
    known: HashMap<(usize, Sampling), u32>,
    /// Texels still allowed beyond [`TEXELS_PER_BYTE`], and in all.
    reserve: u64,
    left: u64,
}

impl<'a, 'b> TextureStore<'a, 'b> {
    /// A store that decodes at most `texels` texels.
    pub fn new(document: &'a Document, buffers: &'a Buffers<'b>, texels: u64) -> Self {
        let (textures, known) = (Vec::new(), HashMap::new());
        Self { document, buffers, textures, known, reserve: (1 << 25).min(texels), left: texels }
    }

    /// Index of the document's texture `index` among the decoded ones; `None` for a texture that shows no image.
    pub fn get(&mut self, index: usize) -> Result<Option<u32>> {
        let texture = item(&self.document.textures, "texture", index)?;
        let at = || label("texture", index, texture.name.as_deref());
        let Some(image) = source(texture).within(at)? else { return Ok(None) };
        let sampler = texture.sampler.map(|s| item(&self.document.samplers, "sampler", s.value())).transpose();
        let sampling = sampler.within(at)?.map_or(([Wrap::Repeat; 2], false), sampling);
        if let Some(&known) = self.known.get(&(image, sampling)) {
            return Ok(Some(known));
        }
        let mut decoded = self.decode(image)?;
        (decoded.wrap, decoded.nearest) = sampling;
        let place = self.textures.len() as u32;
        self.textures.push(decoded);
        self.known.insert((image, sampling), place);
        Ok(Some(place))
    }

    fn decode(&mut self, index: usize) -> Result<Texture> {
        let image = item(&self.document.images, "image", index)?;
        let uri = image.uri.as_deref().filter(|u| !u.starts_with("data:"));
        let object = || label("image", index, image.name.as_deref().or(uri));
        if let Some(place) = self.known.iter().find_map(|((i, _), place)| (*i == index).then_some(*place)) {
            let copy = self.textures[place as usize].clone();
            self.spend(copy.rgba.len() as u64, 0).within(object)?;
            return Ok(copy);
        }
        let rgba = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => self.buffers.fetch(uri).and_then(|bytes| self.decode_bytes(&bytes)),
            (None, Some(view)) => {
                let buffers = self.buffers;
                buffers.view(view.value()).and_then(|view| self.decode_bytes(view.bytes))
            }
            (None, None) => Err(Fault::invalid("has neither URI nor bufferView")),
        };
        let rgba = rgba.within(object)?;
        Ok(Texture {
            name: image.name.as_deref().or(uri).unwrap_or_default().to_owned(),
            width: rgba.width(),
            height: rgba.height(),
            rgba: rgba.as_raw().as_chunks().0.to_vec(),
            wrap: [Wrap::Repeat; 2],
            nearest: false,
        })
    }

    fn decode_bytes(&mut self, bytes: &[u8]) -> Result<image::RgbaImage> {
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        let reader = reader.map_err(|e| Fault::invalid(format!("cannot be decoded: {e}")))?;
        if reader.format().is_none() {
            if bytes.starts_with(b"\xABKTX ") {
                return Err(Fault::new(
                    Kind::Unsupported,
                    "is KTX2, which is not read; convert it to PNG, JPEG or WebP",
                ));
            }
            return Err(Fault::new(Kind::Invalid, "is neither PNG nor JPEG nor WebP; convert it to one of these"));
        }
        let decoder = reader.into_decoder().map_err(broken)?;
        let (width, height) = decoder.dimensions();
        self.spend(u64::from(width) * u64::from(height), bytes.len() as u64).map_err(|f| Fault {
            what: format!("{width} × {height} texels from {} bytes: {}", bytes.len(), f.what),
            ..f
        })?;
        Ok(DynamicImage::from_decoder(decoder).map_err(broken)?.into_rgba8())
    }

    /// Takes texels off what is allowed, given the bytes that they come from.
    fn spend(&mut self, texels: u64, bytes: u64) -> Result<()> {
        let beyond = texels.saturating_sub(bytes.saturating_mul(TEXELS_PER_BYTE));
        match (self.left.checked_sub(texels), self.reserve.checked_sub(beyond)) {
            (Some(left), Some(reserve)) => {
                (self.left, self.reserve) = (left, reserve);
                Ok(())
            }
            _ => Err(Fault::new(Kind::TooLarge, "the textures have more texels than are allowed; shrink them")),
        }
    }
}

fn broken(error: image::ImageError) -> Fault {
    Fault::invalid(format!("cannot be decoded: {error}"))
}

/// The image that a texture shows: its WebP one (EXT_texture_webp), else its plain one, else none.
fn source(texture: &json::Texture) -> Result<Option<usize>> {
    let webp = texture.extensions.as_ref().and_then(|e| e.others.get("EXT_texture_webp"));
    if let Some(webp) = webp {
        let index = webp.get("source").and_then(serde_json::Value::as_u64);
        return index.map(|i| Some(i as usize)).ok_or_else(|| Fault::invalid("EXT_texture_webp: source is missing"));
    }
    let others: Vec<&str> = texture.extensions.iter().flat_map(|e| e.others.keys()).map(String::as_str).collect();
    let elsewhere = !others.is_empty();
    match texture.source.value() {
        // How the gltf crate says that there is none.
        missing if missing == u32::MAX as usize && elsewhere => Err(Fault::new(
            Kind::Unsupported,
            format!("has only an image of {}, which is not read; re-export with PNG, JPEG or WebP", others.join(", ")),
        )),
        missing if missing == u32::MAX as usize => Ok(None),
        index => Ok(Some(index)),
    }
}

fn sampling(sampler: &json::texture::Sampler) -> Sampling {
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    };
    let nearest = match (sampler.mag_filter, sampler.min_filter) {
        (Some(Checked::Valid(mag)), _) => mag == MagFilter::Nearest,
        (_, Some(Checked::Valid(min))) => min == MinFilter::Nearest,
        _ => false,
    };
    ([wrap(sampler.wrap_s), wrap(sampler.wrap_t)], nearest)
}

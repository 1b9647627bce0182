//! PNG, JPEG and Radiance files of the colour alone: for looking at and for other programs; measuring is done on EXR.

use super::tone::{Look, turbo};
use super::write::write_atomic;
use super::{Picture, WriteError};
use image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, png::PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::io;
use std::path::Path;

/// Differences are invisible, files a fifth of a PNG's.
const JPEG_QUALITY: u8 = 95;

/// Writes a colour layer (`""` is the picture itself) through exposure and tone map; not-a-number shows as magenta.
pub fn write(path: &Path, picture: &Picture, layer: &str, look: Look) -> Result<(), WriteError> {
    write_codes(path, picture.width, picture.height, &codes(path, picture, layer, look)?)
}

/// Writes a colour layer as JPEG of quality 95, through exposure and tone map as [`write()`] does.
pub fn write_jpeg(path: &Path, picture: &Picture, layer: &str, look: Look) -> Result<(), WriteError> {
    let codes = codes(path, picture, layer, look)?;
    write_atomic(path, |sink| {
        let encoder = JpegEncoder::new_with_quality(sink, JPEG_QUALITY);
        let written = encoder.write_image(&codes, picture.width, picture.height, ExtendedColorType::Rgb8);
        written.map_err(plain)
    })
}

/// 8-bit sRGB code values of a colour layer, three a pixel.
fn codes(path: &Path, picture: &Picture, layer: &str, look: Look) -> Result<Vec<u8>, WriteError> {
    let [r, g, b] = colours(path, picture, layer)?;
    Ok((0..picture.pixels()).flat_map(|i| look.apply([r[i], g[i], b[i]])).collect())
}

/// Radiance's `.hdr` of a colour layer: linear values of a common exponent, about 1 % exact. Negative values and what is no number
/// are 0.
pub fn write_hdr(path: &Path, picture: &Picture, layer: &str) -> Result<(), WriteError> {
    let [r, g, b] = colours(path, picture, layer)?;
    let value = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, f32::MAX) };
    let pixels: Vec<_> = (0..picture.pixels()).map(|i| image::Rgb([r[i], g[i], b[i]].map(value))).collect();
    let (width, height) = (picture.width as usize, picture.height as usize);
    write_atomic(path, |sink| HdrEncoder::new(sink).encode(&pixels, width, height).map_err(plain))
}

fn colours<'a>(path: &Path, picture: &'a Picture, layer: &str) -> Result<[&'a [f32]; 3], WriteError> {
    picture.rgb(layer).ok_or_else(|| {
        let cause = io::Error::other(format!("the picture has no colour layer {layer:?}"));
        WriteError { path: path.to_owned(), cause }
    })
}

/// Writes values in false colour: 0 is dark blue, `top` and above dark red, not-a-number magenta.
pub fn write_false_colour(path: &Path, width: u32, height: u32, values: &[f32], top: f32) -> Result<(), WriteError> {
    let codes: Vec<u8> = values.iter().flat_map(|value| turbo(value / top)).collect();
    write_codes(path, width, height, &codes)
}

/// Writes 8-bit sRGB code values, three a pixel, row 0 at the top.
pub fn write_codes(path: &Path, width: u32, height: u32, codes: &[u8]) -> Result<(), WriteError> {
    write_atomic(path, |sink| encode(sink, width, height, codes))
}

/// A PNG file of 8-bit sRGB code values, into any sink.
pub fn encode(sink: impl io::Write, width: u32, height: u32, codes: &[u8]) -> io::Result<()> {
    let encoder = PngEncoder::new(sink);
    encoder.write_image(codes, width, height, ExtendedColorType::Rgb8).map_err(plain)
}

/// The system's own error where there is one.
fn plain(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::*;

    #[test]
    fn file_holds_the_tone_mapped_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.png"), folder.path().join("b.png"));
        let picture = sample(9, 5);
        let look = Look { stops: 1.0, ..Look::default() };
        write(&a, &picture, "direct", look).unwrap();
        write(&b, &picture, "direct", look).unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
        let read = image::open(&a).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (9, 5));
        let [r, g, b] = picture.rgb("direct").unwrap();
        assert_eq!(read.get_pixel(4, 2).0, look.apply([r[22], g[22], b[22]]));
    }

    #[test]
    fn other_formats_hold_the_same_picture() {
        let folder = tempfile::tempdir().unwrap();
        let [jpg, hdr] = ["a.jpg", "a.hdr"].map(|name| folder.path().join(name));
        let mut picture = sample(16, 16);
        for (channel, value) in [("R", 0.5), ("G", 0.25), ("B", 2.0)] {
            picture.channels.insert(channel.into(), vec![value; 256]);
        }
        picture.channels.get_mut("R").unwrap()[0] = f32::NAN;
        let look = Look { stops: -1.0, ..Look::default() };
        write_jpeg(&jpg, &picture, "", look).unwrap();
        let read = image::open(&jpg).unwrap().into_rgb8();
        let (is, should) = (read.get_pixel(12, 12).0, look.apply([0.5, 0.25, 2.0]));
        assert!((0..3).all(|k| is[k].abs_diff(should[k]) <= 2), "{is:?}, {should:?}");
        write_hdr(&hdr, &picture, "").unwrap();
        let read = image::open(&hdr).unwrap().into_rgb32f();
        let is = read.get_pixel(12, 12).0;
        assert!(is.iter().zip([0.5, 0.25, 2.0]).all(|(is, should)| (is - should).abs() <= 0.01 * should), "{is:?}");
        assert_eq!(read.get_pixel(0, 0).0[0], 0.0, "what is no number is 0");
    }

    #[test]
    fn missing_layer_is_named_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let error = write(&path, &sample(2, 2), "glow", Look::default()).unwrap_err();
        assert!(error.to_string().contains("glow"), "{error}");
        assert!(!path.exists());
    }
}

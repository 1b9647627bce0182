//! PNG files: 8-bit sRGB, for looking at; measuring is done on EXR.

use super::tone::{Look, turbo};
use super::write::write_atomic;
use super::{Picture, WriteError};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::io;
use std::path::Path;

/// Writes a colour layer (`""` is the picture itself) through exposure and tone map; not-a-number shows as magenta.
pub fn write(path: &Path, picture: &Picture, layer: &str, look: Look) -> Result<(), WriteError> {
    let Some([r, g, b]) = picture.rgb(layer) else {
        let cause = io::Error::other(format!("the picture has no colour layer {layer:?}"));
        return Err(WriteError { path: path.to_owned(), cause });
    };
    let codes: Vec<u8> = (0..picture.pixels()).flat_map(|i| look.apply([r[i], g[i], b[i]])).collect();
    write_codes(path, picture.width, picture.height, &codes)
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
    encoder.write_image(codes, width, height, ExtendedColorType::Rgb8).map_err(|error| match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    })
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
    fn missing_layer_is_named_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let error = write(&path, &sample(2, 2), "glow", Look::default()).unwrap_err();
        assert!(error.to_string().contains("glow"), "{error}");
        assert!(!path.exists());
    }
}

//! EXR files: every channel of a picture in one part, 32-bit floats, lossless.

use super::write::write_atomic;
use super::{Picture, WriteError};
use exr::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs::File, io};
use thiserror::Error;

/// Why an EXR file could not be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// Missing, not readable, broken, or a kind of file the decoder does not know (deep data, for instance).
    #[error("cannot read {path:?} as EXR: {message}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// Parts of different sizes have no common pixels.
    #[error("cannot read {path:?}: its parts differ in size ({a:?} and {b:?} pixels); export the layers at one size")]
    Sizes {
        /// The file.
        path: PathBuf,
        /// Width and height of the first part.
        a: (usize, usize),
        /// Width and height of the part that differs.
        b: (usize, usize),
    },
}

/// Writes `picture` to `path`: one part, scan lines, ZIP, Rec.709 primaries; the same bytes each time.
///
/// `settings` are kept as the standard `comments` attribute, one `name: value` a line, in the order given.
pub fn write(path: &Path, picture: &Picture, settings: &[(&str, &str)]) -> std::result::Result<(), WriteError> {
    write_seen(path, picture, settings, None)
}

/// The same, with the standard attribute `worldToCamera`: of row vectors, y up, z in the direction of sight.
pub fn write_seen<S: AsRef<str>>(
    path: &Path,
    picture: &Picture,
    settings: &[(&str, S)],
    world_to_camera: Option<[f32; 16]>,
) -> std::result::Result<(), WriteError> {
    let odd = picture.channels.iter().find(|(_, values)| values.len() != picture.pixels());
    if let Some((name, values)) = odd {
        let cause = io::Error::other(format!("channel {name} has {} of {} pixels", values.len(), picture.pixels()));
        return Err(WriteError { path: path.to_owned(), cause });
    }
    let image = encode(picture, settings, world_to_camera);
    write_atomic(path, |sink| match image.write().to_buffered(sink) {
        Err(Error::Io(error)) => Err(error),
        other => other.map_err(io::Error::other),
    })
}

fn encode<S: AsRef<str>>(
    picture: &Picture,
    settings: &[(&str, S)],
    world_to_camera: Option<[f32; 16]>,
) -> Image<Layer<AnyChannels<FlatSamples>>> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let channel = |(name, values): (&String, &Vec<f32>)| AnyChannel::new(text(name), FlatSamples::F32(values.clone()));
    let channels = AnyChannels::sort(picture.channels.iter().map(channel).collect());
    // One attribute rather than one a setting: the encoder keeps free attributes in a map without order.
    let lines: Vec<String> = settings.iter().map(|(name, value)| format!("{name}: {}", value.as_ref())).collect();
    let attributes = LayerAttributes {
        software_name: Some(concat!("hemicube ", env!("CARGO_PKG_VERSION")).into()),
        world_to_camera,
        comments: (!lines.is_empty()).then(|| text(&lines.join("\n"))),
        ..LayerAttributes::default()
    };
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let mut image = Image::from_layer(Layer::new(size, attributes, encoding, channels));
    image.attributes.chromaticities = Some(REC709);
    image
}

/// As UTF-8, which OpenEXR asks for; the decoder's own conversion panics where a letter is not Latin-1.
fn text(words: &str) -> Text {
    Text::from_slice_unchecked(words.as_bytes())
}

/// ITU-R BT.709-6, table 1, item 1.3 and 1.4.
const REC709: exr::meta::attribute::Chromaticities = exr::meta::attribute::Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Reads every channel of the largest level of every part; 16-bit and integer channels are turned to `f32`.
///
/// A channel of a named part gets that name as prefix unless it has it already (the two ways to write layers).
pub fn read(path: &Path) -> std::result::Result<Picture, ReadError> {
    let fail = |message: String| ReadError::File { path: path.to_owned(), message };
    // Opened here for the system's own words: the decoder calls a missing file "invalid".
    let file = File::open(path).map_err(|error| fail(error.to_string()))?;
    let reader = exr::image::read::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let image = reader.all_attributes().from_unbuffered(file).map_err(|error| fail(explain(&error)))?;
    let first = image.layer_data.first().map(|part| part.size).unwrap_or_default();
    let mut channels = BTreeMap::new();
    for part in &image.layer_data {
        if part.size != first {
            let (a, b) = ((first.0, first.1), (part.size.0, part.size.1));
            return Err(ReadError::Sizes { path: path.to_owned(), a, b });
        }
        let prefix = part.attributes.layer_name.as_ref().filter(|_| image.layer_data.len() > 1);
        for channel in &part.channel_data.list {
            channels.insert(full_name(prefix, &channel.name), channel.sample_data.values_as_f32().collect());
        }
    }
    Ok(Picture { width: first.0 as u32, height: first.1 as u32, channels })
}

fn explain(error: &Error) -> String {
    match error {
        Error::Invalid(text) if text.contains("missing bytes") => "the file ends too early".into(),
        other => other.to_string(),
    }
}

fn full_name(part: Option<&Text>, channel: &Text) -> String {
    let channel = channel.to_string();
    match part.map(Text::to_string) {
        Some(part) if !part.is_empty() && !channel.starts_with(&format!("{part}.")) => format!("{part}.{channel}"),
        _ => channel,
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::*;
    use std::fs;

    #[test]
    fn round_trip_keeps_every_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut picture = sample(37, 19);
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MIN_POSITIVE / 2.0, f32::MAX];
        picture.channels.get_mut("direct.R").unwrap()[..6].copy_from_slice(&odd);
        write(&path, &picture, &[]).unwrap();
        let back = read(&path).unwrap();
        assert_eq!((back.width, back.height), (37, 19));
        let bits = |picture: &Picture| -> Vec<(String, Vec<u32>)> {
            let bits = |values: &Vec<f32>| values.iter().map(|value| value.to_bits()).collect();
            picture.channels.iter().map(|(name, values)| (name.clone(), bits(values))).collect()
        };
        assert_eq!(bits(&back), bits(&picture));
    }

    #[test]
    fn bytes_are_the_same_each_time_and_hold_the_settings() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        let settings = [("accuracy", "0.15"), ("bounces", "1"), ("scene", "Œuvre 部屋.glb")];
        write(&a, &sample(50, 40), &settings).unwrap();
        write(&b, &sample(50, 40), &settings).unwrap();
        let bytes = fs::read(&a).unwrap();
        assert_eq!(bytes, fs::read(&b).unwrap());
        let header = String::from_utf8_lossy(&bytes[..1500]).into_owned();
        assert!(header.contains("accuracy: 0.15\nbounces: 1\nscene: Œuvre 部屋.glb"));
        assert!(header.contains("hemicube 0.") && header.contains("chromaticities"));
    }

    #[test]
    fn half_and_integer_channels_and_named_parts_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("parts.exr");
        let part = |name: &str, channels: Vec<AnyChannel<FlatSamples>>| {
            let list = AnyChannels::sort(channels.into());
            Layer::new((2, 1), LayerAttributes::named(name), Encoding::FAST_LOSSLESS, list)
        };
        let half = FlatSamples::F16(vec![f16::from_f32(0.5), f16::from_f32(2.0)]);
        let parts = [
            part("direct", vec![AnyChannel::new("R", half)]),
            part("id", vec![AnyChannel::new("id.Y", FlatSamples::U32(vec![7, 9]))]),
        ];
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((2, 1)));
        Image::from_layers(attributes, Layers::from_vec(parts.into())).write().to_file(&path).unwrap();
        let picture = read(&path).unwrap();
        assert_eq!(picture.channels["direct.R"], [0.5, 2.0]);
        assert_eq!(picture.channels["id.Y"], [7.0, 9.0]);
    }

    #[test]
    fn what_cannot_be_written_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut short = sample(4, 4);
        short.channels.insert("Z".into(), vec![0.0; 3]);
        for (picture, word) in
            [(short, "channel Z has 3 of 16"), (Picture::new(4, 4), "a.exr"), (sample(0, 0), "a.exr")]
        {
            let message = write(&path, &picture, &[]).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_named_with_its_remedy() {
        let message = write(Path::new("/dev/full"), &sample(8, 8), &[]).unwrap_err().to_string();
        assert!(message.contains("No space left") && message.contains("free some space"), "{message}");
    }

    #[test]
    fn parts_of_different_sizes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sizes.exr");
        let part = |name: &str, width: usize| {
            let channel = AnyChannel::new("R", FlatSamples::F32(vec![1.0; width]));
            let list = AnyChannels::sort([channel].into_iter().collect());
            Layer::new((width, 1), LayerAttributes::named(name), Encoding::UNCOMPRESSED, list)
        };
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((3, 1)));
        let parts = Layers::from_vec(vec![part("a", 2), part("b", 3)]);
        Image::from_layers(attributes, parts).write().to_file(&path).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("sizes.exr") && message.contains("differ in size"), "{message}");
    }

    #[test]
    fn bad_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.exr");
        for bytes in [&b""[..], b"not an image", b"v/1\x01\x02\0\0\0chan"] {
            fs::write(&path, bytes).unwrap();
            let message = read(&path).unwrap_err().to_string();
            assert!(message.contains("bad.exr"), "{message}");
        }
        let message = read(&folder.path().join("none.exr")).unwrap_err().to_string();
        assert!(message.contains("none.exr") && message.contains("No such file"), "{message}");
        write(&path, &sample(64, 64), &[]).unwrap();
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("bad.exr"));
    }
}

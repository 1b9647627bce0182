//! Equirectangular maps from OpenEXR and Radiance files.

use crate::scene::EnvironmentMap;
use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, Layers, ReadChannels, ReadLayers};
use std::path::Path;

/// Most texels of a map: 16384 × 8192.
const MOST_TEXELS: usize = 1 << 27;

type FlatLayer = Layer<AnyChannels<FlatSamples>>;
type FlatImage = Image<Layers<AnyChannels<FlatSamples>>>;

impl EnvironmentMap {
    /// Reads an `.exr` or `.hdr` file. Any shape will do; 2:1 keeps texels square.
    pub fn load(path: &Path) -> Result<Self, String> {
        Self::load_layer(path, None, &mut Vec::new())
    }

    /// Reads a layer of an `.exr` file by its name, or the first that has colour, or an `.hdr` file.
    ///
    /// The map is the display window: texels outside the data window are black, data outside the display window is left
    /// out. A channel that is missing is 0; one of luminance alone is grey. Negative values count as 0, which `notes` hears.
    pub(super) fn load_layer(path: &Path, layer: Option<&str>, notes: &mut Vec<String>) -> Result<Self, String> {
        let is_radiance = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("hdr"));
        let map = if is_radiance { read_radiance(path)? } else { read_exr(path, layer)? };
        map.checked(path, notes)
    }

    /// The same map without negative values, or the pixel that is not a number.
    fn checked(mut self, path: &Path, notes: &mut Vec<String>) -> Result<Self, String> {
        if let Some(i) = self.rgb.iter().position(|texel| texel.iter().any(|x| !x.is_finite())) {
            let (x, y) = (i as u32 % self.width, i as u32 / self.width);
            return Err(format!("pixel ({x}, {y}) is {:?}: not finite; mend the file", self.rgb[i]));
        }
        let is_negative = |texel: &&[f32; 3]| texel.iter().any(|x| *x < 0.0);
        let negative = self.rgb.iter().filter(is_negative).count();
        if negative > 0 {
            let pixels = if negative == 1 { "pixel is" } else { "pixels are" };
            notes.push(format!("background {}: {negative} {pixels} negative and taken as 0", path.display()));
            self.rgb.as_flattened_mut().iter_mut().for_each(|x| *x = x.max(0.0));
        }
        Ok(self)
    }
}

fn black([width, height]: [usize; 2]) -> Result<EnvironmentMap, String> {
    match width.checked_mul(height) {
        None | Some(0) => Err("has no pixels".into()),
        Some(texels) if texels > MOST_TEXELS => Err(format!("has more than {MOST_TEXELS} texels; make it smaller")),
        Some(texels) => Ok(EnvironmentMap { width: width as u32, height: height as u32, rgb: vec![[0.0; 3]; texels] }),
    }
}

fn read_radiance(path: &Path) -> Result<EnvironmentMap, String> {
    let unreadable = |e: &dyn std::fmt::Display| format!("cannot be read: {e}");
    let reader = image::ImageReader::open(path).map_err(|e| unreadable(&e))?;
    let mut reader = reader.with_guessed_format().map_err(|e| unreadable(&e))?;
    if reader.format() != Some(image::ImageFormat::Hdr) {
        return Err("is not a Radiance picture".into());
    }
    reader.no_limits();
    let picture = reader.decode().map_err(|e| unreadable(&e))?.into_rgb32f();
    let mut map = black([picture.width() as usize, picture.height() as usize])?;
    map.rgb = picture.pixels().map(|pixel| pixel.0).collect();
    Ok(map)
}

fn read_exr(path: &Path, wanted: Option<&str>) -> Result<EnvironmentMap, String> {
    let unreadable = |e: exr::error::Error| format!("cannot be read: {e}");
    let headers = exr::meta::MetaData::read_from_file(path, false).map_err(unreadable)?.headers;
    if headers.iter().any(|h| h.layer_size.area() > MOST_TEXELS) {
        return Err(format!("has more than {MOST_TEXELS} texels; make it smaller"));
    }
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level();
    let image: FlatImage = reader.all_channels().all_layers().all_attributes().from_file(path).map_err(unreadable)?;
    let (layer, channels) = choose(&image, wanted)?;
    let window = image.attributes.display_window;
    let mut map = black([window.size.width(), window.size.height()])?;
    let offset = layer.attributes.layer_position - window.position;
    for (component, channel) in channels.iter().enumerate() {
        let Some(samples) = channel.and_then(|c| layer.channel_data.list.get(c)) else { continue };
        let sampling = samples.sampling;
        if sampling != exr::prelude::Vec2(1, 1) {
            return Err(format!("channel {} is subsampled, which is not read", samples.name));
        }
        let width = layer.size.width();
        for (i, value) in samples.sample_data.values_as_f32().enumerate() {
            let (x, y) = (offset.x() as i64 + (i % width) as i64, offset.y() as i64 + (i / width) as i64);
            if (0..i64::from(map.width)).contains(&x) && (0..i64::from(map.height)).contains(&y) {
                map.rgb[y as usize * map.width as usize + x as usize][component] = value;
            }
        }
    }
    Ok(map)
}

/// Places of R, G and B among a layer's channels.
type Rgb = [Option<usize>; 3];

/// A layer, by its part's or its channels' name, and its colour: without a name the first that has colour, those first whose
/// channels have no name before them.
fn choose<'a>(image: &'a FlatImage, wanted: Option<&str>) -> Result<(&'a FlatLayer, Rgb), String> {
    let all: Vec<(String, &FlatLayer, Rgb)> = image.layer_data.iter().flat_map(colours).collect();
    let plain = |name: &str| !name.contains('.');
    let found = match wanted {
        Some(wanted) => all.iter().find(|(name, ..)| name == wanted),
        None => all.iter().find(|(name, ..)| name.is_empty()).or_else(|| {
            let has_name = |(name, ..): &&(String, &FlatLayer, Rgb)| plain(name);
            all.iter().find(has_name).or_else(|| all.first())
        }),
    };
    let names = || all.iter().map(|(name, ..)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    match (found, wanted) {
        (Some((_, layer, rgb)), _) => Ok((layer, *rgb)),
        (None, Some(wanted)) if !all.is_empty() => {
            Err(format!("has no layer \"{wanted}\" with colour; those that have are {}", names()))
        }
        _ => Err("cannot be read: it has neither R, G, B nor luminance".into()),
    }
}

/// The colours of a part: by the name in front of their channels, or the part's own.
fn colours(layer: &FlatLayer) -> Vec<(String, &FlatLayer, Rgb)> {
    let mut found: Vec<(String, &FlatLayer, Rgb)> = Vec::new();
    let part = layer.attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
    for (i, channel) in layer.channel_data.list.iter().enumerate() {
        let name = channel.name.to_string();
        let (prefix, last) = name.rsplit_once('.').unwrap_or(("", &name));
        let components: &[usize] = match last.to_ascii_uppercase().as_str() {
            "R" | "RED" => &[0],
            "G" | "GREEN" => &[1],
            "B" | "BLUE" => &[2],
            "Y" | "L" | "LUMINANCE" => &[0, 1, 2],
            _ => continue,
        };
        let name = if prefix.is_empty() { part.as_str() } else { prefix };
        if found.last().is_none_or(|(last, ..)| last != name) && !found.iter().any(|(n, ..)| n == name) {
            found.push((name.to_owned(), layer, [None; 3]));
        }
        if let Some((.., rgb)) = found.iter_mut().find(|(n, ..)| n == name) {
            // Colour goes before luminance.
            let grey = components.len() == 3;
            for c in components.iter().copied() {
                rgb[c] = if grey { rgb[c].or(Some(i)) } else { Some(i) };
            }
        }
    }
    found
}

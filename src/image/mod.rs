//! Pictures: layered float images, EXR and PNG files, tone mapping, error metrics.
//!
//! A picture is a set of channels; a *layer* is the channels that share a prefix (`direct` is `direct.R`, `direct.G`,
//! `direct.B`; the layer without a name is `R`, `G`, `B`). Colours are linear with Rec.709 primaries.

pub mod exr;
pub mod flip;
pub mod layers;
pub mod metrics;
pub mod png;
pub mod tone;
pub mod write;
pub mod y4m;

use std::collections::BTreeMap;

pub use layers::{LayerError, LayerSet};
pub use write::WriteError;

/// A float image of named channels (`R`, `direct.G`, `N.X`, `Z`, …), each `width × height`, row 0 at the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Channel name as in the EXR file, to its pixels.
    pub channels: BTreeMap<String, Vec<f32>>,
}

/// What the channels of a layer are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `R`, `G`, `B`.
    Colour,
    /// `X`, `Y`, `Z`.
    Vector,
    /// One channel.
    Scalar,
}

/// One layer of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer<'a> {
    /// What the channels are.
    pub kind: Kind,
    /// The channels in the order of their kind.
    pub channels: Vec<&'a [f32]>,
}

impl Picture {
    /// A picture of `width × height` pixels without channels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, channels: BTreeMap::new() }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Red, green and blue of a layer; `""` is the picture itself (`R`, `G`, `B`).
    pub fn rgb(&self, layer: &str) -> Option<[&[f32]; 3]> {
        self.triple(layer, ["R", "G", "B"])
    }

    /// X, Y and Z of a vector layer (`N`, `P`).
    pub fn xyz(&self, layer: &str) -> Option<[&[f32]; 3]> {
        self.triple(layer, ["X", "Y", "Z"])
    }

    /// A layer of one channel, by the channel's name or, as `records` for `records.Y`, by the layer's.
    pub fn scalar(&self, layer: &str) -> Option<&[f32]> {
        let mut own = self.channels.iter().filter(|(channel, _)| layer_of(channel) == layer);
        let only = own.next().filter(|_| own.next().is_none()).map(|(_, values)| values);
        self.channels.get(layer).or(only).map(Vec::as_slice)
    }

    /// The channels of a layer and what they are.
    pub fn layer(&self, layer: &str) -> Option<Layer<'_>> {
        let (kind, channels) = if let Some(rgb) = self.rgb(layer) {
            (Kind::Colour, rgb.to_vec())
        } else if let Some(xyz) = self.xyz(layer) {
            (Kind::Vector, xyz.to_vec())
        } else {
            (Kind::Scalar, vec![self.scalar(layer)?])
        };
        Some(Layer { kind, channels })
    }

    /// Adds or replaces a colour layer, pixels in row order.
    pub fn insert_rgb(&mut self, layer: &str, pixels: impl IntoIterator<Item = [f32; 3]>) {
        self.insert_triple(layer, ["R", "G", "B"], pixels);
    }

    /// Adds or replaces a vector layer, pixels in row order.
    pub fn insert_xyz(&mut self, layer: &str, pixels: impl IntoIterator<Item = [f32; 3]>) {
        self.insert_triple(layer, ["X", "Y", "Z"], pixels);
    }

    /// Adds or replaces one channel by its full name (`Z`, `records.Y`), pixels in row order.
    pub fn insert_scalar(&mut self, channel: &str, pixels: impl IntoIterator<Item = f32>) {
        let values: Vec<f32> = pixels.into_iter().collect();
        debug_assert_eq!(values.len(), self.pixels(), "{channel}: one value a pixel");
        self.channels.insert(channel.to_owned(), values);
    }

    /// NaN and infinite values of each channel that has any.
    pub fn non_finite(&self) -> BTreeMap<&str, usize> {
        let bad = |values: &[f32]| values.iter().filter(|value| !value.is_finite()).count();
        let counts = self.channels.iter().map(|(name, values)| (name.as_str(), bad(values)));
        counts.filter(|&(_, count)| count > 0).collect()
    }

    /// Names of the layers, `""` first where there is one.
    pub fn layers(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.channels.keys().map(|channel| layer_of(channel)).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The same picture with the layers of `set` alone.
    pub fn select(mut self, set: &LayerSet) -> Self {
        self.channels.retain(|channel, _| set.contains(layer_of(channel)));
        self
    }

    fn triple(&self, layer: &str, suffixes: [&str; 3]) -> Option<[&[f32]; 3]> {
        let [a, b, c] = suffixes.map(|suffix| self.channels.get(&channel_name(layer, suffix)).map(Vec::as_slice));
        Some([a?, b?, c?])
    }

    fn insert_triple(&mut self, layer: &str, suffixes: [&str; 3], pixels: impl IntoIterator<Item = [f32; 3]>) {
        let mut columns = [(); 3].map(|()| Vec::with_capacity(self.pixels()));
        for pixel in pixels {
            for (column, value) in columns.iter_mut().zip(pixel) {
                column.push(value);
            }
        }
        debug_assert_eq!(columns[0].len(), self.pixels(), "{layer}: one colour a pixel");
        for (suffix, column) in suffixes.iter().zip(columns) {
            self.channels.insert(channel_name(layer, suffix), column);
        }
    }
}

/// Channel `suffix` of a layer, as EXR files name it.
pub(crate) fn channel_name(layer: &str, suffix: &str) -> String {
    if layer.is_empty() { suffix.to_owned() } else { format!("{layer}.{suffix}") }
}

/// Layer that a channel belongs to: what stands before the last dot; colour and alpha without a dot are layer `""`.
pub(crate) fn layer_of(channel: &str) -> &str {
    match channel.rsplit_once('.') {
        Some((layer, _)) => layer,
        None if matches!(channel, "R" | "G" | "B" | "A") => "",
        None => channel,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A small picture with a colour, a vector and a scalar layer; deterministic values without structure.
    pub(crate) fn sample(width: u32, height: u32) -> Picture {
        let mut picture = Picture::new(width, height);
        let value =
            |i: usize, k: u32| (i as u32).wrapping_mul(2654435761).wrapping_add(k * 40503) as f32 / u32::MAX as f32;
        let pixels = |shift: u32| (0..(width * height) as usize).map(move |i| [0, 1, 2].map(|k| value(i, k + shift)));
        picture.insert_rgb("", pixels(0));
        picture.insert_rgb("direct", pixels(3));
        picture.insert_xyz("N", pixels(6));
        picture.insert_scalar("Z", (0..picture.pixels()).map(|i| value(i, 9)));
        picture.insert_scalar("records.Y", (0..picture.pixels()).map(|i| (i % 5) as f32));
        picture
    }

    #[test]
    fn layers_are_found_by_name() {
        let picture = sample(4, 3);
        assert_eq!(picture.layers(), ["", "N", "Z", "direct", "records"]);
        assert!(picture.rgb("").is_some() && picture.rgb("direct").is_some() && picture.xyz("N").is_some());
        assert!(picture.scalar("Z").is_some() && picture.scalar("records").is_some());
        assert!(picture.rgb("N").is_none() && picture.scalar("N").is_none() && picture.rgb("indirect").is_none());
    }

    #[test]
    fn selecting_keeps_the_colour_and_what_is_named() {
        let picture = sample(4, 3).select(&"N,records".parse().unwrap());
        assert_eq!(picture.layers(), ["", "N", "records"]);
        assert_eq!(sample(4, 3).select(&LayerSet::all()), sample(4, 3));
    }

    #[test]
    fn values_that_are_no_numbers_are_counted() {
        let mut picture = sample(4, 3);
        assert!(picture.non_finite().is_empty());
        picture.channels.get_mut("direct.G").unwrap()[2] = f32::NAN;
        picture.channels.get_mut("Z").unwrap()[0..2].fill(f32::INFINITY);
        assert_eq!(picture.non_finite(), BTreeMap::from([("direct.G", 1), ("Z", 2)]));
    }
}

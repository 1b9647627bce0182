//! What is compared: two files, their layers, the mask.

use super::CompareArgs;
use anyhow::{Context, Result, bail, ensure};
use hemicube::image::metrics::{common_layers, mask};
use hemicube::image::{Kind, Layer, Picture, exr};
use std::path::Path;

/// A layer of each file, in memory of its own as it may be a sum.
pub struct Pair {
    /// As shown: `irradiance = b1 + b2`.
    pub name: String,
    kind: Kind,
    test: Vec<Vec<f32>>,
    reference: Vec<Vec<f32>>,
}

impl Pair {
    /// The test's layer.
    pub fn test_layer(&self) -> Layer<'_> {
        Layer { kind: self.kind, channels: self.test.iter().map(Vec::as_slice).collect() }
    }

    /// The reference's layer.
    pub fn reference_layer(&self) -> Layer<'_> {
        Layer { kind: self.kind, channels: self.reference.iter().map(Vec::as_slice).collect() }
    }
}

/// Reads both files, which must have the same size.
pub fn read_pair(test: &Path, reference: &Path) -> Result<(Picture, Picture)> {
    let (a, b) = (exr::read(test)?, exr::read(reference)?);
    ensure!(
        (a.width, a.height) == (b.width, b.height),
        "{test:?} has {} × {} pixels and {reference:?} {} × {}; render at the reference's --width and --height",
        a.width,
        a.height,
        b.width,
        b.height
    );
    Ok((a, b))
}

/// The layers to compare: those asked for, else those that both files have. Standard errors say how far a picture may be
/// off, and are nothing to be off by themselves.
pub fn resolve(args: &CompareArgs, test: &Picture, reference: &Picture) -> Result<Vec<Pair>> {
    let wanted: Vec<String> = if args.layers.is_empty() {
        let common = common_layers(test, reference).into_iter().filter(|name| !name.starts_with("stderr."));
        common.map(shown).map(str::to_owned).collect()
    } else {
        args.layers.clone()
    };
    ensure!(
        !wanted.is_empty(),
        "the files have no layer in common: {:?} has {}; {:?} has {}; pair them with --layer NAME=NAME",
        args.test,
        list(test),
        args.reference,
        list(reference)
    );
    wanted.iter().map(|spec| pair(spec, args, test, reference)).collect()
}

fn pair(spec: &str, args: &CompareArgs, test: &Picture, reference: &Picture) -> Result<Pair> {
    let (left, right) = spec.split_once('=').unwrap_or((spec, spec));
    let (test_kind, test) = sum(left, test).with_context(|| format!("--layer {spec}: {:?}", args.test))?;
    let (kind, reference) = sum(right, reference).with_context(|| format!("--layer {spec}: {:?}", args.reference))?;
    ensure!(
        test_kind == kind,
        "--layer {spec}: {left} has the channels {} and {right} {}; they cannot be compared",
        channels(test_kind),
        channels(kind)
    );
    let name = if left == right { left.to_owned() } else { format!("{left} = {right}") };
    Ok(Pair { name, kind, test, reference })
}

/// The channels of a layer or of several with `+` between them.
fn sum(names: &str, picture: &Picture) -> Result<(Kind, Vec<Vec<f32>>)> {
    let mut total: Option<(Kind, Vec<Vec<f32>>)> = None;
    for name in names.split('+').map(str::trim) {
        let key = if name == "RGB" { "" } else { name };
        let Some(layer) = picture.layer(key) else {
            bail!("has no layer {name:?}; it has {}", list(picture));
        };
        match &mut total {
            None => total = Some((layer.kind, layer.channels.iter().map(|channel| channel.to_vec()).collect())),
            Some((kind, _)) if *kind != layer.kind => bail!("{names}: layers of different kinds cannot be added"),
            Some((_, channels)) => {
                for (sum, channel) in channels.iter_mut().zip(&layer.channels) {
                    sum.iter_mut().zip(*channel).for_each(|(sum, value)| *sum += value);
                }
            }
        }
    }
    total.context("a layer needs a name")
}

/// The mask by its name in either file, the reference's first, or from a file of its own.
pub fn read_mask(name: &str, test: &Picture, reference: &Picture) -> Result<Vec<bool>> {
    if name.ends_with(".exr") {
        let file = exr::read(Path::new(name))?;
        ensure!(
            (file.width, file.height) == (reference.width, reference.height),
            "--mask {name}: it has {} × {} pixels, the pictures {} × {}",
            file.width,
            file.height,
            reference.width,
            reference.height
        );
        let only = file.channels.values().next().filter(|_| file.channels.len() == 1).map(Vec::as_slice);
        let channel = channel(&file, "mask").or(only);
        return Ok(mask(channel.with_context(|| format!("--mask {name}: no layer \"mask\"; it has {}", list(&file)))?));
    }
    let channel = channel(reference, name).or_else(|| channel(test, name));
    let names =
        || format!("--mask {name}: no such layer; the reference has {}, the test {}", list(reference), list(test));
    Ok(mask(channel.with_context(names)?))
}

/// A channel by its full name, or the first of a layer.
fn channel<'a>(picture: &'a Picture, name: &str) -> Option<&'a [f32]> {
    let whole = picture.channels.get(name).map(Vec::as_slice);
    whole.or_else(|| picture.layer(name).map(|layer| layer.channels[0]))
}

/// Name of a layer for the reader; the picture itself is `RGB`.
fn shown(name: &str) -> &str {
    if name.is_empty() { "RGB" } else { name }
}

fn list(picture: &Picture) -> String {
    let names: Vec<&str> = picture.layers().into_iter().map(shown).collect();
    if names.is_empty() { "no layers".into() } else { names.join(", ") }
}

fn channels(kind: Kind) -> &'static str {
    match kind {
        Kind::Colour => "R, G, B",
        Kind::Vector => "X, Y, Z",
        Kind::Scalar => "one value",
    }
}

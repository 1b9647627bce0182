//! The reference that errors are measured against: a file that is given, or one that is made once and kept.

use super::ConvergenceArgs;
use anyhow::{Context, Result, bail, ensure};
use hemicube::image::metrics::mask;
use hemicube::image::{Kind, Layer, Picture, exr};
use hemicube::reference::{Progressive, Settings, Stop, Tracer, View, open_batch};
use hemicube::report::progress::Progress;
use std::path::Path;
use std::time::{Duration, Instant};

/// What is taken for true.
pub struct Truth {
    /// Name of the file.
    pub name: String,
    /// For people: the file and its layer, or how it was made.
    pub words: String,
    /// Indirect irradiance.
    pub irradiance: [Vec<f32>; 3],
    /// Pixels that count.
    pub mask: Vec<bool>,
    /// Mean absolute error that its own noise makes, over the mean; if it is known.
    pub noise: Option<f64>,
}

impl Truth {
    /// The irradiance as a layer.
    pub fn layer(&self) -> Layer<'_> {
        Layer { kind: Kind::Colour, channels: self.irradiance.iter().map(Vec::as_slice).collect() }
    }

    /// Takes over a picture's layer. Pixels count where its mask says so, else where `tracer` sees a surface that reflects.
    fn of(picture: &Picture, layer: &str, tracer: &Tracer, view: &View) -> Option<Self> {
        let irradiance = picture.rgb(layer)?.map(<[f32]>::to_vec);
        let own = picture.layer("mask").map(|layer| mask(layer.channels[0]));
        let seen = || view.pixels(tracer).iter().map(|pixel| pixel.reflector().is_some()).collect();
        let mask: Vec<bool> = own.unwrap_or_else(seen);
        let noise = picture.rgb(&format!("stderr.{layer}")).map(|stderr| {
            let sum = |planes: [&[f32]; 3]| -> f64 {
                planes
                    .iter()
                    .flat_map(|p| p.iter().zip(&mask))
                    .map(|(v, &k)| f64::from(*v) * f64::from(u8::from(k)))
                    .sum()
            };
            // The mean of |x| for a normal distribution of standard deviation 1.
            std::f64::consts::FRAC_2_PI.sqrt() * sum(stderr) / sum(irradiance.each_ref().map(Vec::as_slice))
        });
        Some(Self { name: String::new(), words: String::new(), irradiance, mask, noise })
    }
}

/// Reads `--reference`.
pub fn read(path: &Path) -> Result<Picture> {
    Ok(exr::read(path)?)
}

/// The given picture's layer.
pub fn given(args: &ConvergenceArgs, path: &Path, picture: &Picture, tracer: &Tracer, view: &View) -> Result<Truth> {
    let layer = match &args.layer {
        Some(layer) => layer.as_str(),
        None if picture.rgb("b1").is_some() => "b1",
        None => "irradiance",
    };
    let Some(truth) = Truth::of(picture, layer, tracer, view) else {
        let layers: Vec<_> =
            picture.layers().into_iter().map(|name| if name.is_empty() { "RGB" } else { name }).collect();
        bail!("{path:?} has no colour layer {layer:?}; it has {}: choose one with --layer", layers.join(", "));
    };
    ensure!(truth.mask.contains(&true), "the mask of {path:?} leaves no pixel to compare");
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Truth { words: format!("{}, layer {layer}", path.display()), name, ..truth })
}

/// The reference of an earlier run, or a new one.
pub fn made(args: &ConvergenceArgs, tracer: &Tracer, view: &View) -> Result<Truth> {
    let (file, state) = (args.output.join("reference.exr"), args.output.join("reference.state"));
    let pixels = u64::from(view.width) * u64::from(view.height);
    let mut run = Progressive::new(tracer, view.clone(), Settings { bounces: 1, seed: 0, batch: open_batch(pixels) });
    if state.exists() && !args.fresh {
        run.load(&state).context("the reference of an earlier run: choose another folder, or --fresh")?;
    }
    if run.spp() == 0 {
        let seconds = args.reference_seconds();
        let stage = Progress::new(args.quiet).stage("reference", 1000);
        let begun = Instant::now();
        let stop = Stop { time: Some(Duration::from_secs_f64(seconds)), ..Stop::default() };
        let Ok(_) = run.run(&stop, |_| {
            let part = (1000.0 * begun.elapsed().as_secs_f64() / seconds) as u64;
            stage.advance(part.min(1000).saturating_sub(stage.done()));
            Ok::<(), std::convert::Infallible>(())
        });
        run.save(&state)?;
        let spp = run.spp().to_string();
        exr::write(&file, &run.picture(), &[("method", "path"), ("bounces", "1"), ("spp", &spp)])?;
    }
    let truth = Truth::of(&run.picture(), "irradiance", tracer, view).context("the path tracer gave no irradiance")?;
    ensure!(truth.mask.contains(&true), "the camera sees no surface that reflects: there is nothing to compare");
    let words = format!("path tracing, {} paths a pixel ({})", run.spp(), file.display());
    Ok(Truth { name: "reference.exr".into(), words, ..truth })
}

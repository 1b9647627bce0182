//! `hemicube compare`: how far a picture is from its reference.

mod input;
mod output;

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use hemicube::image::metrics::{Metrics, measure, measure_flip};
use input::{Pair, read_mask, read_pair, resolve};
use std::path::PathBuf;
use std::process::ExitCode;

/// Measure a picture against a reference
///
/// Reads two EXR files of the same size and measures, layer by layer and in linear floats, how far TEST is from
/// REFERENCE. Errors are relative to the reference's mean, so 0.02 is an error of 2 %.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct CompareArgs {
    /// Picture to judge, EXR
    #[arg(value_name = "TEST.exr")]
    test: PathBuf,
    /// Picture taken as the truth, EXR
    #[arg(value_name = "REFERENCE.exr")]
    reference: PathBuf,
    /// Layer to compare, repeatable; NAME=NAME where the files call it differently, A+B for a sum, RGB for the picture
    /// itself. Default: the layers that both files have, but for standard errors
    #[arg(long = "layer", value_name = "NAME[=NAME]", help_heading = "What is compared")]
    layers: Vec<String>,
    /// Compare only where this is above 0.5: a layer or channel of either file, or the mask in another EXR file
    #[arg(long, value_name = "CHANNEL|FILE.exr", help_heading = "What is compared")]
    mask: Option<String>,
    /// Leave out HDR-FLIP, which takes most of the time on large pictures
    #[arg(long, help_heading = "What is compared")]
    no_flip: bool,
    /// Fail with exit code 1 when a layer's error is above this
    #[arg(long, value_name = "X", help_heading = "Threshold")]
    threshold: Option<f64>,
    /// The error that the threshold is for; energy is |energy − 1|
    #[arg(long, value_enum, default_value = "mae", requires = "threshold", help_heading = "Threshold")]
    metric: Metric,
    /// Write the figures as JSON; - for the standard output, in place of the table
    #[arg(long, value_name = "FILE|-", help_heading = "Output")]
    json: Option<PathBuf>,
    /// Write the relative error of each pixel in false colour (one layer)
    #[arg(long, value_name = "FILE.png", help_heading = "Output")]
    diff: Option<PathBuf>,
    /// Relative error that --diff shows as its last colour, dark red
    #[arg(long, value_name = "X", default_value_t = 0.25, requires = "diff", help_heading = "Output")]
    diff_top: f32,
}

const HELP: &str = "\
Figures:
  mae     mean absolute error / mean of the reference
  rms     root of the mean squared error / mean of the reference
  relmse  mean of (test − reference)² / (reference² + 0.01 mean²)
  p95 p99 95th and 99th percentile over pixels of |test − reference| / (|reference| + 0.01 mean); max is the largest
  energy  sum of the test / sum of the reference: 0.97 is 3 % of the light lost
  4×4     mae after averaging blocks of 4 × 4 pixels: noise averages out, bias stays
  flip    HDR-FLIP, 0 to 1: how different the two look at any exposure (Andersson et al. 2021), mean over pixels
  Pixels with NaN or infinite values are counted and left out; any in TEST fails every threshold.

Examples:
  hemicube compare out.exr reference.exr
  hemicube compare out.exr E_256x256.exr --layer irradiance=b1 --mask mask
  hemicube compare out.exr E_256x256.exr --layer irradiance=b1+b2 --threshold 0.03 --metric rms
  hemicube compare out.exr reference.exr --layer RGB --diff error.png --json figures.json

Exit codes: 0 done, and no layer above the threshold; 1 a layer above it; 2 bad input.";

/// The figures that a threshold can be on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Mean absolute error
    Mae,
    /// Root mean squared error
    Rms,
    /// Relative mean squared error
    Relmse,
    /// HDR-FLIP
    Flip,
    /// 95th percentile of the relative error
    P95,
    /// 99th percentile of the relative error
    P99,
    /// |energy ratio − 1|
    Energy,
}

impl Metric {
    /// The figure, none where the layer has no such thing (FLIP of a depth).
    fn of(self, metrics: &Metrics) -> Option<f64> {
        match self {
            Self::Mae => Some(metrics.mae),
            Self::Rms => Some(metrics.rms),
            Self::Relmse => Some(metrics.relmse),
            Self::Flip => metrics.flip,
            Self::P95 => Some(metrics.p95),
            Self::P99 => Some(metrics.p99),
            Self::Energy => metrics.energy.map(|energy| (energy - 1.0).abs()),
        }
    }

    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// Figures of one layer.
struct Compared {
    pair: Pair,
    metrics: Metrics,
    /// Figure, and whether it passes, where there is a threshold.
    verdict: Option<(f64, bool)>,
}

/// Runs the subcommand.
pub fn run(args: &CompareArgs) -> Result<ExitCode> {
    check(args)?;
    let (test, reference) = read_pair(&args.test, &args.reference)?;
    let pairs = resolve(args, &test, &reference)?;
    ensure!(
        args.diff.is_none() || pairs.len() == 1,
        "--diff shows one layer and {} are compared; choose one with --layer",
        pairs.len()
    );
    let mask = args.mask.as_deref().map(|name| read_mask(name, &test, &reference)).transpose()?;
    let mut compared = Vec::new();
    for pair in pairs {
        compared.push(compare(args, pair, reference.width as usize, mask.as_deref())?);
    }
    output::write(args, &compared, (reference.width, reference.height), mask.as_deref())?;
    let passed = compared.iter().all(|layer| layer.verdict.is_none_or(|(_, passed)| passed));
    Ok(ExitCode::from(u8::from(!passed)))
}

fn check(args: &CompareArgs) -> Result<()> {
    let positive = |value: f64| value.is_finite() && value >= 0.0;
    ensure!(args.threshold.is_none_or(positive), "--threshold must be a number from 0 up");
    ensure!(args.diff_top > 0.0 && args.diff_top.is_finite(), "--diff-top must be a number above 0");
    ensure!(!(args.no_flip && args.metric == Metric::Flip), "--metric flip and --no-flip exclude each other");
    Ok(())
}

fn compare(args: &CompareArgs, pair: Pair, width: usize, mask: Option<&[bool]>) -> Result<Compared> {
    let (test, reference) = (pair.test_layer(), pair.reference_layer());
    let mut metrics = measure(&test, &reference, width, mask);
    let counted = metrics.pixels + metrics.non_finite_test.max(metrics.non_finite_reference);
    ensure!(counted > 0, "the mask leaves no pixel to compare");
    if !args.no_flip {
        metrics.flip = measure_flip(&test, &reference, width, mask);
    }
    let verdict = args.threshold.map(|threshold| verdict(args.metric, threshold, &metrics, &pair)).transpose()?;
    Ok(Compared { pair, metrics, verdict })
}

fn verdict(metric: Metric, threshold: f64, metrics: &Metrics, pair: &Pair) -> Result<(f64, bool)> {
    let Some(figure) = metric.of(metrics) else {
        anyhow::bail!("layer {} has no {}; choose layers with --layer or another --metric", pair.name, metric.name());
    };
    // An error that is itself no number passes nothing.
    Ok((figure, figure <= threshold && metrics.non_finite_test == 0 && metrics.pixels > 0))
}

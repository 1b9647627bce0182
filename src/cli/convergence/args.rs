//! The arguments of `hemicube convergence`.

use crate::cli::choices::{CaptureArg, GradientsArg};
use crate::cli::common::{DeviceArgs, ImageArgs, SceneArgs, parse_seconds};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Measure error against time, for every method and setting
///
/// Renders the indirect irradiance of a view (one bounce) by irradiance splatting, by Ward's cache on the CPU and by path
/// tracing, each with several settings, and measures how long it takes and how far it is from a reference. The folder gets
/// a table (points.csv), charts of error against processor time and clock time (error-cpu.svg, error-wall.svg; settings of
/// splatting by themselves in splatting.svg) and a page with all of it and pictures (index.html). A point that is in the table already is not run again, so a run that was
/// broken off goes on where it was.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct ConvergenceArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Folder for the results; made if it is missing
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    pub image: ImageArgs,
    /// Methods to measure: splatting (this renderer), ward (Ward's cache on the CPU), path (path tracing on the CPU)
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "splatting,ward,path", help_heading = "What is measured", value_parser = parse_method)]
    pub methods: Vec<MethodArg>,
    /// Write the stability suite's table instead: records against closed forms and at extremes, with the order in which
    /// their errors fall with the capture's size. Exit code 1 if a row is out of bounds
    #[arg(long, conflicts_with_all = ["scene", "background", "camera", "width", "height", "quick", "repeats", "accuracy",
        "capture_size", "capture", "gradients", "rays", "spp", "reference", "layer", "reference_time", "flip", "peers",
        "fresh"], help_heading = "What is measured")]
    pub stability: bool,
    /// Write a table and charts of solvers instead: all bounces summed one by one and by GMRES, in rooms where light goes on
    /// for long, with products, time, residual, what is missing after each product, and the error
    #[arg(long, conflicts_with_all = ["stability", "scene", "background", "camera", "width", "height", "quick", "repeats",
        "accuracy", "capture_size", "capture", "gradients", "rays", "spp", "reference", "layer", "reference_time", "flip",
        "peers", "fresh"], help_heading = "What is measured")]
    pub solvers: bool,
    /// Few points, one timing each: under two minutes for the Cornell box on two cores
    #[arg(long, help_heading = "What is measured")]
    pub quick: bool,
    /// Timings of a point, of which the median counts; default 3, with --quick 1. A run of a minute is not repeated
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), help_heading = "What is measured")]
    repeats: Option<u32>,
    #[command(flatten)]
    pub lists: Lists,
    /// Truth to measure against; without it the path tracer makes one and keeps it in the folder. Gives the image its size
    #[arg(long, value_name = "FILE.exr", help_heading = "Reference")]
    pub reference: Option<PathBuf>,
    /// Layer of --reference with the irradiance after one bounce; default: b1, else irradiance
    #[arg(long, value_name = "NAME", requires = "reference", help_heading = "Reference")]
    pub layer: Option<String>,
    /// Time to make a reference in; default 120, with --quick 45
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, conflicts_with = "reference", help_heading = "Reference")]
    reference_time: Option<f64>,
    /// The error that charts show: all of them are in the table
    #[arg(long, value_enum, default_value = "mae", help_heading = "Results")]
    pub error: ErrorArg,
    /// Measure HDR-FLIP too, which takes longer than some of the methods
    #[arg(long, help_heading = "Results")]
    pub flip: bool,
    /// Add the points of other renderers, as tools/peers/run.py writes them
    #[arg(long, value_name = "POINTS.csv", help_heading = "Results")]
    pub peers: Option<PathBuf>,
    /// Forget what is in the folder and measure everything anew
    #[arg(long, help_heading = "Results")]
    pub fresh: bool,
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages")]
    pub quiet: bool,
}

/// Settings, each in a list.
#[derive(Args, Debug)]
#[command(next_help_heading = "Settings in place of the usual ones")]
pub struct Lists {
    /// Ward's a for splatting and ward
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_positive)]
    pub accuracy: Vec<f64>,
    /// Texels a side of a record's capture (a hemicube's top)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub capture_size: Vec<u32>,
    /// How records look at the scene, each way in its usual settings
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = CaptureArg::by_name())]
    pub capture: Vec<CaptureArg>,
    /// Gradients of splatted records
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    pub gradients: Vec<GradientsArg>,
    /// Rays of a record of Ward's cache
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(4..=1 << 20))]
    pub rays: Vec<u32>,
    /// Paths a pixel
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(2..=1 << 20))]
    pub spp: Vec<u32>,
}

const HELP: &str = "\
Times are those of the indirect light alone: setting up (upload, pipelines, acceleration structures) is left out, and the
time of the same picture without indirect light is taken off. Errors are over the pixels that the reference's mask keeps:
  mae  mean absolute error / mean        block_mae  mae of averages over 4 × 4 pixels, from which noise is gone
  rms  root of mean squared error / mean      p99  99th percentile of a pixel's relative error
`hemicube compare --help` says more. Usual settings: splatting with accuracy .6 to .12, with the capture that suits the
device at 32 texels and both gradients, then with one of these changed: 16 and 64 texels, each other capture, no
gradients.
Lists in their place are measured all with all. Without --width and --height the image has the reference's size, else 256
lines, with --quick 128. A folder holds points of one scene, view and reference; points of settings that are no longer asked for stay in it.

Examples:
  hemicube convergence --quick -o cornell                    the built-in box in two minutes; open cornell/index.html
  hemicube convergence sponza.gltf --reference E_256x256.exr --layer b1 -o sponza
  hemicube convergence -o cornell --methods splatting --accuracy .4,.2,.1 --capture-size 16,32,64 --height 512
  hemicube convergence --stability -o stability              what records get right, and how exactly: stability.md
Other renderers, on the same machine and against the same reference:
  tools/peers/run.py cornell.gltf --reference cornell/reference.exr -o peers.csv
  hemicube convergence cornell.gltf -o cornell --peers peers.csv

Exit codes: 0 done; 1 a row of --stability is out of bounds; 2 bad usage or input; 3 no suitable device, or device lost.";

/// `--methods`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Irradiance splatting
    Splatting,
    /// Ward's cache
    Ward,
    /// Path tracing
    Path,
}

/// `--error`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum ErrorArg {
    /// Mean absolute error / mean
    Mae,
    /// Mean absolute error of averages over 4 × 4 pixels / mean
    BlockMae,
    /// Root of the mean squared error / mean
    Rms,
    /// 99th percentile of the relative error
    P99,
}

impl ErrorArg {
    pub fn column(self) -> &'static str {
        match self {
            Self::Mae => "mae",
            Self::BlockMae => "block_mae",
            Self::Rms => "rms",
            Self::P99 => "p99",
        }
    }

    pub fn words(self) -> &'static str {
        match self {
            Self::Mae => "mean absolute error / mean of the indirect irradiance",
            Self::BlockMae => "error of 4 × 4 pixel averages / mean of the indirect irradiance",
            Self::Rms => "root mean square error / mean of the indirect irradiance",
            Self::P99 => "99th percentile of the pixels’ relative error",
        }
    }
}

impl ConvergenceArgs {
    pub fn repeats(&self) -> u32 {
        self.repeats.unwrap_or(if self.quick { 1 } else { 3 })
    }

    pub fn reference_seconds(&self) -> f64 {
        self.reference_time.unwrap_or(if self.quick { 45.0 } else { 120.0 })
    }

    /// Name of the scene, as the peers' script calls it.
    pub fn name(&self) -> String {
        let stem = self.scene.scene.as_ref().and_then(|path| path.file_stem());
        stem.map_or_else(|| "cornell".into(), |stem| stem.to_string_lossy().into_owned())
    }
}

fn parse_method(text: &str) -> Result<MethodArg, String> {
    MethodArg::from_str(text, true).map_err(|_| format!("{text:?} is none of: splatting, ward, path"))
}

fn parse_positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{text} is not above 0")) }
}

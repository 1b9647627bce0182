//! `hemicube convergence`: error against time for every method and setting.

mod folder;
mod measure;
mod output;
mod peers;
mod task;
mod truth;

use super::common::{DeviceArgs, ImageArgs, SceneArgs};
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use folder::Folder;
use hemicube::reference::{Tracer, View, process_time};
use hemicube::report::convergence::Machine;
use hemicube::report::progress::Progress;
use hemicube::scene::{self, Camera};
use measure::Bench;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use task::Task;

/// Measure error against time, for every method and setting
///
/// Renders the indirect irradiance of a view (one bounce) by irradiance splatting, by Ward's cache on the CPU and by path
/// tracing, each with several settings, and measures how long it takes and how far it is from a reference. The folder gets
/// a table (points.csv), charts of error against processor time and clock time (error-cpu.svg, error-wall.svg) and a page
/// with all of it and pictures (index.html). A point that is in the table already is not run again, so a run that was
/// broken off goes on where it was.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct ConvergenceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder for the results; made if it is missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    image: ImageArgs,
    /// Methods to measure: splatting (this renderer), ward (Ward's cache on the CPU), path (path tracing on the CPU)
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "splatting,ward,path", help_heading = "What is measured", value_parser = parse_method)]
    methods: Vec<MethodArg>,
    /// Few points, one timing each: under two minutes for the Cornell box on two cores
    #[arg(long, help_heading = "What is measured")]
    quick: bool,
    /// Timings of a point, of which the median counts; default 3, with --quick 1. A run of a minute is not repeated
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), help_heading = "What is measured")]
    repeats: Option<u32>,
    /// Ward's a for splatting and ward
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_positive, help_heading = "Settings in place of the usual ones")]
    accuracy: Vec<f64>,
    /// Texels a side of a record's hemicube
    #[arg(long, value_name = "LIST", value_delimiter = ',', help_heading = "Settings in place of the usual ones")]
    capture_size: Vec<u32>,
    /// How records look at the scene
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Settings in place of the usual ones"
    )]
    capture: Vec<CaptureArg>,
    /// Gradients of splatted records
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Settings in place of the usual ones"
    )]
    gradients: Vec<GradientsArg>,
    /// Rays of a record of Ward's cache
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(4..=1 << 20), help_heading = "Settings in place of the usual ones")]
    rays: Vec<u32>,
    /// Paths a pixel
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(2..=1 << 20), help_heading = "Settings in place of the usual ones")]
    spp: Vec<u32>,
    /// Truth to measure against; without it the path tracer makes one and keeps it in the folder. Gives the image its size
    #[arg(long, value_name = "FILE.exr", help_heading = "Reference")]
    reference: Option<PathBuf>,
    /// Layer of --reference with the irradiance after one bounce; default: b1, else irradiance
    #[arg(long, value_name = "NAME", requires = "reference", help_heading = "Reference")]
    layer: Option<String>,
    /// Time to make a reference in; default 120, with --quick 45
    #[arg(long, value_name = "SECONDS", value_parser = parse_positive, conflicts_with = "reference", help_heading = "Reference")]
    reference_time: Option<f64>,
    /// The error that charts show: all of them are in the table
    #[arg(long, value_enum, default_value = "mae", help_heading = "Results")]
    error: ErrorArg,
    /// Measure HDR-FLIP too, which takes longer than some of the methods
    #[arg(long, help_heading = "Results")]
    flip: bool,
    /// Add the points of other renderers, as tools/peers/run.py writes them
    #[arg(long, value_name = "POINTS.csv", help_heading = "Results")]
    peers: Option<PathBuf>,
    /// Forget what is in the folder and measure everything anew
    #[arg(long, help_heading = "Results")]
    fresh: bool,
    #[command(flatten)]
    device: DeviceArgs,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages")]
    quiet: bool,
}

const HELP: &str = "\
Times are those of the indirect light alone: setting up (upload, pipelines, acceleration structures) is left out, and the
time of the same picture without indirect light is taken off. Errors are over the pixels that the reference's mask keeps:
  mae  mean absolute error / mean        block_mae  mae of averages over 4 × 4 pixels, from which noise is gone
  rms  root of mean squared error / mean      p99  99th percentile of a pixel's relative error
`hemicube compare --help` says more. Usual settings: splatting with accuracy .6 to .12, with the capture that suits the
device at 32 texels and both gradients, then with one of these changed: 16 and 64 texels, the other capture, no gradients.
Lists in their place are measured all with all.

Examples:
  hemicube convergence --quick -o cornell                    the built-in box in two minutes; open cornell/index.html
  hemicube convergence sponza.gltf --reference E_256x256.exr --layer b1 -o sponza
  hemicube convergence -o cornell --methods splatting --accuracy .4,.2,.1 --capture-size 16,32,64 --height 512
Other renderers, on the same machine and against the same reference:
  tools/peers/run.py cornell.gltf --reference cornell/reference.exr -o peers.csv
  hemicube convergence cornell.gltf -o cornell --peers peers.csv

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device, or device lost.";

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

/// `--capture`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CaptureArg {
    /// Multi-view hemicubes by render passes
    Hemicube,
    /// Hemicubes rasterised in compute
    Compute,
}

/// `--gradients`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum GradientsArg {
    /// Constant irradiance in each zone
    None,
    /// By the normal's turn and the point's move
    Both,
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

impl CaptureArg {
    fn name(self) -> &'static str {
        match self {
            Self::Hemicube => "hemicube",
            Self::Compute => "compute",
        }
    }
}

impl GradientsArg {
    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Both => "both",
        }
    }
}

impl ErrorArg {
    fn column(self) -> &'static str {
        match self {
            Self::Mae => "mae",
            Self::BlockMae => "block_mae",
            Self::Rms => "rms",
            Self::P99 => "p99",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Mae => "mean absolute error / mean of the indirect irradiance",
            Self::BlockMae => "error of 4 × 4 pixel averages / mean of the indirect irradiance",
            Self::Rms => "root mean square error / mean of the indirect irradiance",
            Self::P99 => "99th percentile of the pixels’ relative error",
        }
    }
}

impl ConvergenceArgs {
    fn repeats(&self) -> u32 {
        self.repeats.unwrap_or(if self.quick { 1 } else { 3 })
    }

    fn reference_seconds(&self) -> f64 {
        self.reference_time.unwrap_or(if self.quick { 45.0 } else { 120.0 })
    }

    /// Name of the scene, as the peers' script calls it.
    fn name(&self) -> String {
        let stem = self.scene.scene.as_ref().and_then(|path| path.file_stem());
        stem.map_or_else(|| "cornell".into(), |stem| stem.to_string_lossy().into_owned())
    }
}

/// Height of the image where nothing else says its size.
const HEIGHT: u32 = 256;

/// Runs the subcommand.
pub fn run(args: &ConvergenceArgs) -> Result<ExitCode> {
    let scene = args.scene.load()?;
    let (camera, note) = args.scene.camera(&scene)?;
    if !args.quiet {
        scene.notes.iter().chain(&note).for_each(|note| eprintln!("note: {note}"));
    }
    let given = args.reference.as_deref().map(|path| Ok::<_, anyhow::Error>((path, truth::read(path)?))).transpose()?;
    let size = size(args, &camera, given.as_ref().map(|(_, picture)| (picture.width, picture.height)))?;
    let others = args.peers.as_deref().map(|path| peers::read(path, &args.name(), size)).transpose()?;
    let mut folder = Folder::open(args)?;
    let cpu = process_time();
    let tracer = Tracer::new(&scene);
    let tracer_cpu_s = cpu.zip(process_time()).map_or(0.0, |(from, to)| to.saturating_sub(from).as_secs_f64());
    let view = View::new(&camera, size.0, size.1);
    let truth = match &given {
        Some((path, picture)) => truth::given(args, path, picture, &tracer, &view)?,
        None => truth::made(args, &tracer, &view)?,
    };
    folder.claim(&tracer, &view, &truth)?;
    let mut bench = Bench {
        args,
        name: args.name(),
        scene: &scene,
        camera: &camera,
        size,
        tracer: &tracer,
        tracer_cpu_s,
        truth: &truth,
        direct: None,
    };
    let device = measure_all(&mut bench, &mut folder)?;
    if let Some(others) = others {
        folder.merge(others.points)?;
        others.notes.iter().filter(|_| !args.quiet).for_each(|note| eprintln!("note: {note}"));
    }
    output::write(args, &folder, &truth, size, device.as_deref())?;
    Ok(ExitCode::SUCCESS)
}

fn size(args: &ConvergenceArgs, camera: &Camera, reference: Option<(u32, u32)>) -> Result<(u32, u32)> {
    let (width, height) = (args.image.width, args.image.height);
    let size = match reference {
        Some((w, h)) => {
            let agrees = width.is_none_or(|given| given == w) && height.is_none_or(|given| given == h);
            ensure!(agrees, "--reference has {w} × {h} pixels: leave --width and --height out, or name another");
            (w, h)
        }
        None if width.is_none() && height.is_none() => scene::image_size(camera, None, Some(HEIGHT)),
        None => scene::image_size(camera, width, height),
    };
    let sides = 1..=scene::LARGEST_SIDE;
    ensure!(sides.contains(&size.0) && sides.contains(&size.1), "an image of {} × {} pixels", size.0, size.1);
    Ok(size)
}

/// Measures what the folder does not have yet; returns the device's name if one was opened.
fn measure_all(bench: &mut Bench, folder: &mut Folder) -> Result<Option<String>> {
    let args = bench.args;
    let mut device = None;
    let mut on_cpu = true;
    if args.methods.contains(&MethodArg::Splatting) {
        let opened = args.device.open()?;
        on_cpu = opened.is_cpu();
        device = Some(format!("{} ({})", opened.physical.name, opened.physical.driver.trim()));
    }
    let name = device.as_deref().unwrap_or_default();
    let missing: Vec<Task> = task::tasks(args, on_cpu)
        .into_iter()
        .filter(|task| !folder.has(&bench.empty_point(task, name).key()))
        .collect();
    if let Some(load) = Machine::load().filter(|load| *load > 0.5 && !missing.is_empty() && !args.quiet) {
        eprintln!("note: this machine is busy with something else (load {load:.1}): clock times will be too long");
    }
    let mut eta = Eta::new(&missing);
    let stage = Progress::new(args.quiet).stage("points", missing.len() as u64);
    for (index, task) in missing.iter().enumerate() {
        let begun = Instant::now();
        let empty = bench.empty_point(task, name);
        let label = format!("{}/{} {} {}", index + 1, missing.len(), task.method(), empty.words());
        match bench.measure(task, empty).with_context(|| label.clone()) {
            Ok((point, picture)) => {
                let shown = output::one_line(&point);
                folder.add(point, &picture)?;
                eta.done(index, begun.elapsed());
                if !args.quiet {
                    eprintln!("{label}: {shown}{}", eta.words());
                }
            }
            Err(error) if error.downcast_ref::<measure::DoesNotFit>().is_some() => {
                eta.done(index, begun.elapsed());
                eprintln!("note: left out: {error:#}");
            }
            Err(error) => return Err(error),
        }
        stage.advance(1);
    }
    Ok(device)
}

/// Time that is left, by what points of the same method took for their work.
struct Eta<'a> {
    tasks: &'a [Task],
    spent: Vec<Duration>,
}

impl<'a> Eta<'a> {
    fn new(tasks: &'a [Task]) -> Self {
        Self { tasks, spent: Vec::new() }
    }

    fn done(&mut self, index: usize, time: Duration) {
        debug_assert_eq!(index, self.spent.len());
        self.spent.push(time);
    }

    fn words(&self) -> String {
        let seconds = self.seconds();
        match self.tasks.len() - self.spent.len() {
            0 => String::new(),
            left if seconds < 100.0 => format!("; {left} left, about {seconds:.0} s"),
            left => format!("; {left} left, about {:.0} min", seconds / 60.0),
        }
    }

    fn seconds(&self) -> f64 {
        let rate = |method: Option<&str>| {
            let own = || self.tasks.iter().zip(&self.spent).filter(|(t, _)| method.is_none_or(|m| t.method() == m));
            let (work, time) = own().fold((0.0, 0.0), |(w, s), (task, time)| {
                (w + if method.is_some() { task.work() } else { 1.0 }, s + time.as_secs_f64())
            });
            (work > 0.0).then(|| time / work)
        };
        let left = self.tasks.iter().skip(self.spent.len());
        left.map(|task| match rate(Some(task.method())) {
            Some(rate) => rate * task.work(),
            None => rate(None).unwrap_or(0.0),
        })
        .sum()
    }
}

fn parse_method(text: &str) -> Result<MethodArg, String> {
    MethodArg::from_str(text, true).map_err(|_| format!("{text:?} is none of: splatting, ward, path"))
}

fn parse_positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{text} is not above 0")) }
}

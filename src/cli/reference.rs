//! `hemicube reference`: the truth on the CPU, by paths or by the irradiance cache of 1988.

mod draw;
mod points;
mod report;
mod setup;

pub use setup::parse_bounces;

use super::choices::{GradientsArg, WeightArg};
use super::common::{ImageArgs, SceneArgs, parse_seconds};
use super::stop;
use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use hemicube::reference::ward::{Gradients, Weight};
use hemicube::reference::{Progressive, Stop, Tracer, View, ward};
use hemicube::report::progress::Progress;
use setup::{Job, Output};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Render the truth on the CPU, to compare other pictures with
///
/// Traces paths from the surface that the centre of each pixel sees, without bias, on all cores and without Vulkan: the
/// same scene, camera, emitters and number of bounces as `hemicube render`, and the same layers. Each result is within
/// its standard error of the truth, and the file says how large that is for every pixel.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct ReferenceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    image: ImageArgs,
    /// File to write: .exr with all layers, or .png; with --points .json
    #[arg(short, long, value_name = "OUT.exr|OUT.png|OUT.json")]
    output: PathBuf,
    /// Trace light at points in space instead of a picture: a JSON file {"points": [[x, y, z], …]}. The result has the format of
    /// `hemicube probe`, and the relative standard error "se" of each point's irradiance; --spp is the number of paths a point,
    /// 16384 by default
    #[arg(long, value_name = "FILE.json", help_heading = "Points")]
    points: Option<PathBuf>,
    /// Order of the harmonics at --points, 2 to 6
    #[arg(long, value_name = "N", default_value_t = 3, requires = "points", help_heading = "Points")]
    order: u32,
    /// How indirect light is found
    #[arg(long, value_enum, default_value = "path")]
    method: Method,
    /// Reflections between the light and the visible surface: 0 is direct light alone, all has no limit
    #[arg(long, value_name = "N|all", default_value = "1", value_parser = setup::parse_bounces)]
    bounces: u32,
    /// Same seed, same picture, whatever the number of threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Threads; default: all cores
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Stop after this many paths a pixel, rounded up to whole batches; default 256 if nothing else stops the run. With
    /// --method ward: paths a pixel for direct light, default 64
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..), help_heading = "When to stop")]
    spp: Option<u32>,
    /// Stop when the mean standard error of a pixel / the mean falls below this: 0.01 is 1 %
    #[arg(long, value_name = "X", value_parser = setup::parse_positive, help_heading = "When to stop")]
    relative_error: Option<f64>,
    /// Stop after this many seconds
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, help_heading = "When to stop")]
    time: Option<f64>,
    /// Keep the state of the run in FILE, and go on from it if it is there
    #[arg(long, value_name = "FILE", help_heading = "When to stop")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    ward: WardArgs,
    /// Draw something over the picture's colour; the other layers stay
    #[arg(long, value_enum)]
    show: Option<Show>,
    /// Write what the run was and cost as JSON
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Settings of the irradiance cache.
#[derive(Args, Debug)]
#[command(next_help_heading = "Irradiance cache (--method ward)")]
pub struct WardArgs {
    /// Ward's a: a record reaches a × the mean distance to what it sees
    #[arg(long, value_name = "A", default_value_t = 0.2, value_parser = setup::parse_positive)]
    accuracy: f64,
    /// Rays of a record
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(4..=1 << 20))]
    rays: u32,
    /// Weight that interpolates between records
    #[arg(long, value_enum, default_value = "ward")]
    weight: WeightArg,
    /// Gradients that extrapolate a record
    #[arg(long, value_enum, default_value = "both")]
    gradients: GradientsArg,
    /// Smallest reach of a record, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1.5, value_parser = setup::parse_positive)]
    min_radius: f64,
    /// Largest reach of a record, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 50.0, value_parser = setup::parse_positive)]
    max_radius: f64,
    /// Do not limit a record's reach by E / |gradient|
    #[arg(long)]
    no_gradient_limit: bool,
    /// Do not limit a record's reach by its neighbours'
    #[arg(long)]
    no_neighbour_clamping: bool,
}

const HELP: &str = "\
Layers of the EXR file (RGB unless said otherwise):
  R G B              radiance towards the camera = direct + indirect + emission
  direct, indirect   radiance that leaves the surface after 0 and after 1 to N reflections, W·sr⁻¹·m⁻²
  irradiance         indirect irradiance, W·m⁻²; irradiance_direct the direct one
  dir b1 b2 b3plus   irradiance after exactly 0, 1, 2, and 3 or more reflections (--method path)
  stderr.irradiance  standard error of each pixel; stderr.dir, stderr.b1, … (--method path)
  albedo emission N P Z, mask (1 where a surface is seen, but a black one that emits), records.Y (--method ward)

Examples:
  hemicube reference -o cornell.exr                              the built-in box, 256 paths a pixel
  hemicube reference room.gltf -o room.exr --bounces all --relative-error 0.01
  hemicube reference room.gltf -o room.exr --time 600 --resume room.state
                                                                 run it again for ten minutes more
  hemicube reference room.gltf -o ward.exr --method ward --accuracy 0.15
  hemicube reference room.gltf -o where.png --method ward --show records
  hemicube compare ward.exr room.exr --layer irradiance          how far the two are apart

Exit codes: 0 done; 2 bad usage or input.";

/// How indirect light is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Unbiased path tracing
    Path,
    /// Ward's irradiance cache: octree, gradients, ray-traced hemispheres
    Ward,
}

/// What is drawn over the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Show {
    /// The pixels whose surface carries a record (--method ward)
    Records,
}

/// Runs the subcommand.
pub fn run(args: &ReferenceArgs) -> Result<ExitCode> {
    if let Some(file) = &args.points {
        return points::run(args, file);
    }
    let begun = Instant::now();
    let job = setup::job(args)?;
    let tracer = Tracer::new(&job.scene);
    let view = View::new(&job.camera, job.size.0, job.size.1);
    let output = match args.method {
        Method::Path => trace(args, &job, &tracer, view)?,
        Method::Ward => cached(args, &job, &tracer, view),
    };
    setup::write(args, &output)?;
    report::tell(args, &job, &output, begun.elapsed())?;
    Ok(ExitCode::SUCCESS)
}

/// Seconds between two states on disk.
const SAVE_EVERY: Duration = Duration::from_secs(30);

fn trace(args: &ReferenceArgs, job: &Job, tracer: &Tracer, view: View) -> Result<Output> {
    let mut run = Progressive::new(tracer, view, job.path_settings(args));
    let state = args.resume.as_deref();
    if let Some(path) = state.filter(|path| path.exists()) {
        run.load(path)?;
    }
    let stop = job.stop(args);
    let bar = setup::Bar::new(Progress::new(args.quiet), &stop);
    let mut saved = Instant::now();
    let cost = run.run(&stop, |run: &Progressive| {
        bar.show(run);
        if let Some(path) = state.filter(|_| saved.elapsed() >= SAVE_EVERY) {
            save(run, path)?;
            saved = Instant::now();
        }
        anyhow::Ok(())
    })?;
    if let Some(path) = state {
        save(&run, path)?;
    }
    Ok(Output::path(&run, cost))
}

fn save(run: &Progressive, path: &Path) -> Result<()> {
    run.save(path).context("the state of the run is lost")?;
    let (spp, path) = (run.spp(), path.display());
    stop::keeps(format!("the state after {spp} paths a pixel is in {path}; the same command goes on from there"));
    Ok(())
}

fn cached(args: &ReferenceArgs, job: &Job, tracer: &Tracer, view: View) -> Output {
    let steps = 1000;
    let stage = Progress::new(args.quiet).stage("records", steps);
    let progress = |part: f64, _| stage.advance(((part * steps as f64) as u64).saturating_sub(stage.done()));
    let result = ward(tracer, view, &job.ward_settings(args), args.spp.unwrap_or(setup::WARD_SPP), progress);
    Output::ward(args, result)
}

impl Job {
    fn stop(&self, args: &ReferenceArgs) -> Stop {
        let open = args.relative_error.is_none() && args.time.is_none();
        Stop {
            spp: args.spp.or(open.then_some(setup::PATH_SPP)),
            relative_error: args.relative_error,
            time: args.time.map(Duration::from_secs_f64),
        }
    }
}

impl From<WeightArg> for Weight {
    fn from(arg: WeightArg) -> Self {
        match arg {
            WeightArg::Ward => Self::Ward,
            WeightArg::Bounded => Self::Bounded,
        }
    }
}

impl From<GradientsArg> for Gradients {
    fn from(arg: GradientsArg) -> Self {
        match arg {
            GradientsArg::None => Self::None,
            GradientsArg::Rotation => Self::Rotation,
            GradientsArg::Translation => Self::Translation,
            GradientsArg::Both => Self::Both,
        }
    }
}

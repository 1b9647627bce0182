//! `hemicube bake volume`: light for what moves.

use crate::cli::common::{DeviceArgs, SceneArgs, TalkArgs, check_output};
use crate::cli::probe::{check_capture_size, check_order, plain};
use crate::cli::say::{remark, say};
use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::sphere_probes::SphereProbeSettings;
use hemicube::methods::volume::{BakeSettings, Gradients, Places, bake, bounds};
use hemicube::renderer::Settings;
use hemicube::report::profile::Profile;
use hemicube::report::progress::{Progress, Stage};
use hemicube::report::stats::{Memory, SceneStats, Stats};
use hemicube::report::table::Table;
use hemicube::scene::Scene;
use hemicube::vk::Device;
use hemicube::vk::pass::Recorder;
use hemicube::volume::export::{self, Engine, Grid, bevy};
use hemicube::volume::memory::{MOMENTS, plain_bytes, table};
use hemicube::volume::place::{Adaptive, Placement};
use hemicube::volume::{Volume, file};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Bake an irradiance volume: spherical harmonics at points that fill the scene's bounds, for what moves in it
///
/// Captures the six faces of a cube at each sample and projects what they see onto spherical harmonics, with gradients. Samples stand
/// on a uniform grid, or in an octree where light changes. What is measured is light that surfaces have reflected once, and the
/// background's own light; lamps and emitters are left out: engines add them by themselves. Samples inside of geometry are
/// moved out of it where that is near, and marked where it is not.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct VolumeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the volume goes: a JSON file; --for bevy writes .ktx2
    #[arg(short, long, value_name = "OUT.json|OUT.ktx2")]
    output: PathBuf,
    /// Write what an engine takes: a uniform grid in its own measure, order and axes, instead of the volume that `hemicube probe`
    /// reads
    #[arg(long = "for", value_enum, value_name = "ENGINE")]
    engine: Option<EngineArg>,
    /// Samples along each side of the scene's bounds, 2 to 129: N³ of them. The default, with 9
    #[arg(long, value_name = "N", conflicts_with = "adaptive", help_heading = "Samples")]
    uniform: Option<u32>,
    /// Samples where light changes: an octree between --min-level and --max-level
    #[arg(long, help_heading = "Samples")]
    adaptive: bool,
    /// Level to which all cells are cut at first: level L has (2^L + 1)³ samples
    #[arg(long, value_name = "L", default_value_t = 2, requires = "adaptive", help_heading = "Samples")]
    min_level: u32,
    /// Finest level, 7 at most
    #[arg(long, value_name = "L", default_value_t = 4, requires = "adaptive", help_heading = "Samples")]
    max_level: u32,
    /// Cut a cell where the irradiance at its middle, read from its corners, is wrong by more than this share of the volume's mean
    #[arg(long, value_name = "E", default_value_t = 0.05, requires = "adaptive", help_heading = "Samples")]
    error: f64,
    /// Look at cells over which a corner's gradient changes the irradiance by more than this share of the mean
    #[arg(long, value_name = "X", default_value_t = 0.1, requires = "adaptive", help_heading = "Samples")]
    gradient_test: f64,
    /// Look at cells longer than this times the harmonic mean distance at a corner
    #[arg(long, value_name = "X", default_value_t = 1.0, requires = "adaptive", help_heading = "Samples")]
    harmonic_mean_test: f64,
    /// A place is inside of geometry where backs of triangles fill more than this share of the sphere
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, help_heading = "Samples")]
    inside: f32,
    /// Order of the harmonics, 2 to 6: its square is the number of coefficients
    #[arg(long, value_name = "N", default_value_t = 3)]
    order: u32,
    /// Texels a side of each of the six faces: even, 8 to 128
    #[arg(long, value_name = "TEXELS", default_value_t = 32)]
    capture_size: u32,
    /// How the gradients of all coefficients are found; none: a quarter of the memory, and trilinear interpolation
    #[arg(long, value_enum, default_value = "edges")]
    gradients: GradientsArg,
    /// Distance of the captures by which --gradients differences takes differences; default: a hundredth of the bounds' shortest side
    #[arg(long, value_name = "LENGTH")]
    gradient_step: Option<f64>,
    /// Leave the moments of the distances out, by which walls hide samples
    #[arg(long)]
    no_moments: bool,
    /// Write what the run was and cost as JSON
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

/// [`Gradients`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GradientsArg {
    /// None
    None,
    /// By the edges between what each sample sees
    Edges,
    /// By central differences of six more captures around each sample
    Differences,
}

/// [`Engine`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EngineArg {
    /// Bevy's IrradianceVolume: a 3D texture, .ktx2
    Bevy,
    /// three.js' LightProbe: radiance coefficients, .json
    Three,
    /// Godot's LightmapGIData: probes in tetrahedra, .json
    Godot,
    /// Unity's SphericalHarmonicsL2, x flipped as glTFast flips it, .json
    Unity,
}

impl From<EngineArg> for Engine {
    fn from(arg: EngineArg) -> Self {
        match arg {
            EngineArg::Bevy => Self::Bevy,
            EngineArg::Three => Self::Three,
            EngineArg::Godot => Self::Godot,
            EngineArg::Unity => Self::Unity,
        }
    }
}

const HELP: &str = "\
The file holds order, positions, coefficients (radiance, W/(sr m²): real, orthonormal harmonics without the Condon-Shortley
sign, in the order 1; y, z, x; xy, yz, 3z²-1, xz, x²-y²; …), gradients, cells, and of each sample the share of backs of triangles, the
harmonic mean distance and the moments of the distance by direction. The library's documentation of hemicube::volume::file
has the format in full. `hemicube probe --volume` reads it.

Example:
  hemicube bake volume -o cornell.json                              # 9³ samples in the built-in Cornell box
  hemicube bake volume hall.glb -o hall.json --uniform 17 --order 4
  hemicube bake volume hall.glb -o hall.ktx2 --for bevy --uniform 16
  hemicube bake volume hall.glb -o hall.json --adaptive --max-level 5 --error 0.02 --stats hall-stats.json

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device or device lost.";

/// Samples along a side where nothing says how many.
const USUAL: u32 = 9;

/// Runs the subcommand.
pub fn run(args: &VolumeArgs) -> Result<ExitCode> {
    let begun = Instant::now();
    args.check()?;
    let scene = args.scene.load()?;
    if args.talk.verbose {
        scene.notes.iter().for_each(|note| remark!("note: {note}"));
    }
    let device = args.device.open()?;
    let mut recorder = Recorder::new(&device);
    let mut stage: Option<Stage> = None;
    let mut on_progress = |all: usize, done: usize| match (&stage, done) {
        (Some(stage), 1..) => stage.advance(done as u64),
        _ => stage = Some(Progress::new(args.talk.quiet).stage("probes", all as u64)),
    };
    let (volume, placement) =
        bake(&device, &mut recorder, &scene, &args.settings(&scene), &mut on_progress).map_err(plain)?;
    drop(stage);
    let note = args.write(&volume)?;
    let seconds = begun.elapsed().as_secs_f64();
    if let Some(path) = &args.stats {
        args.stats(&device, &scene, &recorder, &volume, &placement, seconds).write(path)?;
    }
    if !args.talk.quiet {
        args.tell(&scene, &volume, &placement, seconds);
        note.into_iter().for_each(|note| say!("{note}"));
    }
    Ok(ExitCode::SUCCESS)
}

impl VolumeArgs {
    /// Writes the file, and says what whoever uses it has to know.
    fn write(&self, volume: &Volume) -> Result<Option<String>> {
        let Some(engine) = self.engine.map(Engine::from) else {
            file::write(&self.output, volume)?;
            return Ok(None);
        };
        let grid = Grid::of(volume);
        export::write(&self.output, &grid, engine)?;
        let [translation, scale] = bevy::transform(&grid);
        let place = || {
            format!(
                "place it by Transform {{ translation: {translation}, scale: {scale} }}, with intensity 1/exposure (Bevy's default is 0)"
            )
        };
        Ok((engine == Engine::Bevy).then(place))
    }

    fn check(&self) -> Result<()> {
        let wanted = self.engine.map_or("json", |engine| Engine::from(engine).extension());
        let fits = self.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
        ensure!(fits, "{}: this volume is a .{wanted} file; --for bevy alone is .ktx2", self.output.display());
        check_order(self.order)?;
        check_capture_size(self.capture_size)?;
        if let Some(uniform) = self.uniform {
            ensure!((2..=129).contains(&uniform), "--uniform {uniform}: a side has 2 to 129 samples");
        }
        let (low, high) = (self.min_level, self.max_level);
        ensure!(low <= high && high <= 7, "--min-level {low} --max-level {high}: levels rise from 0 to 7 at most");
        for (name, value) in [
            ("--error", self.error),
            ("--gradient-test", self.gradient_test),
            ("--harmonic-mean-test", self.harmonic_mean_test),
        ] {
            ensure!(value.is_finite() && value > 0.0, "{name} {value}: a number above 0 is wanted");
        }
        if let Some(step) = self.gradient_step {
            ensure!(step.is_finite() && step > 0.0, "--gradient-step {step}: a length above 0 is wanted");
        }
        let share = self.inside;
        ensure!((0.0..=1.0).contains(&share), "--inside {share}: a share lies between 0 and 1");
        [Some(&self.output), self.stats.as_ref()].into_iter().flatten().try_for_each(|path| check_output(path))
    }

    fn settings(&self, scene: &Scene) -> BakeSettings {
        let probes = SphereProbeSettings {
            order: self.order,
            capture_size: self.capture_size,
            capture: CaptureMode::Auto,
            gradients: false,
            distances: true,
            lights: Settings::default().lights,
            surface_cells: SphereProbeSettings::usual_cells(scene),
        };
        let adaptive = Adaptive {
            min_level: self.min_level,
            max_level: self.max_level,
            error: self.error,
            gradient: self.gradient_test,
            harmonic: self.harmonic_mean_test,
        };
        let uniform = Places::Uniform(self.uniform.unwrap_or(USUAL));
        let places = if self.adaptive { Places::Adaptive(adaptive) } else { uniform };
        BakeSettings {
            probes,
            places,
            gradients: self.gradients(scene),
            inside: self.inside,
            moments: !self.no_moments,
        }
    }

    fn gradients(&self, scene: &Scene) -> Gradients {
        let [low, high] = bounds(scene);
        match self.gradients {
            GradientsArg::None => Gradients::None,
            GradientsArg::Edges => Gradients::Edges,
            GradientsArg::Differences => {
                Gradients::Differences(self.gradient_step.unwrap_or(1e-2 * (high - low).min_element()))
            }
        }
    }

    fn stats(
        &self,
        device: &Device,
        scene: &Scene,
        recorder: &Recorder,
        volume: &Volume,
        placement: &Placement,
        seconds: f64,
    ) -> Stats {
        let mut stats = Stats::new();
        stats.device = device.physical.name.clone();
        stats.driver = device.physical.driver.trim().to_owned();
        stats.scene = SceneStats {
            triangles: scene.triangles.len() as u64,
            vertices: scene.positions.len() as u64,
            lights: scene.lights.len() as u64,
            materials: scene.parts.len() as u64,
        };
        let mut profile = Profile { wall_ms: seconds * 1e3, ..Profile::default() };
        profile.gpu_ms = recorder.submissions.iter().map(|span| span.end_ms - span.begin_ms).sum();
        for run in &recorder.passes {
            let pass = profile.pass(run.name);
            pass.gpu_ms.extend(run.gpu.as_ref().map(|span| span.end_ms - span.begin_ms));
            pass.cpu_ms += run.cpu.end_ms - run.cpu.begin_ms;
        }
        stats.set_times(&profile);
        stats.plan.run = profile.passes.iter().map(|pass| pass.name.clone()).collect();
        let memory = device.memory();
        stats.memory = Memory {
            gpu_bytes: memory.peak,
            by_use: memory.by_use.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect(),
        };
        stats.validation_messages = u64::from(device.instance.validation_messages());
        stats.extra.insert("order".into(), json!(volume.order));
        stats.extra.insert("placement".into(), json!(placement));
        let sample_memory = json!({"samples": volume.samples.len(), "by_order": table(volume.samples.len()),
            "floats_of_moments_per_sample": if volume.has_moments() { MOMENTS } else { 0 }});
        stats.extra.insert("sample_memory".into(), sample_memory);
        if let Places::Adaptive(settings) = self.settings(scene).places {
            let uniform = ((1_usize << settings.max_level) + 1).pow(3);
            let beside = json!({"settings": settings, "samples_of_a_uniform_grid": uniform,
                "memory_of_a_uniform_grid": table(uniform)});
            stats.extra.insert("adaptive".into(), beside);
        }
        stats
    }

    fn tell(&self, scene: &Scene, volume: &Volume, placement: &Placement, seconds: f64) {
        say!(
            "{}: {} samples of order {} in {} cells ({} moved out of geometry, {} inside), {} measured in {seconds:.1} s",
            scene.name,
            placement.samples,
            volume.order,
            placement.cells,
            placement.moved,
            placement.inside,
            placement.measured
        );
        if 2 * placement.inside > placement.samples {
            remark!("warning: most samples are inside of geometry: if its triangles face outwards, use --inside 1");
        }
        self.tell_levels(placement);
        let mut memory = Table::new(&["order", "floats a sample", "with gradients", "all samples", "with gradients"]);
        for row in table(volume.samples.len()) {
            memory.row([
                row.order.to_string(),
                row.floats_per_sample.to_string(),
                row.floats_per_sample_with_gradients.to_string(),
                plain_bytes(row.bytes),
                plain_bytes(row.bytes_with_gradients),
            ]);
        }
        say!("\n{}", memory.to_string().trim_end());
        if volume.has_moments() {
            say!("moments of the distances: {MOMENTS} floats a sample besides");
        }
        say!("wrote {}", self.output.display());
    }

    fn tell_levels(&self, placement: &Placement) {
        if placement.levels.is_empty() {
            return;
        }
        let heads = ["level", "cells", "by gradient", "by geometry", "by harmonic mean", "measured", "cut"];
        let mut levels = Table::new(&heads);
        for level in &placement.levels {
            let counts =
                [level.cells, level.by_gradient, level.by_geometry, level.by_harmonic_mean, level.measured, level.cut];
            levels.row(std::iter::once(level.level.to_string()).chain(counts.map(|count| count.to_string())));
        }
        say!("\n{}", levels.to_string().trim_end());
        say!("culled: {} cells, {} samples", placement.culled_cells, placement.culled_samples);
        let uniform = ((1_usize << self.max_level) + 1).pow(3);
        let share = 100.0 * placement.samples as f64 / uniform as f64;
        say!("{share:.0} % of the {uniform} samples of a uniform grid of level {}", self.max_level);
    }
}

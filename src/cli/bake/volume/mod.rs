//! `hemicube bake volume`: irradiance volumes for objects that move.

mod args;
mod report;

pub use args::VolumeArgs;

use crate::cli::probe::plain;
use crate::cli::say::{remark, say};
use anyhow::Result;
use args::GradientsArg;
use glam::{DVec3, UVec3};
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::sphere_probes::SphereProbeSettings;
use hemicube::methods::volume::{BakeSettings, Gradients, Places, bake, bounds};
use hemicube::renderer::Settings;
use hemicube::report::progress::{Progress, Stage};
use hemicube::scene::Scene;
use hemicube::vk::pass::Recorder;
use hemicube::volume::export::{self, Engine, Grid};
use hemicube::volume::place::Adaptive;
use hemicube::volume::{Volume, file};
use report::Run;
use std::process::ExitCode;
use std::time::Instant;

/// Samples along each side without `--uniform`.
const USUAL: UVec3 = UVec3::splat(9);

/// Runs the subcommand.
pub fn run(args: &VolumeArgs) -> Result<ExitCode> {
    let begun = Instant::now();
    args.check()?;
    let scene = args.scene.load()?;
    if args.talk.verbose {
        scene.notes.iter().for_each(|note| remark!("note: {note}"));
    }
    let settings = args.settings(&scene, args.bounds(bounds(&scene))?);
    let device = args.device.open()?;
    let mut recorder = Recorder::new(&device);
    let mut stage: Option<Stage> = None;
    let mut on_progress = |all: usize, done: usize| match (&stage, done) {
        (Some(stage), 1..) => stage.advance(done as u64),
        _ => stage = Some(Progress::new(args.talk.quiet).stage("samples", all as u64)),
    };
    let (volume, placement) = bake(&device, &mut recorder, &scene, &settings, &mut on_progress).map_err(plain)?;
    drop(stage);
    let note = write(args, &scene, &volume)?;
    let seconds = begun.elapsed().as_secs_f64();
    let run = Run { scene: &scene, volume: &volume, placement: &placement, places: &settings.places, seconds };
    if let Some(path) = &args.stats {
        run.stats(&device, &recorder).write(path)?;
    }
    if !args.talk.quiet {
        run.tell();
        say!("wrote {}", args.output.display());
        note.into_iter().for_each(|note| say!("{note}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the file, and says how an engine places it where the file cannot.
fn write(args: &VolumeArgs, scene: &Scene, volume: &Volume) -> Result<Option<String>> {
    let Some(engine) = args.engine.map(Engine::from) else {
        file::write(&args.output, volume)?;
        return Ok(None);
    };
    let grid = Grid::of(volume);
    export::write(&args.output, &grid, engine)?;
    Ok((engine == Engine::Bevy).then(|| report::bevy_note(&grid, !scene.lights.is_empty())))
}

impl VolumeArgs {
    fn settings(&self, scene: &Scene, bounds: [DVec3; 2]) -> BakeSettings {
        let probes = SphereProbeSettings {
            order: self.order,
            capture_size: self.capture_size,
            capture: CaptureMode::Auto,
            gradients: false,
            distances: None,
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
        let gradients = match self.gradients {
            GradientsArg::None => Gradients::None,
            GradientsArg::Edges => Gradients::Edges,
            GradientsArg::Differences => {
                let step = || 1e-2 * (bounds[1] - bounds[0]).min_element();
                Gradients::Differences(self.gradient_step.unwrap_or_else(step))
            }
        };
        BakeSettings { probes, places, bounds, gradients, inside: self.inside, moments: !self.no_moments }
    }
}

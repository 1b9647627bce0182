//! From arguments to a job, and from a result to files.

use super::{Method, ReferenceArgs, Show, draw};
use crate::cli::choices::{GradientsArg, WeightArg};
use crate::cli::say::remark;
use anyhow::{Context, Result, bail, ensure};
use hemicube::image::tone::Look;
use hemicube::image::{Picture, exr, png};
use hemicube::reference::ward::Settings as WardSettings;
use hemicube::reference::{Cached, Cost, Progressive, Settings, Stop, batch_for, open_batch};
use hemicube::report::progress::{Progress, Stage};
use hemicube::scene::{self, Camera, Scene};
use std::path::Path;

/// Paths a pixel where nothing stops the run.
pub const PATH_SPP: u32 = 256;
/// Paths a pixel for the direct light beside an irradiance cache.
pub const WARD_SPP: u32 = 64;
/// Largest image, pixels: a state takes 216 bytes a pixel.
const MOST_PIXELS: u64 = 1 << 26;

/// Validated arguments and the loaded scene.
pub struct Job {
    pub scene: Scene,
    pub camera: Camera,
    pub size: (u32, u32),
}

/// A finished picture, what it cost and what it is.
pub struct Output {
    pub picture: Picture,
    /// Name of a stage and its cost.
    pub stages: Vec<(&'static str, Cost)>,
    pub spp: u64,
    pub relative_error: Option<f64>,
    pub records: usize,
}

/// Checks the arguments before anything is computed, loads the scene and sets the number of threads.
pub fn job(args: &ReferenceArgs) -> Result<Job> {
    let extension = args.output.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    ensure!(matches!(extension.as_str(), "exr" | "png"), "{:?} is neither .exr nor .png", args.output);
    for file in [Some(&args.output), args.resume.as_ref(), args.stats.as_ref()].into_iter().flatten() {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        ensure!(
            folder.is_none_or(Path::is_dir),
            "cannot write {file:?}: there is no folder {:?}",
            folder.unwrap_or(file)
        );
    }
    if args.method == Method::Ward {
        ensure!(args.bounces > 0, "--method ward caches indirect light: it needs --bounces 1 or more");
        ensure!(args.ward.min_radius <= args.ward.max_radius, "--min-radius is larger than --max-radius");
        let path_only = [args.resume.is_some(), args.time.is_some(), args.relative_error.is_some()];
        ensure!(!path_only.contains(&true), "--resume, --time and --relative-error go with --method path alone");
    } else {
        ensure!(args.show.is_none(), "--show records needs --method ward: paths make no records");
        let notes = without_effect(args);
        notes.iter().filter(|_| !args.quiet).for_each(|note| remark!("note: {note}"));
    }
    if let Some(threads) = args.threads {
        ensure!((1..=4096).contains(&threads), "--threads {threads} is not between 1 and 4096");
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().context("cannot start the threads")?;
    }
    load(args)
}

/// A note for each flag of the irradiance cache that does not have its default where paths are traced.
fn without_effect(args: &ReferenceArgs) -> Vec<String> {
    let (ward, usual) = (&args.ward, WardSettings::default());
    let flags = [
        ("--accuracy", ward.accuracy != usual.accuracy),
        ("--rays", ward.rays != usual.rays),
        ("--weight", ward.weight != WeightArg::Ward),
        ("--gradients", ward.gradients != GradientsArg::Both),
        ("--no-gradient-limit", ward.no_gradient_limit),
        ("--no-neighbour-clamping", ward.no_neighbour_clamping),
        ("--min-radius", ward.min_radius != usual.min_radius),
        ("--max-radius", ward.max_radius != usual.max_radius),
    ];
    let given = flags.into_iter().filter(|(_, given)| *given);
    given.map(|(flag, _)| format!("{flag} has no effect: it belongs to --method ward")).collect()
}

fn load(args: &ReferenceArgs) -> Result<Job> {
    let scene = args.scene.load()?;
    let (camera, note) = args.scene.camera(&scene)?;
    if !args.quiet {
        scene.notes.iter().chain(&note).for_each(|note| remark!("note: {note}"));
    }
    let size = scene::image_size(&camera, args.image.width, args.image.height);
    let largest = scene::LARGEST_SIDE;
    let sides = 1..=largest;
    if !sides.contains(&size.0) || !sides.contains(&size.1) {
        bail!("an image of {} × {} pixels: each side must be 1 to {largest}", size.0, size.1);
    }
    ensure!(u64::from(size.0) * u64::from(size.1) <= MOST_PIXELS, "more than {MOST_PIXELS} pixels: make it smaller");
    Ok(Job { scene, camera, size })
}

impl Job {
    pub fn path_settings(&self, args: &ReferenceArgs) -> Settings {
        let open = args.relative_error.is_some() || args.time.is_some() || args.resume.is_some();
        let batch = if open {
            open_batch(u64::from(self.size.0) * u64::from(self.size.1))
        } else {
            batch_for(args.spp.unwrap_or(PATH_SPP))
        };
        Settings { bounces: args.bounces, seed: args.seed, batch }
    }

    pub fn ward_settings(&self, args: &ReferenceArgs) -> WardSettings {
        let ward = &args.ward;
        WardSettings {
            accuracy: ward.accuracy,
            rays: ward.rays,
            min_radius: ward.min_radius,
            max_radius: ward.max_radius,
            weight: ward.weight.into(),
            gradients: ward.gradients.into(),
            gradient_limit: !ward.no_gradient_limit,
            neighbour_clamping: !ward.no_neighbour_clamping,
            bounces: args.bounces,
            seed: args.seed,
        }
    }
}

impl Output {
    pub fn path(run: &Progressive, cost: Cost) -> Self {
        let error = run.relative_error();
        Self {
            picture: run.picture(),
            stages: vec![("paths", cost)],
            spp: run.spp(),
            relative_error: error.is_finite().then_some(error),
            records: 0,
        }
    }

    pub fn ward(args: &ReferenceArgs, result: Cached) -> Self {
        let mut picture = result.picture;
        if args.show == Some(Show::Records) {
            draw::records(&mut picture, &result.cache.records);
        }
        Self {
            picture,
            stages: vec![
                ("direct light", result.direct),
                ("records", result.fill),
                ("interpolation", result.interpolate),
            ],
            spp: u64::from(args.spp.unwrap_or(WARD_SPP)),
            relative_error: None,
            records: result.cache.records.len(),
        }
    }
}

/// Writes the picture, with the settings kept in an EXR file.
pub fn write(args: &ReferenceArgs, output: &Output) -> Result<()> {
    let path: &Path = &args.output;
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Ok(png::write(path, &output.picture, "", Look::default())?);
    }
    let bounces = bounces_name(args.bounces);
    let (spp, seed) = (output.spp.to_string(), args.seed.to_string());
    let mut settings =
        vec![("method", args.method_name()), ("bounces", &bounces), ("spp", spp.as_str()), ("seed", seed.as_str())];
    let ward = format!("{:?}", args.ward);
    if args.method == Method::Ward {
        settings.push(("ward", &ward));
    }
    Ok(exr::write(path, &output.picture, &settings)?)
}

impl ReferenceArgs {
    pub fn method_name(&self) -> &'static str {
        match self.method {
            Method::Path => "path",
            Method::Ward => "ward",
        }
    }
}

/// Progress towards whichever stop rule has the most predictable end.
pub struct Bar {
    stage: Stage,
    stop: Stop,
    begun: std::time::Instant,
}

impl Bar {
    const STEPS: u64 = 10_000;

    pub fn new(progress: Progress, stop: &Stop) -> Self {
        Self { stage: progress.stage("paths", Self::STEPS), stop: *stop, begun: std::time::Instant::now() }
    }

    pub fn show(&self, run: &Progressive) {
        let by_spp = self.stop.spp.map_or(0.0, |spp| run.spp() as f64 / f64::from(spp));
        let by_time = self.stop.time.map_or(0.0, |t| self.begun.elapsed().as_secs_f64() / t.as_secs_f64());
        // The error falls with the root of the work.
        let by_error = self.stop.relative_error.map_or(0.0, |limit| (limit / run.relative_error()).powi(2));
        let part = by_spp.max(by_time).max(by_error).clamp(0.0, 1.0);
        self.stage.advance(((part * Self::STEPS as f64) as u64).saturating_sub(self.stage.done()));
    }
}

/// `all` or a number.
pub fn parse_bounces(text: &str) -> Result<u32, String> {
    if text == "all" {
        return Ok(Settings::ALL_BOUNCES);
    }
    text.parse().map_err(|_| format!("{text:?} is neither a number nor all"))
}

/// The reverse of [`parse_bounces`].
pub fn bounces_name(bounces: u32) -> String {
    if bounces == Settings::ALL_BOUNCES { "all".into() } else { bounces.to_string() }
}

/// A finite number above 0.
pub fn parse_positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{text} is not above 0")) }
}

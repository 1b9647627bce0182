//! `hemicube render`: an image with indirect light, or a sequence of them.

mod args;
mod bounces;
mod cache;
mod choices;
mod path;
mod probes;
mod report;
mod sequence;
mod settings;
mod without_effect;

pub use args::RenderArgs;

use super::common::{TalkArgs, check_output};
use super::say::remark;
use super::stop;
use anyhow::{Context, Result, bail};
use hemicube::image::tone::{Exposure, Look, auto_stops};
use hemicube::image::{Picture, exr, png};
use hemicube::renderer::{Renderer, Settings};
use hemicube::report::progress::{Progress, Stage};
use hemicube::scene::{Camera, Scene};
use hemicube::vk::Device;
use hemicube::volume::file;
use report::Report;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Runs the subcommand.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let started = Instant::now();
    let picture_kind = args.output.as_deref().map_or(Ok(Kind::Png), Kind::of)?;
    for path in [args.output.as_ref(), args.stats.as_ref(), args.trace.as_ref()].into_iter().flatten() {
        check_output(path)?;
    }
    args.cache.check()?;
    if let Some(path) = path::CameraPath::new(&args.path, &args.scene)? {
        return sequence::run(args, path, picture_kind, started);
    }
    let output = args.output.as_deref().context("an image goes into a file: -o names it")?;
    let volume = args.show_probes.as_deref().map(file::read).transpose()?;
    let scene = args.scene.load()?;
    let (camera, note) = args.scene.camera(&scene)?;
    let settings = args.settings(&camera, picture_kind);
    let mut records = args.cache.open(&scene, &settings)?;
    let (device, mut report) = open_device(args, (&scene, note.as_deref()), &settings, started)?;
    warn(args, picture_kind, &scene);
    let mut listener = Listener::new(args.talk);
    let mut hear = |name, done, all| listener.hear(name, done, all);
    let mut renderer = Renderer::open(&device, &scene, &settings, &mut hear)?;
    report.plan(renderer.plan());
    if let Some(records) = &mut records {
        records.fill(&mut renderer)?;
    }
    renderer.stop_when(|| stop::is_asked() || args.is_over(started));
    stop::finishes(true);
    let mut rendered = renderer.render(&camera, &settings.view(), &mut hear)?;
    drop(listener);
    report.check(&rendered);
    if let Some(volume) = &volume {
        probes::draw(&mut rendered.picture, &scene, &camera, volume);
    }
    let writing = Instant::now();
    let made_with = report.made_with(args, &scene, &camera, &settings);
    let file = Destination { path: output, made_with: &made_with, camera: &camera };
    write(args, (picture_kind, args.exposure.unwrap_or_default()), &rendered.picture, &file)?;
    stop::finishes(false);
    if let Some(records) = &mut records {
        if !rendered.cache.unfinished {
            records.save(&renderer)?;
        }
        report.extra("cache_file", records.stats());
    }
    report.rendered(&rendered, writing.elapsed());
    if args.measure {
        report.measure()?;
    }
    report.finish(args, &scene, &rendered, &made_with)?;
    Ok(ExitCode::SUCCESS)
}

impl RenderArgs {
    /// Whether the time for records, or for frames, is over.
    fn is_over(&self, started: Instant) -> bool {
        self.time_limit.is_some_and(|seconds| started.elapsed().as_secs_f64() > seconds)
    }
}

/// Opens the device for a scene that is loaded, and begins the report of the run.
fn open_device(
    args: &RenderArgs,
    (scene, note): (&Scene, Option<&str>),
    settings: &Settings,
    started: Instant,
) -> Result<(Arc<Device>, Report)> {
    let loaded = started.elapsed();
    let device = args.device.open()?;
    settings.check(&device)?;
    let mut report = Report::new(args, started, &device);
    report.stage("load scene", loaded);
    report.stage("open device", started.elapsed() - loaded);
    report.scene(scene, note, settings);
    Ok((device, report))
}

/// Warns of a scene without light, and of flags that do nothing for this kind of picture; nothing with --quiet.
fn warn(args: &RenderArgs, kind: Kind, scene: &Scene) {
    if args.talk.quiet {
        return;
    }
    if scene.is_dark() {
        remark!(
            "warning: the scene has no light, so the picture is black: --default-light adds a soft sky, --background R,G,B \
             a sky of your choice; in Blender's glTF export, tick Punctual Lights"
        );
    }
    args.without_effect(kind).iter().for_each(|note| remark!("note: {note}"));
}

/// A file that a picture is written to, and what it says of itself.
struct Destination<'a> {
    path: &'a Path,
    made_with: &'a [(&'static str, String)],
    camera: &'a Camera,
}

/// Writes a picture; the exposure that it was given.
fn write(
    args: &RenderArgs,
    (kind, mut exposure): (Kind, Exposure),
    picture: &Picture,
    to: &Destination<'_>,
) -> Result<Exposure> {
    let mut look = || {
        let stops = stops(exposure, picture, args.talk.quiet);
        exposure = Exposure::Stops(stops);
        Look { tone: args.tone.unwrap_or_default(), stops }
    };
    match kind {
        Kind::Exr => exr::write_seen(to.path, picture, to.made_with, Some(world_to_camera(to.camera)))?,
        Kind::Hdr => png::write_hdr(to.path, picture, "")?,
        Kind::Png => png::write(to.path, picture, "", look())?,
        Kind::Jpeg => png::write_jpeg(to.path, picture, "", look())?,
    }
    stop::keeps(format!("{} is complete", to.path.display()));
    Ok(exposure)
}

/// OpenEXR's `worldToCamera`: row vectors, y up, z in the direction of sight.
fn world_to_camera(camera: &Camera) -> [f32; 16] {
    let forward = glam::DMat4::from_scale(glam::DVec3::new(1.0, 1.0, -1.0));
    (forward * camera.camera_to_world.inverse()).as_mat4().to_cols_array()
}

/// The exposure in stops; one found from the picture is printed.
fn stops(exposure: Exposure, picture: &Picture, quiet: bool) -> f32 {
    match exposure {
        Exposure::Stops(stops) => stops,
        Exposure::Auto => {
            let stops = picture.rgb("").map_or(0.0, auto_stops);
            if !quiet {
                remark!("exposure {stops:+.1} stops (--exposure STOPS sets it)");
            }
            stops
        }
    }
}

/// Shows the progress of the renderer's stages.
struct Listener {
    progress: Progress,
    stage: Option<(&'static str, Stage)>,
}

impl Listener {
    fn new(talk: TalkArgs) -> Self {
        Self { progress: Progress::new(talk.quiet), stage: None }
    }

    fn hear(&mut self, name: &'static str, done: u64, all: u64) {
        if self.stage.as_ref().is_none_or(|(current, _)| *current != name) {
            self.stage = Some((name, self.progress.stage(name, all)));
        }
        if let Some((_, stage)) = &self.stage {
            stage.advance(done.saturating_sub(stage.done()));
        }
    }
}

/// Kind of the output file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Linear floats, with layers.
    Exr,
    /// Linear values of a common exponent, the colour alone.
    Hdr,
    /// Tone-mapped.
    Png,
    /// Tone-mapped, with losses.
    Jpeg,
}

impl Kind {
    /// Whether it holds radiance, not what a screen shows.
    fn is_linear(self) -> bool {
        matches!(self, Self::Exr | Self::Hdr)
    }

    /// By the name's extension.
    fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("hdr") => Ok(Self::Hdr),
            Some("png") => Ok(Self::Png),
            Some("jpg" | "jpeg") => Ok(Self::Jpeg),
            _ => bail!("cannot tell the format of {}: name it .exr, .hdr, .png or .jpg", path.display()),
        }
    }
}

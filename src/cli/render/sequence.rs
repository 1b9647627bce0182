//! A sequence of frames: the scene stays on the device, and records are kept from frame to frame.

use super::args::RenderArgs;
use super::cache::RecordFile;
use super::path::{CameraPath, file_of};
use super::report::Report;
use super::{Destination, Kind, Listener, open_device, stops, warn, write};
use crate::cli::say::{divert, remark, say};
use anyhow::{Context, Result, ensure};
use hemicube::image::Picture;
use hemicube::image::tone::{Exposure, Look};
use hemicube::image::y4m::Video;
use hemicube::renderer::{Rendered, Renderer, Settings};
use hemicube::scene::{Camera, Scene};
use hemicube::vk::Device;
use serde_json::{Value, json};
use std::io::{self, Stdout};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A run on its way through its frames.
struct Sequence<'a> {
    args: &'a RenderArgs,
    kind: Kind,
    path: CameraPath,
    device: Arc<Device>,
    report: Report,
    settings: Settings,
    records: Option<RecordFile>,
    /// Whether these are of the scene that is shown now.
    keeps_records: bool,
    /// That of the first frame, so that the others do not flicker.
    exposure: Exposure,
    /// Where the frames go besides their files.
    video: Option<Video<Stdout>>,
    started: Instant,
    next: Option<u32>,
    /// Frames that were there.
    skipped: u32,
    rows: Vec<Value>,
    total: Option<Rendered>,
    writing: Duration,
}

/// Renders the frames of `path`.
pub fn run(args: &RenderArgs, mut path: CameraPath, kind: Kind, started: Instant) -> Result<ExitCode> {
    if args.path.y4m {
        divert();
    }
    let looks_alike = kind.is_linear() || args.exposure.is_some_and(|exposure| exposure != Exposure::Auto);
    ensure!(
        !args.path.resume || looks_alike,
        "--resume needs --exposure STOPS, the same in every run: frames would not look alike"
    );
    ensure!(!args.measure, "--measure is of one image; leave --frames out");
    let mut scene = path.load(&args.scene)?;
    let (camera, note) = args.scene.camera(&scene)?;
    let settings = args.settings(&camera, kind);
    let records = args.cache.open(&scene, &settings)?;
    let (device, report) = open_device(args, (&scene, note.as_deref()), &settings, started)?;
    warn(args, kind, &scene);
    let size = [settings.width, settings.height];
    let video = args.path.y4m.then(|| Video::new(io::stdout(), size, path.fps)).transpose();
    let mut sequence = Sequence {
        video: video.context("cannot write the video to the standard output")?,
        args,
        kind,
        next: Some(*path.frames.start()),
        path,
        device,
        report,
        settings,
        records,
        keeps_records: false,
        exposure: args.exposure.unwrap_or_default(),
        started,
        skipped: 0,
        rows: Vec::new(),
        total: None,
        writing: Duration::ZERO,
    };
    while let Some(changed) = sequence.frames_of(&scene)? {
        scene = changed;
    }
    sequence.finish(&scene)
}

impl Sequence<'_> {
    /// Renders frames as long as they show `scene` from wherever; what the next frame shows where that is something else.
    fn frames_of(&mut self, scene: &Scene) -> Result<Option<Scene>> {
        let mut listener = Listener::new(self.args.talk);
        let mut renderer =
            Renderer::open(&self.device, scene, &self.settings, &mut |name, done, all| listener.hear(name, done, all))?;
        drop(listener);
        if self.rows.is_empty() {
            self.report.plan(renderer.plan());
        }
        self.fill(&mut renderer, scene)?;
        self.frames_by(&mut renderer, scene)
    }

    /// Takes over the file's records, if they are of this scene.
    fn fill(&mut self, renderer: &mut Renderer<'_>, scene: &Scene) -> Result<()> {
        let Some(records) = &mut self.records else { return Ok(()) };
        self.keeps_records = records.is_of(scene, &self.settings);
        if self.keeps_records {
            records.fill(renderer)?;
        } else if !self.args.talk.quiet {
            remark!("note: {} is of the first frame's scene: it serves no others", records.path().display());
        }
        Ok(())
    }

    fn frames_by(&mut self, renderer: &mut Renderer<'_>, scene: &Scene) -> Result<Option<Scene>> {
        let own = self.args.scene.camera(scene)?.0;
        let made_with = self.report.made_with(self.args, scene, &own, &self.settings);
        while let Some(frame) = self.next {
            if self.args.is_over(self.started) {
                return Ok(None);
            }
            if self.is_done(frame) {
                self.skipped += 1;
                self.next = self.after(frame);
                continue;
            }
            let begun = Instant::now();
            let moment = self.path.scene(&self.args.scene, frame)?;
            if let Some(what) = moment.as_ref().and_then(|moment| scene.change_to(moment)) {
                if !self.args.talk.quiet {
                    remark!("note: frame {frame}: {what} changed, so that its records are made anew");
                }
                return Ok(moment.map(|moment| self.path.at_rest(moment)));
            }
            let shown = moment.as_ref().unwrap_or(scene);
            let own = self.args.scene.camera(shown)?.0;
            let camera = self.path.camera(shown, &own, frame)?;
            self.frame(renderer, &camera, &made_with, (frame, begun)).with_context(|| format!("frame {frame}"))?;
            self.next = self.after(frame);
        }
        Ok(None)
    }

    fn after(&self, frame: u32) -> Option<u32> {
        (frame < *self.path.frames.end()).then(|| frame + 1)
    }

    /// Whether an earlier run made the frame, and this one is to go on after it.
    fn is_done(&self, frame: u32) -> bool {
        let is_there = |output: &PathBuf| file_of(output, frame).is_file();
        self.args.path.resume && self.args.output.as_ref().is_some_and(is_there)
    }

    fn frame(
        &mut self,
        renderer: &mut Renderer<'_>,
        camera: &Camera,
        made_with: &[(&'static str, String)],
        (frame, begun): (u32, Instant),
    ) -> Result<()> {
        let mut listener = Listener::new(self.args.talk);
        let mut rendered =
            renderer.render(camera, &self.settings.view(), &mut |name, done, all| listener.hear(name, done, all))?;
        self.report.check(&rendered);
        let writing = Instant::now();
        // Before the picture: a run that goes on after it shall have them.
        if let Some(records) = self.records.as_mut().filter(|_| self.keeps_records) {
            records.save(renderer)?;
        }
        self.show(&rendered.picture)?;
        let output = self.args.output.as_ref().map(|output| file_of(output, frame));
        if let Some(path) = &output {
            let file = Destination { path, made_with, camera };
            self.exposure = write(self.args, (self.kind, self.exposure), &rendered.picture, &file)?;
        }
        self.writing += writing.elapsed();
        let name = output.map_or_else(|| format!("frame {frame}"), |path| path.display().to_string());
        let (cache, seconds) = (rendered.cache, begun.elapsed().as_secs_f64());
        let gpu_ms: f64 = rendered.submissions.iter().map(|span| span.end_ms - span.begin_ms).sum();
        self.rows.push(json!({"frame": frame, "records": cache.records, "reused": cache.reused, "seconds": seconds,
            "gpu_ms": gpu_ms, "file": name}));
        if !self.args.talk.quiet {
            let (records, reused) = (cache.records, cache.reused);
            say!("{name}: {records} new records, {reused} reused, {seconds:.2} s");
        }
        if let Some(total) = self.total.take() {
            add(&mut rendered, total);
        }
        self.total = Some(rendered);
        Ok(())
    }

    /// Adds a frame to the video.
    fn show(&mut self, picture: &Picture) -> Result<()> {
        let Some(video) = &mut self.video else { return Ok(()) };
        let stops = stops(self.exposure, picture, self.args.talk.quiet);
        self.exposure = Exposure::Stops(stops);
        let look = Look { tone: self.args.tone.unwrap_or_default(), stops };
        video.write(picture, look).context("cannot write the video to the standard output")
    }

    fn finish(mut self, scene: &Scene) -> Result<ExitCode> {
        if self.skipped > 0 && !self.args.talk.quiet {
            say!("{} frames were there already", self.skipped);
        }
        if let Some(next) = self.next.filter(|_| !self.args.talk.quiet) {
            say!("stopped before frame {next}, by --time-limit; --resume goes on");
        }
        let Some(total) = self.total.take() else { return Ok(ExitCode::SUCCESS) };
        self.report.rendered(&total, self.writing);
        self.report.extra("frames", Value::Array(self.rows));
        if let Some(records) = &self.records {
            self.report.extra("cache_file", records.stats());
        }
        let args = self.args;
        let own = args.scene.camera(scene)?.0;
        let made_with = self.report.made_with(args, scene, &own, &self.settings);
        self.report.finish(args, scene, &total, &made_with)?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Adds what earlier frames took.
fn add(rendered: &mut Rendered, mut earlier: Rendered) {
    earlier.passes.append(&mut rendered.passes);
    earlier.submissions.append(&mut rendered.submissions);
    earlier.stages.append(&mut rendered.stages);
    (rendered.passes, rendered.submissions, rendered.stages) = (earlier.passes, earlier.submissions, earlier.stages);
    rendered.cache.records += earlier.cache.records;
    rendered.cache.rounds += earlier.cache.rounds;
}

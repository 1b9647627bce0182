//! A sequence of frames: the scene stays on the device, and records are kept from frame to frame.

use super::args::RenderArgs;
use super::path::{CameraPath, file_of};
use super::report::Report;
use super::{Destination, Kind, Listener, warn, write};
use crate::cli::say::{remark, say};
use anyhow::{Context, Result, ensure};
use hemicube::image::tone::Exposure;
use hemicube::renderer::{Rendered, Renderer, Settings};
use hemicube::scene::{Camera, Scene};
use hemicube::vk::Device;
use serde_json::{Value, json};
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
    /// That of the first frame, so that the others do not flicker.
    exposure: Exposure,
    next: Option<u32>,
    rows: Vec<Value>,
    total: Option<Rendered>,
    writing: Duration,
}

/// Renders the frames of `path`.
pub fn run(args: &RenderArgs, path: CameraPath, kind: Kind, started: Instant) -> Result<ExitCode> {
    ensure!(!args.measure, "--measure is of one image; leave --frames out");
    let mut scene = path.load(&args.scene)?;
    let (camera, note) = args.scene.camera(&scene)?;
    let settings = args.settings(&camera, kind);
    let loaded = started.elapsed();
    let device = args.device.open()?;
    settings.check(&device)?;
    let mut report = Report::new(args, started, &device);
    report.stage("load scene", loaded);
    report.stage("open device", started.elapsed() - loaded);
    report.scene(&scene, note.as_deref(), &settings);
    if !args.talk.quiet {
        warn(args, kind, &scene);
    }
    let mut sequence = Sequence {
        args,
        kind,
        next: Some(*path.frames.start()),
        path,
        device,
        report,
        settings,
        exposure: args.exposure.unwrap_or_default(),
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
        if self.rows.is_empty() {
            self.report.plan(renderer.plan());
        }
        let own = self.args.scene.camera(scene)?.0;
        let made_with = self.report.made_with(self.args, scene, &own, &self.settings);
        while let Some(frame) = self.next {
            let begun = Instant::now();
            let moment = self.path.scene(&self.args.scene, frame)?;
            if let Some(what) = moment.as_ref().and_then(|moment| scene.change_to(moment)) {
                if !self.args.talk.quiet {
                    remark!("note: frame {frame}: {what} changed, so that its records are made anew");
                }
                return Ok(moment);
            }
            let shown = moment.as_ref().unwrap_or(scene);
            let own = self.args.scene.camera(shown)?.0;
            let camera = self.path.camera(shown, &own, frame)?;
            self.frame(&mut renderer, &camera, &made_with, (frame, begun)).with_context(|| format!("frame {frame}"))?;
            self.next = (frame < *self.path.frames.end()).then(|| frame + 1);
        }
        Ok(None)
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
        let output = file_of(&self.args.output, frame);
        let file = Destination { path: &output, made_with, camera };
        self.exposure = write(self.args, (self.kind, self.exposure), &rendered.picture, &file)?;
        self.writing += writing.elapsed();
        let (cache, seconds) = (rendered.cache, begun.elapsed().as_secs_f64());
        let gpu_ms: f64 = rendered.submissions.iter().map(|span| span.end_ms - span.begin_ms).sum();
        self.rows.push(json!({"frame": frame, "records": cache.records, "reused": cache.reused, "seconds": seconds,
            "gpu_ms": gpu_ms, "file": output.display().to_string()}));
        if !self.args.talk.quiet {
            let (records, reused) = (cache.records, cache.reused);
            say!("{}: {records} new records, {reused} reused, {seconds:.2} s", output.display());
        }
        if let Some(total) = self.total.take() {
            add(&mut rendered, total);
        }
        self.total = Some(rendered);
        Ok(())
    }

    fn finish(mut self, scene: &Scene) -> Result<ExitCode> {
        let total = self.total.take().context("a sequence has a frame")?;
        self.report.rendered(&total, self.writing);
        self.report.extra("frames", Value::Array(self.rows));
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

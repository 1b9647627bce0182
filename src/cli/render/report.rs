//! What a render says: messages on the standard error output, the table of results on the standard output, and the files of
//! `--stats` and `--trace`.

use super::args::RenderArgs;
use super::bounces::{in_numbers, in_words};
use crate::cli::common::TalkArgs;
use crate::cli::say::{remark, say};
use anyhow::Result;
use hemicube::methods::rates::Rates;
use hemicube::methods::surface_cache::ALL_BOUNCES;
use hemicube::renderer::{Part, Plan, Rendered, Settings};
use hemicube::report::limits::Share;
use hemicube::report::profile::{PassTimes, Profile};
use hemicube::report::stats::{LeftOut, Memory, Plan as PlanStats, SceneStats, Stats};
use hemicube::report::trace::Trace;
use hemicube::scene::{Camera, Scene};
use hemicube::vk::{Device, Span};
use serde_json::json;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Notes on the file that are shown without `-v`.
const NOTES: usize = 6;

/// Gathers what a run has to say.
pub struct Report {
    talk: TalkArgs,
    validates: bool,
    started: Instant,
    device: Arc<Device>,
    stages: Vec<(String, f64)>,
    rates: Option<Rates>,
    extra: Vec<(&'static str, serde_json::Value)>,
}

impl Report {
    /// A run that began at `started`.
    pub fn new(args: &RenderArgs, started: Instant, device: &Arc<Device>) -> Self {
        Self {
            talk: args.talk,
            validates: args.device.validate,
            started,
            device: device.clone(),
            stages: Vec::new(),
            rates: None,
            extra: Vec::new(),
        }
    }

    /// Notes a stage of the CPU.
    pub fn stage(&mut self, name: &str, length: Duration) {
        self.stages.push((name.into(), length.as_secs_f64() * 1e3));
    }

    /// Says what is rendered and on what, with the notes on the file.
    pub fn scene(&self, scene: &Scene, note: Option<&str>, settings: &Settings) {
        if self.talk.quiet {
            return;
        }
        let Settings { width, height, .. } = settings;
        remark!("{}: {} triangles, {width} × {height} pixels, {}", scene.name, scene.triangles.len(), self.name());
        note.into_iter().for_each(|note| remark!("note: {note}"));
        let shown = if self.talk.verbose { scene.notes.len() } else { scene.notes.len().min(NOTES) };
        scene.notes[..shown].iter().for_each(|note| remark!("note: {note}"));
        if shown < scene.notes.len() {
            remark!("note: {} more notes on the file; -v shows them", scene.notes.len() - shown);
        }
        if self.talk.verbose {
            remark!("note: {}", self.device.pipeline_cache_note());
        }
    }

    /// What the picture was made with, for the file that holds it. Nothing in it depends on when, or by what name it is written.
    pub fn made_with(
        &self,
        args: &RenderArgs,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Vec<(&'static str, String)> {
        let cache = &settings.cache;
        let asked = args.scene.camera.as_deref().unwrap_or("default");
        vec![
            ("scene", scene.name.clone()),
            ("scene hash", format!("{:016x}", scene.fingerprint())),
            ("triangles", scene.triangles.len().to_string()),
            ("camera", if camera.name.is_empty() { asked.to_owned() } else { camera.name.clone() }),
            ("lens", format!("{:?}", camera.lens)),
            ("size", format!("{}x{}", settings.width, settings.height)),
            ("device", self.device.physical.name.clone()),
            ("bounces", if settings.bounces == ALL_BOUNCES { "all".into() } else { settings.bounces.to_string() }),
            ("seed", cache.seed.to_string()),
            ("cache", format!("{cache:?}")),
            ("lights", format!("{:?}", settings.lights)),
            ("background", args.scene.background.clone().unwrap_or_else(|| "of the scene".into())),
        ]
    }

    /// With `-v`, says what runs, and what does not and why.
    pub fn plan(&self, plan: &Plan) {
        if !self.talk.verbose {
            return;
        }
        remark!("plan: {}", plan.run().join(", "));
        for left in plan.left_out() {
            remark!("left out: {} ({})", left.pass, left.why);
        }
    }

    /// The device, with its driver under `-v`.
    fn name(&self) -> String {
        let physical = &self.device.physical;
        if self.talk.verbose {
            format!("{} ({})", physical.name, physical.driver.trim())
        } else {
            physical.name.clone()
        }
    }

    /// Warns of what went otherwise than planned, and of values that no picture should have.
    pub fn check(&self, rendered: &Rendered) {
        rendered.warnings.iter().filter(|_| !self.talk.quiet).for_each(|warning| remark!("warning: {warning}"));
        if rendered.cache.unfinished && !self.talk.quiet {
            let records = rendered.cache.records + rendered.cache.reused;
            remark!(
                "note: stopped before all records were placed: the picture is made of {records}; --cache is left as it was"
            );
        }
        let picture = &rendered.picture;
        for (channel, count) in picture.non_finite() {
            remark!("warning: {count} pixels of {channel} are NaN or infinite");
        }
    }

    /// Takes over the renderer's stages.
    pub fn rendered(&mut self, rendered: &Rendered, writing: Duration) {
        for (name, span) in &rendered.stages {
            match self.stages.iter_mut().find(|(known, _)| known == name) {
                Some((_, all_ms)) => *all_ms += length(span),
                None => self.stages.push((name.clone(), length(span))),
            }
        }
        self.stage("write image", writing);
    }

    /// Adds a value to the statistics.
    pub fn extra(&mut self, key: &'static str, value: serde_json::Value) {
        self.extra.push((key, value));
    }

    /// Measures what the device does at most.
    pub fn measure(&mut self) -> Result<()> {
        let begun = Instant::now();
        self.rates = Some(Rates::measure(&self.device)?);
        self.stage("measure device", begun.elapsed());
        Ok(())
    }

    /// Prints the table and writes the files.
    pub fn finish(
        &self,
        args: &RenderArgs,
        scene: &Scene,
        rendered: &Rendered,
        made_with: &[(&'static str, String)],
    ) -> Result<()> {
        let profile = self.profile(rendered);
        let messages = self.device.instance.validation_messages();
        if let Some(path) = &args.stats {
            let mut stats = self.stats(scene, rendered, &profile, messages);
            let command: Vec<_> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
            stats.extra.insert("command".into(), json!(command));
            let made_with: serde_json::Map<_, _> =
                made_with.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
            stats.extra.insert("made_with".into(), made_with.into());
            stats.write(path)?;
        }
        if let Some(path) = &args.trace {
            self.trace(rendered).write(path)?;
        }
        if !self.talk.quiet {
            say!("\n{}", profile.to_string().trim_end());
            let wrote = args.output.as_ref().map(|path| format!(", wrote {}", path.display())).unwrap_or_default();
            let reused = match rendered.cache.reused {
                0 => String::new(),
                reused => format!(", {reused} reused"),
            };
            say!(
                "{} records in {} rounds{reused}, {} MB on the device{wrote}",
                rendered.cache.records,
                rendered.cache.rounds,
                rendered.memory.peak >> 20
            );
            if let Some(bounced) = &rendered.bounced {
                say!("{}", in_words(bounced));
            }
            if let Some(work) = rendered.cache.work {
                let pixels = f64::from(rendered.picture.width) * f64::from(rendered.picture.height);
                say!(
                    "{:.1} fragments of splats a pixel, {:.0} % of them without weight; {} triangles × views a record",
                    work.fragments as f64 / pixels,
                    100.0 * (1.0 - work.weighted_fragments as f64 / work.fragments.max(1) as f64),
                    work.triangle_views / rendered.cache.records.max(1)
                );
            }
            if self.validates {
                say!("{messages} validation messages");
            }
        }
        Ok(())
    }

    fn profile(&self, rendered: &Rendered) -> Profile {
        let mut profile = Profile {
            gpu_ms: rendered.submissions.iter().map(length).sum(),
            run_ms: rendered.stages.iter().filter(|(name, _)| name == "run passes").map(|(_, span)| length(span)).sum(),
            wall_ms: self.started.elapsed().as_secs_f64() * 1e3,
            cpu_stages: self.stages.clone(),
            ..Profile::default()
        };
        for run in &rendered.passes {
            let pass = profile.pass(run.name);
            pass.gpu_ms.extend(run.gpu.as_ref().map(length));
            pass.cpu_ms += length(&run.cpu);
        }
        profile.limits = self.rates.as_ref().map(|rates| limits(rendered, &profile, rates)).unwrap_or_default();
        profile
    }

    fn stats(&self, scene: &Scene, rendered: &Rendered, profile: &Profile, messages: u32) -> Stats {
        let mut stats = Stats::new();
        stats.device = self.device.physical.name.clone();
        stats.driver = self.device.physical.driver.trim().to_owned();
        stats.scene = SceneStats {
            triangles: scene.triangles.len() as u64,
            vertices: scene.positions.len() as u64,
            lights: scene.lights.len() as u64 + u64::from(rendered.plan.runs(Part::Emission)),
            materials: scene.parts.len() as u64,
        };
        stats.plan = PlanStats {
            run: rendered.plan.run().iter().map(|s| (*s).to_owned()).collect(),
            left_out: rendered
                .plan
                .left_out()
                .iter()
                .map(|l| LeftOut { pass: l.pass.to_owned(), why: l.why.clone() })
                .collect(),
        };
        stats.records = rendered.cache.records;
        stats.rounds = rendered.cache.rounds;
        stats.memory = Memory {
            gpu_bytes: rendered.memory.peak,
            by_use: rendered.memory.by_use.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect(),
        };
        if !rendered.warnings.is_empty() {
            stats.extra.insert("warnings".into(), json!(rendered.warnings));
        }
        if let Some(bounced) = &rendered.bounced {
            stats.extra.insert("bounces".into(), in_numbers(bounced));
        }
        if let Some(work) = rendered.cache.work {
            let work = json!({"triangle_views": work.triangle_views, "texels": work.texels,
                "fragments": work.fragments, "weighted_fragments": work.weighted_fragments});
            stats.extra.insert("work".into(), work);
        }
        stats.extra.insert("unfinished".into(), json!(rendered.cache.unfinished));
        stats.extra.insert("reused".into(), json!(rendered.cache.reused));
        stats.extra.extend(self.extra.iter().map(|(key, value)| ((*key).to_owned(), value.clone())));
        stats.validation_messages = u64::from(messages);
        stats.set_times(profile);
        stats
    }

    /// GPU passes on one track, CPU stages and the recording of passes on two others.
    fn trace(&self, rendered: &Rendered) -> Trace {
        let mut trace = Trace::new();
        let gpu = trace.track("GPU queue");
        let recording = trace.track("CPU recording");
        let stages = trace.track("CPU stages");
        for pass in &rendered.passes {
            if let Some(span) = &pass.gpu {
                trace.span(gpu, pass.name, span.begin_ms * 1e3, length(span) * 1e3);
            }
            trace.span(recording, pass.name, pass.cpu.begin_ms * 1e3, length(&pass.cpu) * 1e3);
        }
        for (name, span) in &rendered.stages {
            trace.span(stages, name, span.begin_ms * 1e3, length(span) * 1e3);
        }
        trace
    }
}

/// What the passes of the cache did, beside the device's rates.
fn limits(rendered: &Rendered, profile: &Profile, rates: &Rates) -> Vec<Share> {
    let Some(work) = rendered.cache.work else { return Vec::new() };
    let compute = rates.compute.unwrap_or_default();
    let integrated = if rendered.plan.compute() { compute.integrated_texels } else { rates.integrated_texels };
    let rows = [
        ("capture", "triangles × views", work.triangle_views, rates.triangle_views),
        ("capture_compute", "triangles × views", work.triangle_views, compute.triangle_views),
        ("capture_compute", "texels", work.texels, compute.texels),
        ("integrate", "texels", work.texels, integrated),
        ("splat", "fragments", work.fragments, rates.blended_fragments),
    ];
    let time = |name: &str| profile.passes.iter().find(|pass| pass.name == name).map(PassTimes::total_ms);
    let share = |(pass, unit, count, limit)| Share::new(pass, unit, count, time(pass)?, limit);
    rows.into_iter().filter_map(share).collect()
}

fn length(span: &Span) -> f64 {
    span.end_ms - span.begin_ms
}

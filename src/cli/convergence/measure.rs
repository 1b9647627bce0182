//! Runs one point, several times over, and says what it cost.

use super::ConvergenceArgs;
use super::task::{DIRECT_SPP, PATH_SEED, Task};
use super::truth::Truth;
use crate::cli::choices::CaptureArg;
use anyhow::{Result, bail};
use hemicube::image::metrics::{measure, measure_flip};
use hemicube::image::{Kind, Layer, Picture};
use hemicube::reference::{Meter, Progressive, Settings as PathSettings, Stop, Tracer, View, process_time, ward};
use hemicube::renderer::{RenderError, Rendered, render};
use hemicube::report::convergence::{Point, median_and_spread, peak_memory, reset_peak_memory, short};
use hemicube::scene::{Camera, Scene};
use hemicube::vk::{Device, Span};
use serde_json::{Map, Value};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;

/// A run that takes longer than this, in seconds, is not repeated.
const LONG: f64 = 60.0;

/// What all points of a run share.
pub struct Bench<'a> {
    pub args: &'a ConvergenceArgs,
    pub name: String,
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub size: (u32, u32),
    pub tracer: &'a Tracer<'a>,
    /// Processor seconds that making the scene ready for rays took.
    pub tracer_cpu_s: f64,
    pub truth: &'a Truth,
    /// The frame without indirect light, whose time is taken off; measured once.
    pub direct: Option<Seconds>,
}

/// Captures in compute do not fit the scene or the device; render passes would have been timed in their place.
#[derive(Debug, thiserror::Error)]
#[error("captures in compute do not fit this scene or device")]
pub struct DoesNotFit;

/// Times of one run, seconds.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seconds {
    setup_cpu: f64,
    cpu: f64,
    wall: f64,
    /// Indirect light alone.
    indirect_cpu: f64,
    indirect_wall: f64,
    gpu_ms: f64,
}

/// The runs of a point and the last one's result.
struct Runs {
    times: Vec<Seconds>,
    irradiance: [Vec<f32>; 3],
    records: u64,
}

impl Bench<'_> {
    /// A point's row but for its figures: what makes its key.
    pub fn empty_point(&self, task: &Task, device: &str) -> Point {
        let mut point = Point::new(&self.name, self.size, task.method(), &task.settings(self.size));
        point.set("threads", std::thread::available_parallelism().map_or(1, usize::from));
        if matches!(task, Task::Splatting { .. }) {
            point.set("device", device);
        } else {
            point.set("device", "CPU");
        }
        point.set("reference", &self.truth.name);
        point.set("version", concat!("hemicube ", env!("CARGO_PKG_VERSION")));
        point
    }

    /// Measures a point; the picture of its irradiance goes with it.
    pub fn measure(&mut self, task: &Task, mut point: Point) -> Result<(Point, Picture)> {
        reset_peak_memory();
        let runs = match *task {
            Task::Splatting { .. } => self.splat(task, &mut point)?,
            Task::Ward { .. } => self.ward(task),
            Task::Path { spp } => self.path(spp),
        };
        peak_memory().into_iter().for_each(|bytes| point.set("host_bytes", bytes));
        point.set("records", runs.records);
        let on_cpu = point.text("device") == "CPU" || point.text("gpu_is_cpu") == "1";
        point.row.remove("gpu_is_cpu");
        times(&mut point, &runs.times, on_cpu);
        self.errors(&mut point, &runs.irradiance);
        let mut picture = Picture::new(self.size.0, self.size.1);
        for (channel, values) in ["R", "G", "B"].into_iter().zip(runs.irradiance) {
            picture.channels.insert(format!("irradiance.{channel}"), values);
        }
        Ok((point, picture))
    }

    fn errors(&self, point: &mut Point, irradiance: &[Vec<f32>; 3]) {
        let test = Layer { kind: Kind::Colour, channels: irradiance.iter().map(Vec::as_slice).collect() };
        let truth = self.truth.layer();
        let (width, mask) = (self.size.0 as usize, Some(&self.truth.mask[..]));
        let mut metrics = measure(&test, &truth, width, mask);
        if self.args.flip {
            metrics.flip = measure_flip(&test, &truth, width, mask);
        }
        point.set_metrics(&metrics);
    }

    /// Repeats until there are enough runs, or one took too long to do again.
    fn repeat(&self, mut run: impl FnMut() -> Result<Seconds>) -> Result<Vec<Seconds>> {
        let mut times = Vec::new();
        loop {
            let begun = Instant::now();
            times.push(run()?);
            if times.len() as u32 >= self.args.repeats() || begun.elapsed().as_secs_f64() > LONG {
                return Ok(times);
            }
        }
    }

    fn splat(&mut self, task: &Task, point: &mut Point) -> Result<Runs> {
        // A device of its own for each point, so that its peak of memory is the point's.
        let device = self.args.device.open()?;
        let settings = task.renderer(self.size);
        settings.check(&device)?;
        let direct = match self.direct {
            Some(direct) => direct,
            None => self.direct_frame(&device, task)?,
        };
        self.direct = Some(direct);
        let mut last = None;
        let times = self.repeat(|| {
            let unfit = |error: anyhow::Error| match error.downcast_ref() {
                Some(RenderError::Slices(_)) => DoesNotFit.into(),
                _ => error,
            };
            let (rendered, mut seconds) = self.frame(&device, &settings).map_err(unfit)?;
            seconds.indirect_cpu = seconds.cpu - direct.cpu;
            seconds.indirect_wall = seconds.wall - direct.wall;
            last = Some(rendered);
            Ok(seconds)
        })?;
        let Some(rendered) = last else { bail!("no run") };
        let in_compute =
            |capture| matches!(capture, CaptureArg::Compute | CaptureArg::ComputeHemisphere | CaptureArg::Slices);
        let wants_compute = matches!(task, Task::Splatting { capture, .. } if in_compute(*capture));
        let ran_compute = rendered.passes.iter().any(|pass| pass.name == "capture_compute");
        if wants_compute && !ran_compute && rendered.cache.records > 0 {
            bail!(DoesNotFit);
        }
        point.set("passes_ms", passes(&rendered));
        point.set("device_bytes", device.memory().peak);
        point.row.insert("gpu_is_cpu".into(), u8::from(device.is_cpu()).to_string());
        let rgb = rendered.picture.rgb("irradiance").map(|rgb| rgb.map(<[f32]>::to_vec));
        let Some(irradiance) = rgb else { bail!("the renderer gave no irradiance") };
        Ok(Runs { times, irradiance, records: rendered.cache.records })
    }

    /// The same frame without indirect light; a first run warms the driver up.
    fn direct_frame(&self, device: &Arc<Device>, task: &Task) -> Result<Seconds> {
        let mut settings = task.renderer(self.size);
        settings.bounces = 0;
        self.frame(device, &settings)?;
        let runs: Vec<Seconds> =
            (0..self.args.repeats()).map(|_| Ok(self.frame(device, &settings)?.1)).collect::<Result<_>>()?;
        // A sky is captured by the cache without any bounce: nothing to take off then.
        let sky = !self.scene.background.is_black();
        let median = |pick: fn(&Seconds) -> f64| median_and_spread(&runs.iter().map(pick).collect::<Vec<_>>()).0;
        Ok(if sky {
            Seconds::default()
        } else {
            Seconds { cpu: median(|s| s.cpu), wall: median(|s| s.wall), ..Seconds::default() }
        })
    }

    fn frame(&self, device: &Arc<Device>, settings: &hemicube::renderer::Settings) -> Result<(Rendered, Seconds)> {
        let cpu = || process_time().map_or(0.0, |time| time.as_secs_f64());
        let (begun, cpu_begun) = (Instant::now(), cpu());
        let mut built = None;
        let rendered = render(device, self.scene, self.camera, settings, &mut |_, _, _| {
            built.get_or_insert_with(|| (begun.elapsed().as_secs_f64(), cpu()));
        })?;
        let (wall, cpu_end) = (begun.elapsed().as_secs_f64(), cpu());
        let (setup_wall, cpu_built) = built.unwrap_or((0.0, cpu_begun));
        let seconds = Seconds {
            setup_cpu: cpu_built - cpu_begun,
            cpu: cpu_end - cpu_built,
            wall: wall - setup_wall,
            gpu_ms: rendered.submissions.iter().map(length).sum(),
            ..Seconds::default()
        };
        Ok((rendered, seconds))
    }

    fn ward(&self, task: &Task) -> Runs {
        let settings = task.ward();
        let mut last = None;
        let times = self.repeat(|| {
            let result = ward(self.tracer, self.view(), &settings, DIRECT_SPP, |_, _| ());
            let both = |pick: fn(&hemicube::reference::Cost) -> std::time::Duration| {
                (pick(&result.fill) + pick(&result.interpolate)).as_secs_f64()
            };
            let (cpu, wall) = (both(|cost| cost.cpu), both(|cost| cost.wall));
            let seconds = Seconds {
                setup_cpu: self.tracer_cpu_s,
                cpu: cpu + result.direct.cpu.as_secs_f64(),
                wall: wall + result.direct.wall.as_secs_f64(),
                indirect_cpu: cpu,
                indirect_wall: wall,
                ..Seconds::default()
            };
            last = Some(result);
            Ok(seconds)
        });
        let (times, last) = (times.unwrap_or_default(), last);
        let records = last.as_ref().map_or(0, |result| result.cache.records.len() as u64);
        let irradiance = last.map_or_else(Default::default, |result| rgb(&result.picture));
        Runs { times, irradiance, records }
    }

    fn path(&self, spp: u32) -> Runs {
        let direct = self.paths(spp, 0).1;
        let mut last = None;
        let times = self.repeat(|| {
            let (picture, mut seconds) = self.paths(spp, 1);
            seconds.indirect_cpu = seconds.cpu - direct.cpu;
            seconds.indirect_wall = seconds.wall - direct.wall;
            last = Some(picture);
            Ok(seconds)
        });
        let irradiance = last.as_ref().map_or_else(Default::default, rgb);
        Runs { times: times.unwrap_or_default(), irradiance, records: 0 }
    }

    fn paths(&self, spp: u32, bounces: u32) -> (Picture, Seconds) {
        let settings = PathSettings { bounces, seed: PATH_SEED, batch: spp.min(1024) };
        let mut run = Progressive::new(self.tracer, self.view(), settings);
        let meter = Meter::start(self.tracer);
        let Ok(_) = run.run(&Stop { spp: Some(spp), ..Stop::default() }, |_| Ok::<(), Infallible>(()));
        let cost = meter.cost(self.tracer);
        let seconds = Seconds {
            setup_cpu: self.tracer_cpu_s,
            cpu: cost.cpu.as_secs_f64(),
            wall: cost.wall.as_secs_f64(),
            ..Seconds::default()
        };
        (run.picture(), seconds)
    }

    fn view(&self) -> View {
        View::new(self.camera, self.size.0, self.size.1)
    }
}

/// Sets the columns of the times: medians, and longest less shortest.
fn times(point: &mut Point, runs: &[Seconds], on_cpu: bool) {
    let mut set = |column: &'static str, spread: Option<&'static str>, pick: fn(&Seconds) -> f64| {
        let (median, range) = median_and_spread(&runs.iter().map(pick).collect::<Vec<_>>());
        point.set_number(column, median);
        spread.into_iter().for_each(|spread| point.set_number(spread, range));
    };
    set("setup_cpu_s", None, |s| s.setup_cpu);
    set("cpu_s", None, |s| s.cpu);
    set("wall_s", Some("wall_spread_s"), |s| s.wall);
    set("indirect_wall_s", None, |s| s.indirect_wall);
    if on_cpu {
        // Work on a GPU takes no processor time: such a point has no place in a chart of it.
        set("indirect_cpu_s", Some("indirect_cpu_spread_s"), |s| s.indirect_cpu);
    }
    if runs.iter().any(|s| s.gpu_ms > 0.0) {
        set("gpu_ms", Some("gpu_spread_ms"), |s| s.gpu_ms);
    }
    point.set("repeats", runs.len());
}

/// Milliseconds of each pass on the device, all its runs together.
fn passes(rendered: &Rendered) -> Value {
    let mut sums: Map<String, Value> = Map::new();
    for pass in &rendered.passes {
        let ms = pass.gpu.as_ref().map_or(0.0, length);
        let sum = sums.get(pass.name).and_then(Value::as_f64).unwrap_or(0.0) + ms;
        sums.insert(pass.name.into(), sum.into());
    }
    sums.values_mut().for_each(|ms| *ms = ms.as_f64().map_or(0.0, |ms| short(ms).parse().unwrap_or(ms)).into());
    Value::Object(sums)
}

fn length(span: &Span) -> f64 {
    span.end_ms - span.begin_ms
}

fn rgb(picture: &Picture) -> [Vec<f32>; 3] {
    picture.rgb("irradiance").map(|rgb| rgb.map(<[f32]>::to_vec)).unwrap_or_default()
}

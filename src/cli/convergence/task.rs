//! What is measured: methods times settings.

use super::{ConvergenceArgs, MethodArg};
use crate::cli::choices::{CaptureArg, CaptureOptions, GradientsArg, name_of};
use hemicube::passes::integrate::Gradients;
use hemicube::passes::resolve::Plane;
use hemicube::passes::splat::Weight;
use hemicube::reference::ward;
use hemicube::renderer::Settings;
use serde_json::{Map, Value, json};

/// Paths a pixel for direct light beside an irradiance cache; its time is taken off again.
pub const DIRECT_SPP: u32 = 4;

/// Seed of the paths that are measured: not the reference's, by whose own paths they would show no error.
pub const PATH_SEED: u64 = 1;

/// One point to be measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// Irradiance splatting on the device.
    Splatting {
        /// Ward's a.
        accuracy: f64,
        /// How records look at the scene.
        capture: CaptureArg,
        /// Texels a side.
        size: u32,
        /// Gradients that records are extrapolated with.
        gradients: GradientsArg,
    },
    /// Ward's cache on the CPU.
    Ward {
        /// Ward's a.
        accuracy: f64,
        /// Rays of a record.
        rays: u32,
    },
    /// Path tracing on the CPU.
    Path {
        /// Paths a pixel.
        spp: u32,
    },
}

impl Task {
    /// Name in the CSV.
    pub fn method(&self) -> &'static str {
        match self {
            Self::Splatting { .. } => "splatting",
            Self::Ward { .. } => "ward",
            Self::Path { .. } => "path",
        }
    }

    /// Every setting that the result depends on.
    pub fn settings(&self, size: (u32, u32)) -> Map<String, Value> {
        let value = match *self {
            Self::Splatting { .. } => splatting_settings(self, size),
            Self::Ward { .. } => {
                let s = self.ward();
                json!({
                    "accuracy": s.accuracy, "rays": s.rays, "gradients": "both", "weight": "ward",
                    "min_radius": s.min_radius, "max_radius": s.max_radius, "gradient_limit": s.gradient_limit,
                    "neighbour_clamping": s.neighbour_clamping, "seed": s.seed, "direct_spp": DIRECT_SPP,
                })
            }
            Self::Path { spp } => json!({"spp": spp, "seed": PATH_SEED}),
        };
        value.as_object().cloned().unwrap_or_default()
    }

    /// Work that a point takes, in units that mean something within a method: for the time that is left.
    pub fn work(&self) -> f64 {
        match *self {
            // As fitted to the Cornell box: records grow with 1/a² until the smallest radius holds them back.
            Self::Splatting { accuracy, size, .. } => {
                (1.0 + 0.04 * accuracy.powi(-2)) * (1.0 + (f64::from(size) / 32.0).powi(2))
            }
            Self::Ward { accuracy, rays } => f64::from(rays) * (1.0 + 0.1 * accuracy.powi(-2)),
            Self::Path { spp } => f64::from(spp),
        }
    }

    /// Settings of the renderer for a splatting point.
    pub fn renderer(&self, (width, height): (u32, u32)) -> Settings {
        let mut settings = Settings { width, height, planes: vec![Plane::Irradiance], ..Settings::default() };
        if let Self::Splatting { accuracy, capture, size, gradients } = *self {
            settings.cache.accuracy = accuracy as f32;
            settings.cache.capture_size = size;
            settings.cache.capture = capture.mode(&CaptureOptions::default());
            let [rotation, translation] = gradients.has();
            settings.cache.gradients = Gradients { rotation, translation };
            if gradients != GradientsArg::Both {
                // Records disagree everywhere: more of them would be no answer.
                settings.cache.contrast = 0.0;
            }
        }
        settings
    }

    /// Settings of the cache for a point of Ward's.
    pub fn ward(&self) -> ward::Settings {
        match *self {
            Self::Ward { accuracy, rays } => ward::Settings { accuracy, rays, ..ward::Settings::default() },
            _ => ward::Settings::default(),
        }
    }
}

fn splatting_settings(task: &Task, size: (u32, u32)) -> Value {
    let Task::Splatting { accuracy, capture, size: texels, gradients } = *task else { return Value::Null };
    let settings = task.renderer(size);
    let (cache, lights) = (settings.cache, settings.lights);
    // Through text: the single-precision 0.3 is not the double's.
    let plain = |value: f32| value.to_string().parse::<f64>().unwrap_or(f64::from(value));
    json!({
        "accuracy": accuracy, "capture": name_of(capture), "capture_size": texels, "gradients": name_of(gradients),
        "weight": match cache.weight { Weight::Bounded => "bounded", Weight::Ward => "ward" },
        "min_radius": plain(cache.min_radius), "max_radius": plain(cache.max_radius), "covered": plain(cache.covered),
        "normal_limit": plain(cache.normal_limit), "contrast": plain(cache.contrast), "seed": cache.seed, "area_samples": lights.area_samples,
        "sky_samples": lights.sky_samples, "shadow_size": lights.shadow_size, "surface_cells": settings.surface_cells,
    })
}

/// All points that the arguments ask for, each method's by rising work; `on_cpu`: the device is a CPU.
pub fn tasks(args: &ConvergenceArgs, on_cpu: bool) -> Vec<Task> {
    let mut tasks = Vec::new();
    for method in &args.methods {
        let mut own: Vec<Task> = match method {
            MethodArg::Splatting => splatting(args, on_cpu),
            MethodArg::Ward => ward_tasks(args),
            MethodArg::Path => {
                let usual: &[u32] = if args.quick { &[4, 16, 64] } else { &[4, 16, 64, 256, 1024] };
                or(&args.lists.spp, usual).into_iter().map(|spp| Task::Path { spp }).collect()
            }
        };
        own.sort_by(|a, b| a.work().total_cmp(&b.work()));
        own.dedup();
        tasks.extend(own);
    }
    tasks
}

/// The settings in use, and each of the others by itself in place of one of them; or what the arguments say, all with all.
fn splatting(args: &ConvergenceArgs, on_cpu: bool) -> Vec<Task> {
    let usual: &[f64] = if args.quick { &[0.6, 0.3, 0.15] } else { &[0.6, 0.4, 0.3, 0.2, 0.12] };
    let (own, other) =
        if on_cpu { (CaptureArg::Compute, CaptureArg::Hemicube) } else { (CaptureArg::Hemicube, CaptureArg::Compute) };
    let base = (own, 32, GradientsArg::Both);
    let chosen =
        !args.lists.capture.is_empty() || !args.lists.capture_size.is_empty() || !args.lists.gradients.is_empty();
    let variants: Vec<_> = if chosen {
        let (captures, sizes, gradients) = (
            or(&args.lists.capture, &[base.0]),
            or(&args.lists.capture_size, &[base.1]),
            or(&args.lists.gradients, &[base.2]),
        );
        let with = |c: CaptureArg| sizes.iter().flat_map(move |&s| [(c, s)]).collect::<Vec<_>>();
        let pairs: Vec<_> = captures.into_iter().flat_map(with).collect();
        pairs.into_iter().flat_map(|(c, s)| gradients.iter().map(move |&g| (c, s, g))).collect()
    } else if args.quick {
        vec![base, (own, 32, GradientsArg::None)]
    } else {
        let others = [other, CaptureArg::Plane, CaptureArg::Hemisphere].map(|capture| (capture, 32, base.2));
        let sizes = [16, 64].map(|size| (own, size, base.2));
        [&[base], &sizes[..], &others, &[(own, 32, GradientsArg::None)]].concat()
    };
    let sweep = |(capture, size, gradients)| {
        let point = move |accuracy| Task::Splatting { accuracy, capture, size, gradients };
        or(&args.lists.accuracy, usual).into_iter().map(point).collect::<Vec<_>>()
    };
    variants.into_iter().flat_map(sweep).collect()
}

fn ward_tasks(args: &ConvergenceArgs) -> Vec<Task> {
    let usual: &[f64] = if args.quick { &[0.5, 0.25] } else { &[0.5, 0.3, 0.2, 0.15] };
    let rays = or(&args.lists.rays, if args.quick { &[256] } else { &[256, 1024] });
    let with = |accuracy: f64| rays.iter().map(move |&rays| Task::Ward { accuracy, rays }).collect::<Vec<_>>();
    or(&args.lists.accuracy, usual).into_iter().flat_map(with).collect()
}

fn or<T: Clone>(given: &[T], usual: &[T]) -> Vec<T> {
    if given.is_empty() { usual.to_vec() } else { given.to_vec() }
}

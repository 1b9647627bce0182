//! Every kind of capture on the device, through the real passes, against closed forms.

mod closed_forms;
mod distances;
mod fallbacks;
mod harmonics;
mod masks;
mod outlines;
mod sides;
mod workgroups;

use crate::common::gpu;
use crate::common::probes::{measure_on, settings};
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE};
use hemicube::methods::probes::{Place, Probe};
use hemicube::scene::Scene;

const PLANE: CaptureMode = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: true };

const BARE_PLANE: CaptureMode = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: false };

const WHOLE: [CaptureMode; 5] =
    [CaptureMode::Hemicube, CaptureMode::Compute, PLANE, CaptureMode::Hemisphere, CaptureMode::ComputeHemisphere];

fn measure(scene: &Scene, capture: CaptureMode, capture_size: u32, places: &[Place]) -> Vec<Probe> {
    measure_on(&gpu(), scene, &settings(capture, capture_size), places)
}

fn mean(probes: &[Probe], of: impl Fn(&Probe) -> f32) -> f64 {
    probes.iter().map(|p| f64::from(of(p))).sum::<f64>() / probes.len() as f64
}

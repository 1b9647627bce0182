//! Every kind of capture on the device, through the real passes, against closed forms.

#![allow(clippy::unwrap_used)] // the helpers belong to tests, which the lint cannot see

mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod fallbacks;
mod masks;
mod workgroups;

use common::gpu;
use glam::Vec3;
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE};
use hemicube::methods::probes::{Place, Probe, ProbeSettings, Probes};
use hemicube::passes::integrate::Gradients;
use hemicube::renderer::Settings;
use hemicube::scene::Scene;
use hemicube::vk::Device;
use hemicube::vk::pass::Recorder;
use std::sync::Arc;

const PLANE: CaptureMode = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: true };

const BARE_PLANE: CaptureMode = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: false };

const WHOLE: [CaptureMode; 5] =
    [CaptureMode::Hemicube, CaptureMode::Compute, PLANE, CaptureMode::Hemisphere, CaptureMode::ComputeHemisphere];

fn measure(scene: &Scene, capture: CaptureMode, capture_size: u32, places: &[Place]) -> Vec<Probe> {
    measure_on(&gpu(), scene, capture, capture_size, places)
}

fn measure_on(
    device: &Arc<Device>,
    scene: &Scene,
    capture: CaptureMode,
    capture_size: u32,
    places: &[Place],
) -> Vec<Probe> {
    let before = device.instance.validation_messages();
    let gradients = Gradients { rotation: true, translation: true };
    let lights = Settings::default().lights;
    let settings = ProbeSettings { capture, capture_size, gradients, lights, surface_cells: 1 << 15 };
    let mut recorder = Recorder::new(device);
    let probes = Probes::new(device, &mut recorder, scene, &settings).unwrap();
    let measured = probes.measure(&mut recorder, places, |_| {}).unwrap();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    measured
}

/// Places at one point of a floor, turned evenly.
fn turned(position: Vec3, count: u32) -> Vec<Place> {
    let turn = |i: u32| i as f32 * 2.399_963; // the golden angle
    (0..count).map(|i| Place { position, normal: Vec3::Y, geometric: Vec3::Y, turn: turn(i) }).collect()
}

fn mean(probes: &[Probe], of: impl Fn(&Probe) -> f32) -> f64 {
    probes.iter().map(|p| f64::from(of(p))).sum::<f64>() / probes.len() as f64
}

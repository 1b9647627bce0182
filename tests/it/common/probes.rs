//! Irradiance at places, on a device of one's choice.

use glam::Vec3;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::{Place, Probe, ProbeSettings, Probes};
use hemicube::passes::integrate::Gradients;
use hemicube::renderer::Settings;
use hemicube::scene::Scene;
use hemicube::vk::Device;
use hemicube::vk::pass::Recorder;
use std::sync::Arc;

/// Captures of `capture_size` texels a side with both gradients, of surfaces of some 32,000 cells.
pub fn settings(capture: CaptureMode, capture_size: u32) -> ProbeSettings {
    let gradients = Gradients { rotation: true, translation: true };
    ProbeSettings { capture, capture_size, gradients, lights: Settings::default().lights, surface_cells: 1 << 15 }
}

/// Measures at all places; a validation message fails the test.
pub fn measure_on(device: &Arc<Device>, scene: &Scene, settings: &ProbeSettings, places: &[Place]) -> Vec<Probe> {
    let before = device.instance.validation_messages();
    let mut recorder = Recorder::new(device);
    let probes = Probes::new(device, &mut recorder, scene, settings).unwrap();
    let measured = probes.measure(&mut recorder, places, |_| {}).unwrap();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    measured
}

/// Places at one point of a floor, turned evenly.
pub fn turned(position: Vec3, count: u32) -> Vec<Place> {
    let turn = |i: u32| i as f32 * 2.399_963; // the golden angle
    (0..count).map(|i| Place { position, normal: Vec3::Y, geometric: Vec3::Y, turn: turn(i) }).collect()
}

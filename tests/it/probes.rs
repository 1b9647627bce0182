//! Irradiance at given places on the device: what bakes and the stability suite stand on.

use crate::common::build::{Builder, diffuse};
use crate::common::gpu;
use crate::common::probes::{measure_on, settings};
use glam::{Vec3, vec3};
use hemicube::math::form_factor;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::{Place, Probe, ProbeSettings};
use hemicube::scene::{Background, Light, Scene};

fn measure(scene: &Scene, capture: CaptureMode, places: &[Place]) -> Vec<Probe> {
    let device = gpu();
    let settings = ProbeSettings { surface_cells: 1 << 16, ..settings(capture, 64) };
    measure_on(&device, scene, &settings, places)
}

fn on_the_floor(position: Vec3, turn: f32) -> Place {
    Place { position, normal: Vec3::Y, geometric: Vec3::Y, turn }
}

/// A wall of height 1 before the floor, lit at right angles by a sun: E = ½πL(1 − x/√(x² + 1)), πL = ρE₀.
#[test]
fn places_before_a_lit_wall() {
    let (rho, irradiance) = (0.5, 3.0);
    let mut b = Builder::default();
    let grey = b.material(diffuse(rho));
    b.quad(grey, vec3(0.0, 0.0, 200.0), Vec3::NEG_Z * 400.0, Vec3::Y);
    b.light(Light::Directional { direction: Vec3::NEG_X, irradiance: irradiance * vec3(1.0, 2.0, 0.5) });
    let scene = b.build();
    for capture in [CaptureMode::Compute, CaptureMode::Hemicube] {
        // More than one batch.
        let places: Vec<Place> = (0..700).map(|i| on_the_floor(vec3(0.5, 0.0, 0.0), i as f32)).collect();
        let probes = measure(&scene, capture, &places);
        let n = probes.len() as f64;
        let mean = |of: &dyn Fn(&Probe) -> f32| probes.iter().map(|p| f64::from(of(p))).sum::<f64>() / n;
        let radiance = f64::from(rho * irradiance) / std::f64::consts::PI;
        let wall = |x: f64| radiance * form_factor::wall(x, 1.0);
        let slope = (wall(0.501) - wall(0.499)) / 0.002;
        for (c, factor) in [1.0, 2.0, 0.5].into_iter().enumerate() {
            let e = mean(&|p| p.reflected.value[c]) / factor / wall(0.5);
            let s = mean(&|p| p.reflected.translation[c].x) / factor / slope;
            let across = mean(&|p| p.reflected.translation[c].z) / factor / slope;
            eprintln!("{capture:?}, channel {c}: E {e:.4} of the closed form, dE/dx {s:.4}, dE/dz {across:.4}");
            assert!((e - 1.0).abs() < 0.005 && (s - 1.0).abs() < 0.03 && across.abs() < 0.005);
        }
        assert!(probes.iter().all(|p| p.sky.is_none()));
    }
}

#[test]
fn a_sky_is_measured_by_itself() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, -1.0, 1.0);
    b.background(Background::Constant(vec3(1.0, 2.0, 3.0)));
    let probes = measure(&b.build(), CaptureMode::Auto, &[on_the_floor(Vec3::ZERO, 0.3)]);
    let sky = probes[0].sky.unwrap();
    let pi = std::f32::consts::PI;
    assert!((sky.value - pi * vec3(1.0, 2.0, 3.0)).length() < 1e-4, "{sky:?}");
    assert_eq!(probes[0].reflected.value, Vec3::ZERO);
    assert_eq!(probes[0].inverse_distance, 0.0);
}

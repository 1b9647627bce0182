//! The cells that hold the surfaces' lit radiance: beside detail they are finer, and each sees its share of the sky.

use crate::common::build::diffuse;
use crate::common::closed_forms::polygon;
use crate::common::{Builder, TINT, against, assert_close, gpu, look, picture, small, tinted};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::methods::probes::{ProbeSettings, Probes};
use hemicube::renderer::Settings;
use hemicube::scene::{Background, Light};
use hemicube::vk::pass::Recorder;
use std::f64::consts::PI;

/// A roof two metres wide over a floor of two kilometres in the sun: from below it sees the floor but for the roof's shadow,
/// which is a quarter of what it sees and a millionth of the floor.
#[test]
fn a_small_shadow_on_a_huge_floor() {
    let (irradiance, rho, height) = (2.0f32, 0.5f32, 2.0f32);
    let mut b = Builder::default();
    let grey = b.material(diffuse(rho));
    b.floor(grey, 0.0, 1000.0);
    b.quad(grey, vec3(-1.0, height, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
    b.light(Light::Directional { direction: Vec3::NEG_Y, irradiance: tinted(irradiance) });
    let settings = Settings { surface_cells: Some(1 << 17), ..small(96) };
    let picture = picture(&b.build(), &look(dvec3(0.0, 0.7, 2.5), dvec3(0.0, 2.0, 0.0), 40.0), &settings);
    let shadow = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| dvec3(x, 0.0, z));
    let radiance = f64::from(rho * irradiance) / PI;
    let roof = |p: DVec3, n: DVec3| n.y < -0.9 && p.y > 1.9;
    let below = |p: DVec3, n: DVec3| radiance * (PI - polygon(p, n, &shadow).abs());
    let deviation = against(&picture, "irradiance", TINT, |p, n| roof(p, n).then(|| below(p, n)));
    assert!(deviation.pixels > 1000);
    assert_close("under a roof", deviation, 0.004, 0.02, 0.002);
}

/// A cell of an open floor reflects ρ of all that the sky sends, whichever of its samples it takes: by 32 of them, half of them
/// below the floor, within a quarter; and the mean of many much more closely.
#[test]
fn cells_see_the_sky() {
    let rho = 0.5;
    let mut b = Builder::default();
    let grey = b.material(diffuse(rho));
    b.floor(grey, 0.0, 1.0);
    b.background(Background::Constant(vec3(1.0, 2.0, 3.0)));
    let settings = Settings::default();
    let settings = ProbeSettings {
        capture: settings.cache.capture,
        capture_size: 16,
        gradients: settings.cache.gradients,
        lights: settings.lights,
        surface_cells: 1 << 12,
    };
    let (device, scene) = (gpu(), b.build());
    let mut recorder = Recorder::new(&device);
    let probes = Probes::new(&device, &mut recorder, &scene, &settings).unwrap();
    let cells = probes.surface(&mut recorder, &device).unwrap();
    let red: Vec<f64> = cells.iter().map(|cell| f64::from(cell.radiance[0].x / rho)).collect();
    let mean = red.iter().sum::<f64>() / red.len() as f64;
    let worst = red.iter().map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
    eprintln!("{} cells: mean {mean:.4}, worst off by {worst:.4}", cells.len());
    assert!((mean - 1.0).abs() < 0.005 && worst < 0.25, "mean {mean}, worst {worst}");
    assert!(worst > 0.0, "each takes samples of its own");
}

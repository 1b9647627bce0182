//! Captures of a scene of many triangles: coarse ones stand for those at a distance, and the light stays the same.

#![allow(clippy::unwrap_used)] // the helpers belong to tests, which the lint cannot see

mod common;

use common::build::{Facing, diffuse, tessellated};
use common::{Builder, draw, look, small};
use glam::{Vec3, dvec3, vec3};
use hemicube::image::metrics::measure;
use hemicube::methods::captures::CaptureMode;
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Light, Scene, cornell};

/// A bright room full of finely cut balls, some of which hide others.
fn balls() -> (Scene, Camera) {
    let mut b = Builder::default();
    let [white, grey] = [0.7, 0.4].map(|rho| b.material(diffuse(rho)));
    b.cuboid(white, Vec3::splat(-4.0), Vec3::splat(4.0), Facing::In);
    for i in 0..18 {
        let turn = i as f32 * 2.4;
        let centre =
            vec3(turn.cos() * (1.0 + 0.15 * i as f32), -3.0 + 0.3 * i as f32, turn.sin() * (1.0 + 0.15 * i as f32));
        b.sphere(grey, centre, 0.6, 64, Facing::Out);
    }
    b.light(Light::Point { position: vec3(3.0, 3.5, 3.0), intensity: Vec3::splat(50.0) });
    (b.build(), look(dvec3(0.0, 1.0, 3.9), dvec3(0.0, -0.5, 0.0), 1.2))
}

fn settings(lod_error: f32) -> Settings {
    let mut settings = small(64);
    (settings.cache.capture, settings.cache.lod_error) = (CaptureMode::Compute, lod_error);
    settings
}

/// Levels against all triangles: irradiance of the pixels within 1 % on average and 5 % at the 99th percentile.
fn check(scene: &Scene, camera: &Camera) {
    let [all, levels] = [0.0, Settings::default().cache.lod_error].map(|e| draw(scene, camera, &settings(e)));
    assert!(levels.plan.levels && !all.plan.levels, "{} triangles", scene.triangles.len());
    let [test, exact] = [&levels, &all].map(|r| r.picture.layer("irradiance").unwrap());
    let m = measure(&test, &exact, 64, None);
    eprintln!(
        "{} triangles: {:.2} %, p99 {:.1} %, energy {:?}",
        scene.triangles.len(),
        m.mae * 1e2,
        m.p99 * 1e2,
        m.energy
    );
    assert!(m.mae > 0.0, "nothing stood for anything");
    assert!(m.mae <= 0.01 && m.p99 <= 0.05, "{m:?}");
    assert!((m.energy.unwrap() - 1.0).abs() <= 0.005, "{m:?}");
}

#[test]
fn balls_at_a_distance_give_the_same_light() {
    let (scene, camera) = balls();
    check(&scene, &camera);
}

/// Walls cut finely are flat still: what stands for them is exact, and only cells of light differ.
#[test]
fn a_finely_cut_cornell_box_has_the_same_light() {
    let scene = tessellated(&cornell(), 6);
    let (camera, _) = scene.camera(None).unwrap();
    check(&scene, &camera);
}

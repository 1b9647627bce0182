//! Captures of a scene of many triangles, and shadows of the sky in it: coarse ones stand for those at a distance or for all, and
//! the light stays the same.

use crate::common::build::{Facing, diffuse, tessellated};
use crate::common::{Builder, draw, holds, look, small};
use glam::{Vec3, dvec3, vec3};
use hemicube::image::metrics::measure;
use hemicube::methods::captures::CaptureMode;
use hemicube::renderer::{Part, Settings};
use hemicube::scene::{Background, Camera, Light, Scene, cornell};

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
    settings.cache.lod_error = lod_error;
    settings
}

/// Levels against all triangles: irradiance of the pixels within 1 % on average and 5 % at the 99th percentile.
fn check(scene: &Scene, camera: &Camera) {
    if !holds(scene) {
        return;
    }
    let in_compute = |lod_error| {
        let mut settings = settings(lod_error);
        settings.cache.capture = CaptureMode::Compute;
        draw(scene, camera, &settings)
    };
    let [all, levels] = [0.0, Settings::default().cache.lod_error].map(in_compute);
    assert!(levels.plan.runs(Part::Levels) && !all.plan.runs(Part::Levels), "{} triangles", scene.triangles.len());
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

/// Hills with a wall across them, of squares that are a 270th of the whole.
fn hills() -> (Scene, Camera) {
    const SQUARES: i32 = 270;
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.6));
    let at = |i: i32, j: i32| {
        let [x, z] = [i, j].map(|k| 20.0 * (k as f32 / SQUARES as f32 - 0.5));
        vec3(x, 0.8 * (0.9 * x).sin() * (1.3 * z).cos() + 0.1 * (5.0 * x + 3.0 * z).sin(), z)
    };
    for (i, j) in (0..SQUARES).flat_map(|i| (0..SQUARES).map(move |j| (i, j))) {
        b.triangle(grey, [at(i, j), at(i, j + 1), at(i + 1, j)]);
        b.triangle(grey, [at(i + 1, j + 1), at(i + 1, j), at(i, j + 1)]);
    }
    b.cuboid(grey, vec3(-6.0, -1.0, -0.1), vec3(6.0, 2.5, 0.1), Facing::Out);
    b.background(Background::Constant(vec3(0.5, 0.7, 1.0)));
    (b.build(), look(dvec3(3.0, 3.0, 6.0), dvec3(0.0, 0.0, 0.0), 60.0))
}

/// The sky's shadows on what captures see: by the surface itself, and by a coarser one.
#[test]
fn a_sky_lights_hills_the_same_by_coarser_ones() {
    let (scene, camera) = hills();
    let [exact, coarse] = [0.0, Settings::default().cache.lod_error].map(|e| draw(&scene, &camera, &settings(e)));
    assert!(
        coarse.plan.runs(Part::CoarseCasters) && !exact.plan.runs(Part::CoarseCasters),
        "{:?}",
        coarse.plan.left_out()
    );
    let [test, truth] = [&coarse, &exact].map(|r| r.picture.layer("irradiance").unwrap());
    let m = measure(&test, &truth, 64, None);
    eprintln!("hills: {:.2} %, p99 {:.1} %, energy {:?}", m.mae * 1e2, m.p99 * 1e2, m.energy);
    assert!(m.mae > 0.0, "nothing is coarser");
    assert!(m.mae <= 0.01 && m.p99 <= 0.05, "{m:?}");
    // Receivers stand off by 1.25 times the error: 0.2 % too bright. By 1.0 times it they are 1.1 % too dark, by 1.5 times 0.7 % too
    // bright.
    assert!((m.energy.unwrap() - 1.0).abs() <= 0.005, "{m:?}");
}

/// A ball and a box, seen from inside, under a bright sky: what stands for them lets no more of it in than they do themselves, a
/// grain between triangles.
#[test]
fn what_is_closed_is_dark_inside_by_coarse_casters() {
    const SKY: f32 = 1e3;
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.6));
    b.sphere(grey, vec3(-2.0, 0.0, 0.0), 1.5, 150, Facing::In);
    b.cuboid(grey, vec3(0.5, -1.5, -1.5), vec3(3.5, 1.5, 1.5), Facing::In);
    b.background(Background::Constant(Vec3::splat(SKY / std::f32::consts::PI)));
    let scene = tessellated(&b.build(), 1);
    for (x, side) in [(-2.0, "ball"), (2.0, "box")] {
        let camera = look(dvec3(x, 0.3, 1.2), dvec3(x + 0.2, -0.2, 0.0), 90.0);
        let rendered = draw(&scene, &camera, &settings(Settings::default().cache.lod_error));
        assert!(rendered.plan.runs(Part::CoarseCasters), "{:?}", rendered.plan.left_out());
        let layer = rendered.picture.layer("irradiance").unwrap();
        let most = layer.channels.iter().flat_map(|c| c.iter()).fold(0.0f32, |most, e| most.max(*e)) / SKY;
        eprintln!("{side}: {most:e} of the sky");
        assert!(most <= 1e-4, "in the {side}");
    }
}

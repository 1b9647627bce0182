//! Light beyond the first bounce, against closed forms and path-traced references.

use crate::common::build::{Facing, diffuse};
use crate::common::{Builder, TINT, against, check_complete, draw, each_capture, look, scene_folder, small, tinted};
use glam::{Vec3, dvec3, vec3};
use hemicube::image::metrics::{mask, measure};
use hemicube::image::{Picture, exr};
use hemicube::methods::surface_cache::{ALL_BOUNCES, Solver};
use hemicube::passes::resolve::Plane;
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Light, Scene, load};

/// The inside of a sphere of radius 1 with a point light of intensity 3 halfway out.
fn sphere(rho: f32) -> (Scene, Camera) {
    let mut b = Builder::default();
    let white = b.material(diffuse(rho));
    b.sphere(white, Vec3::ZERO, 1.0, 32, Facing::In);
    b.light(Light::Point { position: vec3(0.0, -0.5, 0.0), intensity: tinted(3.0) });
    (b.build(), look(dvec3(0.0, 0.3, 0.8), dvec3(0.0, 0.0, -1.0), 90.0))
}

/// E = I/s²·Σ ρᵏ over the bounces k = 1 …, everywhere, wherever the light stands.
fn check_sphere(rho: f32, settings: &Settings, most: f64) {
    let (scene, camera) = sphere(rho);
    let rendered = draw(&scene, &camera, settings);
    check_complete(&rendered);
    let q = f64::from(rho);
    let bounces = if settings.bounces == ALL_BOUNCES { f64::INFINITY } else { f64::from(settings.bounces) };
    let expected = 3.0 * q * (1.0 - q.powf(bounces)) / (1.0 - q);
    let off = against(&rendered.picture, "irradiance", TINT, |_, _| Some(expected));
    let bounced = rendered.bounced.unwrap_or_default();
    let (places, products, lost) = (bounced.places, bounced.steps.len(), bounced.lost);
    eprintln!(
        "ρ {rho}, {bounces} bounces: energy {:+.3} %, {places} places, {products} products, {lost:.1e} lost, {:.0?} ms",
        (off.energy - 1.0) * 1e2,
        bounced.times_ms
    );
    assert!((off.energy - 1.0).abs() <= most && off.mean <= most, "ρ {rho}: {off:?}");
    assert!(!bounced.is_unfinished && !bounced.is_cut);
}

#[test]
fn integrating_sphere_after_all_bounces() {
    for (rho, most) in [(0.1, 0.01), (0.5, 0.01), (0.95, 0.01), (0.99, 0.02)] {
        let settings = Settings { bounces: ALL_BOUNCES, bounce_tolerance: 1e-4, ..small(24) };
        check_sphere(rho, &settings, most);
    }
}

#[test]
fn partial_sums_are_those_of_the_series() {
    for bounces in [2, 3, 6] {
        check_sphere(0.8, &Settings { bounces, ..small(24) }, 0.01);
    }
}

/// Both ways to capture show the same cells; both solvers come to the same light.
#[test]
fn every_way_to_capture_and_to_solve_agrees() {
    for settings in each_capture(Settings { bounces: ALL_BOUNCES, bounce_tolerance: 1e-4, ..small(24) }) {
        check_sphere(0.9, &settings, 0.01);
        check_sphere(0.9, &Settings { bounce_solver: Solver::Plain, ..settings }, 0.01);
    }
}

/// A closed room behind a wall of a bright one, each with its own floor: nothing of 10⁶ passes.
#[test]
fn a_closed_room_stays_black() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.9));
    b.cuboid(white, Vec3::splat(-1.0), Vec3::splat(1.0), Facing::In);
    b.cuboid(white, vec3(1.005, -1.0, -1.0), vec3(3.0, 1.0, 1.0), Facing::In);
    b.light(Light::Point { position: vec3(2.0, 0.3, 0.1), intensity: Vec3::splat(1e6) });
    let camera = look(dvec3(-0.8, 0.4, 0.8), dvec3(1.0, -0.3, -0.2), 80.0);
    let rendered = draw(&b.build(), &camera, &Settings { bounces: ALL_BOUNCES, ..small(48) });
    check_complete(&rendered);
    let brightest = rendered.picture.rgb("irradiance").unwrap().into_iter().flatten().fold(0.0_f32, |a, b| a.max(*b));
    assert_eq!(brightest, 0.0);
}

/// The irradiance of a scene's own camera against layers of its reference.
fn check_reference(name: &str, size: [u32; 2], bounces: u32, truth: &[&str], (most, energy): (f64, f64)) {
    let Some(folder) = scene_folder(name) else { return };
    let scene = load(&folder.join(format!("{name}.gltf"))).unwrap();
    let [width, height] = size;
    let reference = exr::read(&folder.join(format!("E_{width}x{height}.exr"))).unwrap();
    let planes = vec![Plane::Irradiance, Plane::Mask];
    let rendered = draw(&scene, &scene.cameras[0], &Settings { width, height, planes, bounces, ..Settings::default() });
    check_complete(&rendered);
    let keep = mask(reference.rgb("mask").unwrap()[0]);
    let mut sum = reference.rgb(truth[0]).unwrap().map(<[f32]>::to_vec);
    for more in &truth[1..] {
        let more = reference.rgb(more).unwrap();
        sum.iter_mut().zip(more).for_each(|(sum, more)| sum.iter_mut().zip(more).for_each(|(s, m)| *s += m));
    }
    let mut all = Picture { width, height, ..Picture::default() };
    let [r, g, b] = &sum;
    all.insert_rgb("irradiance", r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]));
    let (test, truth) = (rendered.picture.layer("irradiance").unwrap(), all.layer("irradiance").unwrap());
    let off = measure(&test, &truth, width as usize, Some(&keep));
    let balance = off.energy.unwrap() - 1.0;
    eprintln!(
        "{name}, {bounces} bounces: {:.2} % (4 × 4: {:.2} %), energy {:+.2} %, {:?}",
        off.mae * 1e2,
        off.block_mae * 1e2,
        balance * 1e2,
        rendered.bounced.map(|b| (b.places, b.entries, b.steps.len(), b.lost, b.times_ms))
    );
    assert!(off.block_mae <= most, "{name}: {} off", off.block_mae);
    assert!(balance.abs() <= energy, "{name}: energy {balance} off");
}

/// In blocks of 4 × 4 pixels: of the references' single pixels more than a percent is their own noise.
#[test]
fn cornell_box() {
    check_reference("cornell", [256, 256], 2, &["b1", "b2"], (0.02, 0.015));
    check_reference("cornell", [256, 256], ALL_BOUNCES, &["b1", "b2", "b3plus"], (0.02, 0.015));
}

#[test]
fn sponza() {
    check_reference("sponza", [128, 128], ALL_BOUNCES, &["b1", "b2", "b3plus"], (0.04, 0.015));
}

/// Twice the light gives twice the irradiance, bit by bit.
#[test]
fn all_bounces_scale_with_the_light() {
    let (scene, camera) = sphere(0.5);
    let mut bright = scene.clone();
    bright.lights = vec![Light::Point { position: vec3(0.0, -0.5, 0.0), intensity: tinted(6.0) }];
    let settings = Settings { bounces: 3, ..small(16) };
    let [one, two] = [scene, bright].map(|scene| draw(&scene, &camera, &settings).picture);
    let values = |picture: &Picture| picture.rgb("irradiance").unwrap().map(<[f32]>::to_vec);
    for (a, b) in values(&one).iter().flatten().zip(values(&two).iter().flatten()) {
        assert_eq!(2.0 * a, *b);
    }
}

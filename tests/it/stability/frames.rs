//! Extremes that take a whole image: sizes, record counts, cameras in odd places.

use crate::common::{check_complete, draw, look, look_parallel, picture, small};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::methods::captures::{CaptureMode, GRAIN};
use hemicube::renderer::Settings;
use hemicube::report::stability::Bench;
use hemicube::scene::build::{Builder, Facing, diffuse};
use hemicube::scene::{Background, Camera, Light, Scene};
use std::f64::consts::PI;

/// A floor with a wall at x = 0 under a sky of radiance 1.
fn corner() -> Scene {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 1.0);
    b.quad(grey, vec3(0.0, 0.0, 1.0), Vec3::NEG_Z * 2.0, Vec3::Y);
    b.background(Background::Constant(Vec3::ONE));
    b.build()
}

fn above() -> Camera {
    look_parallel(dvec3(0.5, 3.0, 0.0), dvec3(0.5, 0.0, 0.0), 0.5)
}

/// A pixel, a record: the record's place returns the record's own value.
#[test]
fn one_record_is_its_own_value() {
    // The sun lights floor and wall evenly: however they are cut into cells, these have one radiance.
    let mut scene = corner();
    scene.background = Background::Black;
    scene.lights.push(Light::Directional { direction: vec3(-0.6, -0.8, 0.0), irradiance: vec3(3.0, 2.0, 1.0) });
    let mut settings = small(1);
    settings.cache.seed = 3;
    let rendered = draw(&scene, &above(), &settings);
    check_complete(&rendered);
    assert_eq!(rendered.cache.records, 1);
    let picture = &rendered.picture;
    let (p, n) = (picture.xyz("P").unwrap(), picture.xyz("N").unwrap());
    let at = |planes: [&[f32]; 3]| Vec3::from(planes.map(|plane| plane[0]));
    let normal = at(n);
    let place = hemicube::methods::probes::Place {
        position: at(p),
        normal,
        geometric: normal,
        turn: turn_of(at(p), &scene, 3),
    };
    let device = super::gpu();
    let bench = Bench { device: device.clone(), capture: CaptureMode::Auto };
    let probes =
        bench.measure(&scene, &[place], settings.cache.capture_size, (1 << 14, settings.lights.area_samples)).unwrap();
    let (got, own) = (at(picture.rgb("irradiance").unwrap()), probes[0].reflected.value);
    eprintln!("the pixel's {got}, the record's {own}");
    // The normal is read back from 2 × 16 bits, and the turn's sine is another machine's: no texel moves by a thousandth.
    assert!((got - own).abs().max_element() < 1e-4 * own.max_element(), "{got} {own}");
}

/// Twin of the turn in `glsl/place_records/place_records.comp`.
fn turn_of(place: Vec3, scene: &Scene, seed: u32) -> f32 {
    let (low, high) = scene.bounds();
    let cube = (place / ((high - low).length() * 0.5 * GRAIN)).floor().as_ivec3();
    let hash = [cube.z, cube.y, cube.x].iter().fold(pcg(seed), |hash, c| pcg(*c as u32 ^ hash));
    std::f32::consts::TAU * unit_float(hash)
}

/// Twin of `glsl/inc/hash.glsl`.
fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn unit_float(v: u32) -> f32 {
    (v >> 8) as f32 / 16_777_216.0
}

/// R grows with the distance x from a wall, so that without a limit records would grow as 1/(a²x) towards it. With R⁻ of m
/// pixels a record covers what is nearer than 0.7 m to it (the weight 1 − d/R⁻ that counts as covered is 0.3), but for
/// those of the same round, whose lattice is a power of two: at most one for each square of half that.
#[test]
fn records_beside_a_wall_are_bounded_by_the_smallest_radius() {
    let side = 128;
    for pixels in [4.0f32, 8.0, 16.0] {
        let mut settings = small(side);
        settings.cache.accuracy = 0.02;
        settings.cache.capture_size = 8;
        settings.cache.min_radius = pixels / side as f32;
        let rendered = draw(&corner(), &above(), &settings);
        check_complete(&rendered);
        let bound = (f64::from(side) / (0.35 * f64::from(pixels))).powi(2);
        let records = rendered.cache.records;
        eprintln!("R⁻ = {pixels} pixels: {records} records, at most {bound:.0}");
        assert!((records as f64) < bound, "{records} records");
    }
}

#[test]
fn a_hundred_thousand_records() {
    let mut settings = Settings { surface_cells: Some(1 << 10), ..small(680) };
    settings.cache.accuracy = 1e-3;
    settings.cache.min_radius = 1e-6;
    settings.cache.capture_size = 8;
    settings.lights.sky_samples = 16;
    let rendered = draw(&corner(), &above(), &settings);
    check_complete(&rendered);
    eprintln!("{} records", rendered.cache.records);
    assert!(rendered.cache.records >= 100_000, "{} records", rendered.cache.records);
}

#[test]
fn a_4k_image() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 1.0);
    b.background(Background::Constant(Vec3::ONE));
    let mut settings = Settings { width: 3840, height: 2160, ..small(1) };
    settings.lights.sky_samples = 16;
    settings.planes = [hemicube::passes::resolve::Plane::DirectIrradiance].into();
    let rendered = draw(&b.build(), &look_parallel(dvec3(0.0, 1.0, 0.0), DVec3::ZERO, 0.3), &settings);
    let e = rendered.picture.rgb("irradiance_direct").unwrap()[0];
    assert_eq!(e.len(), 3840 * 2160);
    let worst = e.iter().map(|e| (f64::from(*e) / PI - 1.0).abs()).fold(0.0, f64::max);
    eprintln!("{} records, E = πL within {worst:.1e}", rendered.cache.records);
    assert!(worst < 1e-4);
}

/// The eye within a closed block sees its inside, which is dark; all around shines.
#[test]
fn an_eye_inside_of_a_block() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.cuboid(grey, Vec3::splat(-1.0), Vec3::splat(1.0), Facing::Out);
    b.floor(grey, -1.0, 4.0);
    b.background(Background::Constant(Vec3::ONE));
    let picture = picture(&b.build(), &look(dvec3(0.2, 0.1, 0.3), dvec3(-1.0, -0.4, 0.0), 90.0), &small(48));
    let sky = picture.rgb("irradiance_direct").unwrap()[0];
    assert!(sky.iter().all(|e| *e == 0.0), "the sky is not seen from inside");
}

/// Zones of influence that hold the eye cover the whole screen: bounds of their quads have no tangent there.
#[test]
fn zones_around_the_eye() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.8));
    b.sphere(grey, Vec3::ZERO, 1.0, 48, Facing::In);
    b.light(Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE });
    let scene = b.build();
    for eye in [dvec3(0.0, 0.0, 0.0), dvec3(0.0, 0.2, 0.9), dvec3(0.0, 0.0, 0.99)] {
        let mut settings = Settings { surface_cells: Some(1 << 16), ..small(48) };
        settings.cache.accuracy = 2.0;
        settings.cache.max_radius = 1e3;
        settings.cache.normal_limit = 0.9;
        let picture = picture(&scene, &look(eye, dvec3(0.1, -0.2, -1.0), 100.0), &settings);
        let e = picture.rgb("irradiance").unwrap()[0];
        let worst = e.iter().map(|e| (f64::from(*e) / 0.8 - 1.0).abs()).fold(0.0, f64::max);
        eprintln!("eye at {eye}: E₁ = ρI/s² within {:.2} %", worst * 100.0);
        assert!(worst < 0.02, "{worst}");
    }
}

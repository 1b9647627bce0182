//! Irradiance against formulas.

use super::scenes::*;
use crate::math::form_factor;
use crate::math::sampling::uniform_sphere;
use crate::reference::{Estimate, Settings, Tracer, irradiance_at};
use crate::scene::{Background, Light, Scene};
use glam::{DVec3, Vec3, dvec3, vec3};
use std::f64::consts::PI;

const FAR: f32 = 3000.0;

fn settings(bounces: u32) -> Settings {
    Settings { bounces, seed: 1, batch: 1024 }
}

fn at(scene: &Scene, position: DVec3, normal: DVec3, bounces: u32, spp: u32) -> Estimate {
    irradiance_at(&Tracer::new(scene), position, normal, &settings(bounces), spp)
}

/// Within five standard errors, which are themselves below `tolerance` of the expected value.
#[track_caller]
fn check(name: &str, value: f64, stderr: f64, expected: f64, tolerance: f64) {
    let z = (value - expected) / stderr.max(1e-12);
    println!("{name}: {value:.6} ± {stderr:.6}, expected {expected:.6}, z {z:+.2}");
    assert!(stderr <= tolerance * expected.abs(), "{name}: standard error {stderr} is too large to tell");
    // What is left besides noise: single-precision corners and samples.
    assert!(
        (value - expected).abs() <= 5.0 * stderr + 2e-6 * expected.abs(),
        "{name}: {value} is not {expected}, z {z}"
    );
}

#[test]
fn rectangle() {
    let e = at(&rectangle_light(), DVec3::ZERO, DVec3::Z, 0, 131072);
    check("rectangle", e.mean[0].x, e.stderr[0].x, 0.552554, 1e-3);
}

#[test]
fn one_sided_light_is_dark_behind() {
    let mut scene = rectangle_light();
    scene.materials[0].double_sided = false;
    assert_eq!(at(&scene, DVec3::ZERO, DVec3::Z, 0, 256).mean[0], DVec3::ZERO);
    let e = at(&scene, dvec3(0.0, 0.0, 2.0), DVec3::NEG_Z, 0, 131072);
    check("rectangle from its front", e.mean[0].x, e.stderr[0].x, 0.552554, 1e-3);
}

#[test]
fn sphere_light() {
    let distance = 2.0;
    for cos in [1.0f64, 0.6, 0.1, -0.2] {
        let direction = dvec3((1.0 - cos * cos).sqrt(), 0.0, cos);
        let scene = only_emitter(&sphere(direction * distance, 1.0, 100));
        let e = at(&scene, DVec3::ZERO, DVec3::Z, 0, 131072);
        let expected = form_factor::sphere(0.5, cos);
        // The mesh is inscribed: its silhouette is smaller by about (π/100)²/6 to /2 of its area.
        let (low, high) = (expected * (1.0 - 6e-4), expected);
        let slack = 5.0 * e.stderr[0].x;
        assert!(e.mean[0].x > low - slack && e.mean[0].x < high + slack, "cos {cos}: {} {expected}", e.mean[0].x);
        assert!(e.stderr[0].x < 5e-3 * expected);
    }
}

#[test]
fn wedge_is_the_same_at_every_distance() {
    let angle = 50f64.to_radians();
    let along = dvec3(angle.cos(), 0.0, angle.sin()).as_vec3() * FAR;
    let corners = [vec3(0.0, -FAR, 0.0), vec3(0.0, FAR, 0.0), along + vec3(0.0, FAR, 0.0), along - vec3(0.0, FAR, 0.0)];
    let scene = only_emitter(&quad(corners));
    let expected = PI * 0.5 * (1.0 + angle.cos());
    for distance in [0.01, 0.1, 1.0] {
        let e = at(&scene, dvec3(distance, 0.0, 0.0), DVec3::Z, 0, 262144);
        // The wall ends at 3000: seen from 1, some 1e-6 of it is missing.
        check("wedge", e.mean[0].x, e.stderr[0].x, expected, 1e-3);
    }
}

#[test]
fn wall() {
    let h = 2.0;
    let corners = [vec3(0.0, -FAR, 0.0), vec3(0.0, FAR, 0.0), vec3(0.0, FAR, h), vec3(0.0, -FAR, h)];
    let scene = only_emitter(&quad(corners));
    for x in [0.1, 1.0, 5.0] {
        let e = at(&scene, dvec3(x, 0.0, 0.0), DVec3::Z, 0, 262144);
        check("wall", e.mean[0].x, e.stderr[0].x, form_factor::wall(x, f64::from(h)), 1e-2);
    }
}

#[test]
fn slit() {
    // A black screen at height 1 with a slit in it under a constant sky.
    let half = 0.05;
    let strip = |from: f32, to: f32| {
        quad([vec3(from, -FAR, 1.0), vec3(to, -FAR, 1.0), vec3(to, FAR, 1.0), vec3(from, FAR, 1.0)])
    };
    let mut scene = Scene { background: Background::Constant(Vec3::ONE), ..Scene::default() };
    add(&mut scene, diffuse(0.0), &strip(-FAR, -half));
    add(&mut scene, diffuse(0.0), &strip(half, FAR));
    let e = at(&scene, DVec3::ZERO, DVec3::Z, 0, 524288);
    check("slit", e.mean[0].x, e.stderr[0].x, PI * form_factor::slit(0.1, 1.0), 1e-2);
}

#[test]
fn tilted_and_linear_skies() {
    let ground = quad([vec3(-FAR, -FAR, 0.0), vec3(FAR, -FAR, 0.0), vec3(FAR, FAR, 0.0), vec3(-FAR, FAR, 0.0)]);
    let mut scene = Scene { background: Background::Constant(Vec3::ONE), ..Scene::default() };
    add(&mut scene, diffuse(0.0), &ground);
    let beta = 70f64.to_radians();
    let e = at(&scene, dvec3(0.0, 0.0, 1e-3), dvec3(beta.sin(), 0.0, beta.cos()), 0, 262144);
    check("tilted sky", e.mean[0].x, e.stderr[0].x, form_factor::tilted_sky(beta), 1e-3);

    let linear = Scene { background: map(512, |w| 1.0 + 0.5 * w.x), ..Scene::default() };
    let n = dvec3(0.6, 0.0, 0.8);
    let e = at(&linear, DVec3::ZERO, n, 0, 262144);
    let expected = PI + 2.0 * PI / 3.0 * 0.5 * n.x;
    // The map's bilinear texels round the function by some 1e-5.
    assert!(e.stderr[0].x < 1e-3 && (e.mean[0].x - expected).abs() < 5.0 * e.stderr[0].x + 1e-4, "{e:?} {expected}");
}

#[test]
fn a_small_sun_in_a_map_is_found() {
    let (w, h) = (256.0, 128.0);
    let background = map(256, |d| if d.dot(dvec3(0.0, 0.6, -0.8)) > 0.999 { 5000.0 } else { 0.1 });
    let Background::Map(m) = &background else { unreachable!() };
    let mut expected = 0.0; // texel by texel, as bilinear lookup keeps the mean
    for (i, rgb) in m.rgb.iter().enumerate() {
        let theta = PI * ((i / 256) as f64 + 0.5) / h;
        let cell = 2.0 * PI / w * ((theta - PI / h / 2.0).cos() - (theta + PI / h / 2.0).cos());
        expected += f64::from(rgb[0]) * cell * theta.cos().max(0.0);
    }
    let scene = Scene { background, ..Scene::default() };
    let e = at(&scene, DVec3::ZERO, DVec3::Y, 0, 131072);
    assert!((e.mean[0].x / expected - 1.0).abs() < 5e-3, "{} {expected}", e.mean[0].x);
    assert!(e.stderr[0].x < 5e-3 * expected);
}

#[test]
fn furnace_with_n_bounces() {
    let rho = 0.7f64;
    let faces = box_faces(Vec3::splat(-1.0), Vec3::splat(1.0)).concat();
    let mut scene = Scene::default();
    let material = crate::scene::Material { emission: Vec3::ONE, double_sided: true, ..diffuse(rho as f32) };
    add(&mut scene, material, &faces);
    let mut tracer = Tracer::new(&scene);
    tracer.emitters_reflect = true;
    let position = dvec3(0.3, -0.2, -0.999);
    let rho = f64::from(rho as f32);
    for bounces in [0, 1, 2, 5, 20] {
        let e = irradiance_at(&tracer, position, DVec3::Z, &settings(bounces), 65536);
        let expected = PI * (1.0 - rho.powi(bounces as i32 + 1)) / (1.0 - rho);
        let error = (e.stderr[0] + e.stderr_indirect).x;
        check("furnace", (e.mean[0] + e.indirect()).x, error, expected, 1e-2);
    }
    let e = irradiance_at(&tracer, position, DVec3::Z, &settings(Settings::ALL_BOUNCES), 262144);
    check("furnace, all", (e.mean[0] + e.indirect()).x, (e.stderr[0] + e.stderr_indirect).x, PI / (1.0 - rho), 1e-2);
}

#[test]
fn integrating_sphere_with_a_point_light() {
    let mut scene = Scene { lights: vec![point_light(vec3(0.4, 0.1, -0.2))], ..Scene::default() };
    add(&mut scene, diffuse(0.5), &sphere(DVec3::ZERO, 1.0, 64));
    let e = at(&scene, dvec3(0.0, 0.6, -0.79), dvec3(0.0, -0.6, 0.8), 3, 131072);
    for (bounce, expected) in [(1, 0.5), (2, 0.25), (3, 0.125)] {
        let (value, error) = (e.mean[bounce].x, e.stderr[bounce].x);
        // The flat facets of the mesh are off by (π/64)².
        assert!(
            (value - expected).abs() < 5.0 * error + 4e-3 * expected && error < 5e-3,
            "{bounce}: {value} ± {error}"
        );
    }
}

#[test]
fn punctual_lights_many_or_few() {
    let lights: Vec<Light> = (0..12).map(|i| point_light(vec3(i as f32 - 5.0, 1.0, 2.0))).collect();
    let exact: f64 = (0..12).map(|i| 2.0 / dvec3(f64::from(i) - 5.0, 1.0, 2.0).length().powi(3)).sum();
    let few = Scene { lights: lights[..3].to_vec(), ..Scene::default() };
    let all = Scene { lights, ..Scene::default() };
    let e = at(&all, DVec3::ZERO, DVec3::Z, 0, 8192);
    check("12 lights", e.mean[0].x, e.stderr[0].x, exact, 1e-2);
    let expected: f64 = (0..3).map(|i| 2.0 / dvec3(f64::from(i) - 5.0, 1.0, 2.0).length().powi(3)).sum();
    assert!((at(&few, DVec3::ZERO, DVec3::Z, 0, 1024).mean[0].x / expected - 1.0).abs() < 1e-12);
}

#[test]
fn spot_and_directional_lights() {
    let spot = Light::Spot {
        position: vec3(0.0, 0.0, 2.0),
        direction: Vec3::NEG_Z,
        intensity: Vec3::splat(8.0),
        cos_inner: 0.9,
        cos_outer: 0.8,
    };
    let scene = Scene { lights: vec![spot], ..Scene::default() };
    let e = |x: f64| at(&scene, dvec3(x, 0.0, 0.0), DVec3::Z, 0, 1024).mean[0].x;
    assert!((e(0.0) - 2.0).abs() < 1e-9);
    let cos = 0.85f64;
    let x = 2.0 * (1.0 - cos * cos).sqrt() / cos;
    let d2 = 4.0 + x * x;
    assert!((e(x) - 8.0 * 0.25 * cos / d2).abs() < 1e-6);
    assert_eq!(e(3.0), 0.0);
    let sun = Light::Directional { direction: vec3(0.0, 0.6, -0.8), irradiance: Vec3::splat(3.0) };
    let scene = Scene { lights: vec![sun], ..Scene::default() };
    assert!((at(&scene, DVec3::ZERO, DVec3::Z, 0, 1024).mean[0].x - 2.4).abs() < 1e-6);
}

#[test]
fn unit_cube_form_factors() {
    // Mean irradiance of a face from another face of radiance 1 is π × the form factor.
    let faces = box_faces(Vec3::ZERO, Vec3::ONE);
    for (face, name, expected) in [(5, "opposite", 0.199825), (1, "adjacent", 0.200044)] {
        let scene = only_emitter(&faces[face]);
        let tracer = Tracer::new(&scene);
        let n = 32u32;
        let mut mean = 0.0;
        for i in 0..n * n {
            let p = dvec3((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n), 0.0);
            let settings = Settings { seed: u64::from(i), ..settings(0) };
            mean += irradiance_at(&tracer, p, DVec3::Z, &settings, 256).mean[0].x / f64::from(n * n) / PI;
        }
        assert!((mean - expected).abs() < 2e-4, "{name}: {mean}");
    }
}

#[test]
fn nothing_leaks_through_a_thin_wall() {
    let mut scene = Scene { background: Background::Constant(Vec3::splat(1e6)), ..Scene::default() };
    // A room with zero-thickness walls that meet exactly at edges, off the grid, far from the origin.
    let shift = Vec3::splat(1000.0 / 3.0);
    let faces = box_faces(vec3(-1.0, -0.7, -0.3) + shift, vec3(0.9, 1.1, 0.5) + shift).concat();
    add(&mut scene, diffuse(0.9), &faces);
    scene.lights.push(Light::Point { position: shift + vec3(5.0, 5.0, 5.0), intensity: Vec3::splat(1e6) });
    let tracer = Tracer::new(&scene);
    for i in 0..2000 {
        let [u, v, x, y] = sobol_burley::sample_4d(i, 0, 9).map(f64::from);
        let position = shift.as_dvec3() + dvec3(1.8 * u - 0.95, 1.7 * v - 0.65, 0.7 * x - 0.25);
        let settings = Settings { seed: u64::from(i), batch: 16, ..settings(6) };
        let e = irradiance_at(&tracer, position, uniform_sphere(y, u), &settings, 64);
        assert_eq!(e.mean, [DVec3::ZERO; 4], "light at {position}");
    }
}

#[test]
fn powers_of_two_scale_exactly() {
    let build = |world: f32, light: f32| {
        let mut scene = Scene::default();
        let scaled = |t: &[[Vec3; 3]]| t.iter().map(|c| c.map(|p| p * world)).collect::<Vec<_>>();
        let faces = box_faces(Vec3::splat(-1.0), Vec3::splat(1.0));
        add(&mut scene, diffuse(0.6), &scaled(&faces[..5].concat()));
        add(&mut scene, emitter(light), &scaled(&faces[5]));
        let position = dvec3(0.3, 0.2, -0.9) * f64::from(world);
        at(&scene, position, DVec3::Z, 4, 128).mean
    };
    let unit = build(1.0, 1.0);
    assert!(unit[3].x > 0.0);
    assert_eq!(build(2f32.powi(-12), 1.0), unit);
    assert_eq!(build(2f32.powi(13), 1.0), unit);
    assert_eq!(build(1.0, 1024.0), unit.map(|l| l * 1024.0));
}

#[test]
fn error_falls_as_one_over_the_root_of_the_samples() {
    let mut scene = Scene::default();
    let faces = box_faces(Vec3::splat(-1.0), Vec3::splat(1.0));
    add(&mut scene, diffuse(0.8), &faces[..5].concat());
    add(
        &mut scene,
        emitter(1.0),
        &quad([vec3(-0.2, -0.2, 0.99), vec3(0.2, -0.2, 0.99), vec3(0.2, 0.2, 0.99), vec3(-0.2, 0.2, 0.99)]),
    );
    let tracer = Tracer::new(&scene);
    let position = dvec3(0.3, -0.2, -0.999);
    let run = |seed, spp| {
        let settings = Settings { bounces: 1, seed, batch: 4 };
        irradiance_at(&tracer, position, DVec3::Z, &settings, spp).mean[1].x
    };
    let truth = run(999, 1 << 19);
    let rms = |spp: u32| {
        let runs = 24;
        let sum: f64 = (0..runs).map(|seed| (run(seed, spp) - truth).powi(2)).sum();
        (sum / runs as f64).sqrt() / truth
    };
    let errors = [16, 256, 4096, 16384].map(|spp| (spp, rms(spp)));
    for pair in errors.windows(2) {
        let slope = (pair[1].1 / pair[0].1).ln() / (f64::from(pair[1].0) / f64::from(pair[0].0)).ln();
        println!("rms {:?} slope {slope:.2}", pair);
    }
    let slope = (errors[3].1 / errors[0].1).ln() / 1024f64.ln();
    assert!((slope + 0.5).abs() < 0.07, "slope {slope}, {errors:?}");
}

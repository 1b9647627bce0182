//! One bounce in rooms whose irradiance has a closed form.

use super::difference;
use crate::common::build::{Facing, diffuse, tessellated};
use crate::common::closed_forms::{element, over_square, parallelogram, point_light, polygon};
use crate::common::{
    Builder, TINT, against, assert_close, each_capture, holds, inside, look, look_parallel, picture, small, tinted,
};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::renderer::Settings;
use hemicube::scene::{Background, Light, cornell};
use std::f64::consts::PI;

/// First bounce inside a sphere: each point sees each other with the same weight, so E₁ = ρ·(mean direct irradiance) =
/// ρ·4πI/(4πs²), wherever the light stands.
#[test]
fn integrating_sphere_after_one_bounce() {
    for (name, offset) in [("centre", Vec3::ZERO), ("halfway out", vec3(0.0, -0.5, 0.0))] {
        let mut b = Builder::default();
        let white = b.material(diffuse(0.8));
        b.sphere(white, Vec3::ZERO, 1.0, 48, Facing::In);
        b.light(Light::Point { position: offset, intensity: tinted(3.0) });
        let settings = Settings { surface_cells: Some(1 << 16), ..small(64) };
        let picture = picture(&b.build(), &look(dvec3(0.0, 0.3, 0.8), dvec3(0.0, 0.0, -1.0), 90.0), &settings);
        let deviation = against(&picture, "irradiance", TINT, |_, _| Some(0.8 * 3.0));
        assert_close(&format!("integrating sphere, light at the {name}"), deviation, 0.005, 0.02, 0.005);
        if offset == Vec3::ZERO {
            let direct = against(&picture, "irradiance_direct", TINT, |_, _| Some(3.0));
            assert_close("its direct light", direct, 3e-3, 5e-3, 3e-3);
        }
    }
}

/// A wall of height h, lit at right angles by a sun that grazes the floor: E = ½πL(1 − x/√(x² + h²)), πL = ρE₀.
#[test]
fn profile_before_a_lit_wall() {
    let (height, length, irradiance, rho) = (1.0f32, 60.0f32, 3.0f32, 0.5f32);
    let mut b = Builder::default();
    let (grey, black) = (b.material(diffuse(rho)), b.material(diffuse(0.0)));
    b.quad(grey, vec3(0.0, 0.0, 0.5 * length), Vec3::NEG_Z * length, Vec3::Y * height);
    b.quad(black, vec3(0.0, 0.0, 2.0), Vec3::X * 3.0, Vec3::NEG_Z * 4.0);
    b.light(Light::Directional { direction: Vec3::NEG_X, irradiance: tinted(irradiance) });
    let mut settings = Settings { surface_cells: Some(1 << 16), ..small(96) };
    settings.cache.accuracy = 0.15;
    let picture = picture(&b.build(), &look_parallel(dvec3(1.5, 4.0, 0.0), dvec3(1.5, 0.0, 0.0), 1.4), &settings);
    let expected = |x: f64| 0.5 * f64::from(rho * irradiance) * (1.0 - x / (x * x + f64::from(height * height)).sqrt());
    let floor = |p: DVec3, n: DVec3| n.y > 0.9 && p.x > 0.02;
    let deviation = against(&picture, "irradiance", TINT, |p, n| floor(p, n).then(|| expected(p.x)));
    assert_close("wall profile", deviation, 0.01, 0.06, 0.005);
}

/// The same way round: a wall above a floor of uniform radiance, by the polygon formula.
#[test]
fn a_wall_over_a_lit_floor() {
    let (half, irradiance, rho) = (4.0, 2.0f32, 0.5f32);
    let mut b = Builder::default();
    let grey = b.material(diffuse(rho));
    b.floor(grey, 0.0, half as f32);
    b.quad(grey, vec3(-1.0, 0.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    b.light(Light::Directional { direction: Vec3::NEG_Y, irradiance: tinted(irradiance) });
    let settings = Settings { surface_cells: Some(1 << 16), ..small(96) };
    let picture = picture(&b.build(), &look(dvec3(0.0, 1.2, 3.0), dvec3(0.0, 0.9, 0.0), 40.0), &settings);
    let corners = parallelogram(dvec3(-half, 0.0, 0.0), DVec3::X * 2.0 * half, DVec3::Z * half);
    let wall = |p: DVec3, n: DVec3| n.z > 0.9 && p.y > 0.02;
    let radiance = f64::from(rho * irradiance) / PI;
    let deviation =
        against(&picture, "irradiance", TINT, |p, n| wall(p, n).then(|| radiance * polygon(p, n, &corners)));
    assert_close("half a lit plane", deviation, 0.015, 0.06, 0.005);
}

/// Between two plates, lit by a point: E₁ on the upper one is the integral of what the lower one reflects.
#[test]
fn parallel_plates_after_one_bounce() {
    let (gap, half, rho) = (1.0, 3.0, 0.5f32);
    let light = dvec3(0.2, 0.4, -0.1);
    let mut b = Builder::default();
    let grey = b.material(diffuse(rho));
    b.floor(grey, 0.0, half as f32);
    b.ceiling(grey, gap as f32, half as f32);
    b.light(Light::Point { position: light.as_vec3(), intensity: tinted(2.0) });
    let mut settings = Settings { surface_cells: Some(1 << 17), ..small(64) };
    // Transport is tested here, not interpolation: the peak above the light is narrow against the plates' distance.
    settings.cache.accuracy = 0.1;
    let picture = picture(&b.build(), &look(dvec3(0.0, 0.5, 2.0), dvec3(0.0, 0.55, 0.0), 60.0), &settings);
    let bounce = |p: DVec3, n: DVec3| {
        let (height, m) = if n.y < 0.0 { (0.0, DVec3::Y) } else { (gap, DVec3::NEG_Y) };
        let reflected = |q| 2.0 * point_light(q, m, light) * f64::from(rho) / PI;
        over_square(height, half, 120, |q| reflected(q) * element(p, n, q, m))
    };
    let near = |p: DVec3| inside(p, 2.0);
    let deviation = against(&picture, "irradiance", TINT, |p, n| near(p).then(|| bounce(p, n)));
    assert_close("parallel plates", deviation, 0.005, 0.05, 0.003);
}

/// Render passes and compute see the same: each test above runs the device's own choice, this one both.
#[test]
fn both_ways_to_capture_agree_with_the_closed_forms() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 1.0, 48, Facing::In);
    b.light(Light::Point { position: vec3(0.0, -0.5, 0.0), intensity: tinted(3.0) });
    let sphere = b.build();
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 1.0);
    b.background(Background::Constant(tinted(3.0)));
    let floor = b.build();
    let box_ = cornell();
    let boxes = each_capture(small(96)).map(|settings| {
        let settings = Settings { surface_cells: Some(1 << 16), ..settings };
        let what = format!("{:?}", settings.cache.capture);
        let inner = picture(&sphere, &look(dvec3(0.0, 0.3, 0.8), dvec3(0.0, 0.0, -1.0), 90.0), &settings);
        let one_bounce = against(&inner, "irradiance", TINT, |_, _| Some(0.8 * 3.0));
        assert_close(&format!("{what}: integrating sphere"), one_bounce, 0.005, 0.02, 0.005);
        let open = picture(&floor, &look(dvec3(0.0, 2.0, 1.5), DVec3::ZERO, 40.0), &settings);
        let sky = against(&open, "irradiance_direct", TINT, |_, _| Some(3.0 * PI));
        assert_close(&format!("{what}: sky over a floor"), sky, 1e-5, 1e-4, 1e-5);
        picture(&box_, &box_.cameras[0], &settings)
    });
    let indirect = difference(&boxes[0], &boxes[1], "irradiance");
    let energy = indirect.energy.unwrap() - 1.0;
    eprintln!("Cornell box, one way against the other: {:.3} %, energy {:+.3} %", indirect.mae * 1e2, energy * 1e2);
    assert!(indirect.mae < 0.01 && energy.abs() < 0.003, "{indirect:?}");
}

/// More clusters than a face lists at once: what is seen so far is kept while the list is used again.
#[test]
fn both_ways_to_capture_agree_on_many_triangles() {
    let scene = tessellated(&cornell(), 6);
    assert!(scene.triangles.len() > 63 * 32 * 64, "{} triangles fill one list only", scene.triangles.len());
    if !holds(&scene) {
        return;
    }
    let [render, compute] = each_capture(small(12)).map(|settings| picture(&scene, &scene.cameras[0], &settings));
    let off = difference(&render, &compute, "irradiance");
    let energy = off.energy.unwrap() - 1.0;
    eprintln!(
        "one way against the other: {:.3} %, p99 {:.3} %, energy {:+.3} %",
        off.mae * 1e2,
        off.p99 * 1e2,
        energy * 1e2
    );
    assert!(off.mae < 0.01 && off.p99 < 0.05 && energy.abs() < 0.003, "{off:?}");
}

//! The renderer on the device against closed forms, and against itself under changes that must not change the light.

#![allow(clippy::unwrap_used)] // the helpers belong to tests, which the lint cannot see

mod common;

use common::build::{Facing, diffuse, emitter, tessellated};
use common::closed_forms::{crosses_box, element, over_square, parallelogram, point_light, polygon, spot_factor};
use common::{Builder, TINT, against, assert_close, each_capture, inside, look, look_parallel, picture, small, tinted};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::image::Picture;
use hemicube::methods::captures::CaptureMode;
use hemicube::passes::integrate::Radius;
use hemicube::renderer::Settings;
use hemicube::scene::{Background, Camera, EnvironmentMap, Light, Material, Scene, cornell, load_from_slice};
use std::f64::consts::PI;

// Sky.

#[test]
fn constant_sky_over_a_floor() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 1.0);
    b.background(Background::Constant(tinted(3.0)));
    let picture = picture(&b.build(), &look(dvec3(0.0, 2.0, 1.5), DVec3::ZERO, 40.0), &small(64));
    let direct = against(&picture, "irradiance_direct", TINT, |_, _| Some(3.0 * PI));
    assert_close("E = πL", direct, 1e-5, 1e-4, 1e-5);
    let sees_itself = picture.rgb("irradiance").unwrap().iter().flat_map(|c| c.iter()).any(|e| *e != 0.0);
    assert!(!sees_itself, "a plane gives itself no light");
}

/// A plate turned by β under a sky that is L above the horizon and 0 below.
#[test]
fn half_a_sky_on_a_tilted_plate() {
    for degrees in [0.0f32, 30.0, 60.0, 90.0] {
        let beta = degrees.to_radians();
        let normal = vec3(beta.sin(), beta.cos(), 0.0);
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        let along = vec3(beta.cos(), -beta.sin(), 0.0);
        b.quad(grey, -0.5 * along + vec3(0.0, 0.0, 0.5), along, Vec3::NEG_Z);
        let rgb = (0..64 * 64).map(|i| tinted(if i < 64 * 32 { 1.0 } else { 0.0 }).to_array()).collect();
        b.background(Background::Map(EnvironmentMap { width: 64, height: 64, rgb }));
        let eye = 2.0 * normal.as_dvec3() + dvec3(0.0, 0.0, 0.4);
        let picture = picture(&b.build(), &look(eye, DVec3::ZERO, 20.0), &small(48));
        let expected = PI * (1.0 + f64::from(beta.cos())) / 2.0;
        let deviation = against(&picture, "irradiance_direct", TINT, |_, _| Some(expected));
        // The map's horizon is a ramp of one texel, as bright on one side as it is dark on the other.
        assert_close(&format!("half sky at {degrees}°"), deviation, 0.002, 0.005, 0.002);
    }
}

#[test]
fn a_sky_linear_in_one_axis() {
    let (l0, l1) = (1.0f32, 0.8f32);
    let (width, height) = (256, 128);
    let texel = |i: u32| {
        let uv = [((i % width) as f32 + 0.5) / width as f32, ((i / width) as f32 + 0.5) / height as f32];
        tinted(l0 + l1 * EnvironmentMap::uv_to_direction(uv).x).to_array()
    };
    let map = EnvironmentMap { width, height, rgb: (0..width * height).map(texel).collect() };
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    // A ball sees no part of itself, and has every normal.
    b.sphere(grey, Vec3::ZERO, 1.0, 48, Facing::Out);
    b.background(Background::Map(map));
    let scene = b.build();
    for eye in [dvec3(3.0, 1.0, 2.0), dvec3(-3.0, -1.0, 1.0)] {
        let mut settings = small(64);
        // The rotation gradient is linear in the angle and overshoots by 1 − cos of it: records of near normals only.
        settings.cache.normal_limit = 0.05;
        let picture = picture(&scene, &look(eye, DVec3::ZERO, 35.0), &settings);
        let expected = |n: DVec3| PI * f64::from(l0) + 2.0 * PI / 3.0 * f64::from(l1) * n.x;
        let deviation = against(&picture, "irradiance_direct", TINT, |_, n| Some(expected(n)));
        assert_close("πL₀ + (2π/3)L₁n", deviation, 0.003, 0.02, 0.003);
    }
}

// Area lights.

/// The rectangle of the tables, turned so that up is y: x ∈ [.3, 1.5], z ∈ [−.7, .9], y = 1, facing down.
fn under_the_rectangle(material: Material) -> (Scene, [DVec3; 4]) {
    let mut b = Builder::default();
    let (grey, lamp) = (b.material(diffuse(0.5)), b.material(material));
    b.floor(grey, 0.0, 2.0);
    b.quad(lamp, vec3(0.3, 1.0, -0.7), Vec3::X * 1.2, Vec3::Z * 1.6);
    (b.build(), parallelogram(dvec3(0.3, 1.0, -0.7), DVec3::X * 1.2, DVec3::Z * 1.6))
}

/// From below the lamp's plane; the middle pixels lie about the origin.
fn before_the_rectangle() -> Camera {
    look(dvec3(-1.2, 0.9, 0.0), DVec3::ZERO, 80.0)
}

#[test]
fn rectangle_light_is_exact_where_nothing_hides_it() {
    let (scene, corners) = under_the_rectangle(emitter(tinted(1.0)));
    assert!((polygon(DVec3::ZERO, DVec3::Y, &corners) - 0.552554).abs() < 1e-6);
    for samples in [1, 64] {
        let mut settings = Settings { bounces: 0, ..small(64) };
        settings.lights.area_samples = samples;
        let picture = picture(&scene, &before_the_rectangle(), &settings);
        let deviation = against(&picture, "irradiance_direct", TINT, |p, n| Some(polygon(p, n, &corners)));
        assert_close(&format!("rectangle, {samples} samples"), deviation, 1e-5, 1e-4, 1e-5);
    }
}

/// The part of a polygon for which `height` is positive.
fn cut(corners: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (ha, hb) = (height(*a), height(b));
        if ha > 0.0 {
            kept.push(*a);
        }
        if (ha > 0.0) != (hb > 0.0) {
            kept.push(a.lerp(b, ha / (ha - hb)));
        }
    }
    kept
}

/// A wide plate between lamp and floor whose edge cuts the lamp in two: what a point sees of it is a polygon again.
#[test]
fn a_penumbra_converges_with_the_samples_of_the_light() {
    let (height, edge) = (0.4, 0.3);
    // Aslant to the rows of the samples, which would pass it all at once.
    let across = dvec3(0.4f64.cos(), 0.0, 0.4f64.sin());
    let along = dvec3(-across.z, 0.0, across.x);
    let mut b = Builder::default();
    let (grey, lamp) = (b.material(diffuse(0.5)), b.material(emitter(tinted(1.0))));
    b.floor(grey, 0.0, 2.0);
    b.quad(lamp, vec3(0.3, 1.0, -0.7), Vec3::X * 1.2, Vec3::Z * 1.6);
    let corner = edge * across + height * DVec3::Y - 4.0 * along;
    b.quad(grey, corner.as_vec3(), 8.0 * across.as_vec3(), 8.0 * along.as_vec3());
    let (scene, corners) = (b.build(), parallelogram(dvec3(0.3, 1.0, -0.7), DVec3::X * 1.2, DVec3::Z * 1.6));
    // Seen where the sight line passes the plate's height before its edge: a half-space of the lamp's points.
    let seen = |p: DVec3| cut(&corners, |q| edge - across.dot(p + (q - p) * (height / q.y)));
    let errors = [16, 64, 256, 1024].map(|samples| {
        let mut settings = Settings { bounces: 0, ..small(64) };
        settings.lights.area_samples = samples;
        let picture = picture(&scene, &before_the_rectangle(), &settings);
        let floor = |p: DVec3| p.y.abs() < 1e-4;
        let expected = |p, n| floor(p).then(|| if seen(p).is_empty() { 0.0 } else { polygon(p, n, &seen(p)) });
        let deviation = against(&picture, "irradiance_direct", TINT, expected);
        let spacing = 1.0 / f64::from(samples).sqrt();
        assert_close(&format!("penumbra, {samples} samples"), deviation, 0.5 * spacing, f64::INFINITY, 0.03);
        deviation.mean
    });
    // Along the shadow's edge √n of n even points are in doubt: n^−¾; random points' error falls as n^−½.
    let order = (errors[0] / errors[3]).log(64.0);
    eprintln!("order of convergence: {order:.2}");
    assert!(order > 0.7, "{errors:?} falls as n^−{order}");
}

#[test]
fn a_one_sided_emitter_is_dark_behind_and_a_double_sided_one_is_not() {
    for double_sided in [false, true] {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        let lamp = b.material(Material { double_sided, ..emitter(tinted(2.0)) });
        b.floor(grey, 0.0, 1.0);
        // Faces up, away from the floor.
        b.floor(lamp, 0.5, 0.25);
        let corners = parallelogram(dvec3(-0.25, 0.5, -0.25), DVec3::X * 0.5, DVec3::Z * 0.5);
        let mut settings = small(48);
        settings.lights.area_samples = 512;
        let picture = picture(&b.build(), &look(dvec3(0.0, 0.3, 1.2), DVec3::ZERO, 60.0), &settings);
        if double_sided {
            let direct = against(&picture, "irradiance_direct", TINT, |p, n| Some(2.0 * polygon(p, n, &corners)));
            assert_close("double-sided emitter's back", direct, 0.01, 0.1, 0.01);
        } else {
            for layer in ["irradiance_direct", "irradiance", "emission", ""] {
                assert!(picture.rgb(layer).unwrap().iter().all(|c| c.iter().all(|v| *v == 0.0)), "light in {layer:?}");
            }
        }
    }
}

// Punctual lights.

const BOX: [DVec3; 2] = [dvec3(-0.3, 0.3, -0.2), dvec3(0.2, 0.7, 0.3)];

fn floor_and_box(light: Light) -> Scene {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 2.0);
    b.cuboid(grey, BOX[0].as_vec3(), BOX[1].as_vec3(), Facing::Out);
    b.light(light);
    b.build()
}

/// Direct light on the floor: `lit` where the segment to the light passes the box, 0 where it meets it, nothing said
/// within `margin` of the shadow's edge.
fn shadowed(
    picture: &Picture,
    margin: f64,
    to_light: impl Fn(DVec3) -> DVec3,
    lit: impl Fn(DVec3, DVec3) -> f64,
) -> [common::Deviation; 2] {
    let floor = |p: DVec3| p.y.abs() < 1e-4;
    let meets = |p: DVec3, margin| crosses_box(p, to_light(p), BOX[0], BOX[1], margin);
    let light = against(picture, "irradiance_direct", TINT, |p, n| (floor(p) && !meets(p, margin)).then(|| lit(p, n)));
    // Compared with 0 there is no relative error: one is added on both sides by way of the light unshadowed.
    let dark = {
        let (p, e) = (picture.xyz("P").unwrap(), picture.rgb("irradiance_direct").unwrap());
        let at = |i: usize| DVec3::from(p.map(|plane| f64::from(plane[i])));
        let shaded: Vec<usize> = (0..p[0].len()).filter(|i| floor(at(*i)) && meets(at(*i), -margin)).collect();
        assert!(shaded.len() > 20, "{} pixels in shadow", shaded.len());
        let sum: f64 = shaded.iter().map(|i| f64::from(e[0][*i] + e[1][*i] + e[2][*i])).sum();
        common::Deviation { mean: sum, max: sum, energy: 1.0, pixels: shaded.len() }
    };
    [light, dark]
}

fn above() -> Camera {
    look(dvec3(0.0, 2.5, 2.5), dvec3(0.0, 0.0, 0.0), 45.0)
}

#[test]
fn a_point_light_and_its_shadow() {
    let light = dvec3(0.3, 1.6, -0.2);
    let scene = floor_and_box(Light::Point { position: light.as_vec3(), intensity: tinted(4.0) });
    let picture = picture(&scene, &above(), &Settings { bounces: 0, ..small(96) });
    let [lit, dark] = shadowed(&picture, 0.01, |_| light, |p, n| 4.0 * point_light(p, n, light));
    assert_close("I·cosθ/d²", lit, 1e-4, 1e-3, 1e-4);
    assert_close("a point light's shadow", dark, 0.0, 0.0, 0.0);
}

#[test]
fn a_sun_and_its_shadow() {
    let direction = dvec3(0.4, -1.0, 0.3).normalize();
    let scene = floor_and_box(Light::Directional { direction: direction.as_vec3(), irradiance: tinted(5.0) });
    let picture = picture(&scene, &above(), &Settings { bounces: 0, ..small(96) });
    let [lit, dark] = shadowed(&picture, 0.01, |p| p - 10.0 * direction, |_, n| 5.0 * n.dot(-direction));
    assert_close("E·cosθ", lit, 1e-4, 1e-3, 1e-4);
    assert_close("a sun's shadow", dark, 0.0, 0.0, 0.0);
}

#[test]
fn a_spot_its_cone_and_its_shadow() {
    for (inner, outer) in [(15.0f64, 30.0), (20.0, 80.0)] {
        let (light, axis) = (dvec3(0.3, 1.6, -0.2), dvec3(-0.1, -1.0, 0.1).normalize());
        let [cos_inner, cos_outer] = [inner, outer].map(|degrees: f64| degrees.to_radians().cos());
        let scene = floor_and_box(Light::Spot {
            position: light.as_vec3(),
            direction: axis.as_vec3(),
            intensity: tinted(4.0),
            cos_inner: cos_inner as f32,
            cos_outer: cos_outer as f32,
        });
        let picture = picture(&scene, &above(), &Settings { bounces: 0, ..small(96) });
        let lit = |p: DVec3, n| {
            let cosine = (p - light).normalize().dot(axis);
            4.0 * point_light(p, n, light) * spot_factor(cosine, cos_inner, cos_outer)
        };
        let [lit, dark] = shadowed(&picture, 0.01, |_| light, lit);
        assert_close(&format!("spot {inner}°–{outer}°"), lit, 1e-3, 5e-3, 1e-3);
        assert_close("a spot's shadow", dark, 0.0, 0.0, 0.0);
    }
}

// One bounce.

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

// Extremes.

/// A dark room with walls without thickness, and what shines on them from outside.
fn dark_room(outside: &str) -> (Scene, Camera) {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.8));
    let camera = look(dvec3(0.8, 0.5, 0.9), dvec3(-0.5, -0.4, -0.5), 80.0);
    if outside == "next room" {
        // One wall between this room and one with a light.
        b.cuboid(grey, vec3(-1.0, -1.0, -1.0), vec3(3.0, 1.0, 1.0), Facing::In);
        b.quad(grey, vec3(1.0, -1.0, 1.0), Vec3::NEG_Z * 2.0, Vec3::Y * 2.0);
        b.light(Light::Point { position: vec3(2.0, 0.2, 0.1), intensity: Vec3::splat(1e6) });
        return (b.build(), look(dvec3(-0.8, 0.4, 0.8), dvec3(1.0, -0.3, -0.2), 80.0));
    }
    b.cuboid(grey, Vec3::splat(-1.0), Vec3::splat(1.0), Facing::In);
    match outside {
        "sun" => {
            let direction = vec3(0.5, -1.0, 0.3).normalize();
            b.light(Light::Directional { direction, irradiance: Vec3::splat(1e6) });
        }
        // The same wall twice, once for each of two rooms.
        "room beside" => {
            b.cuboid(grey, vec3(1.0, -1.0, -1.0), vec3(3.0, 1.0, 1.0), Facing::In);
            b.light(Light::Point { position: vec3(2.0, 0.2, 0.1), intensity: Vec3::splat(1e6) });
            return (b.build(), look(dvec3(-0.8, 0.4, 0.8), dvec3(1.0, -0.3, -0.2), 80.0));
        }
        "lamp" => {
            let lamp = b.material(emitter(Vec3::splat(1e6)));
            b.ceiling(lamp, 1.5, 1.0);
        }
        _ => b.background(Background::Constant(Vec3::splat(1e6))),
    }
    (b.build(), camera)
}

/// Not a single bit of 10⁶ outside: neither by direct light nor by what the surfaces of the room, none of which reaches out
/// of it, send to each other.
#[test]
fn no_light_gets_through_a_thin_wall() {
    for outside in ["sun", "lamp", "sky", "room beside"] {
        let (scene, camera) = dark_room(outside);
        for mut settings in each_capture(small(96)) {
            if outside == "room beside" && settings.cache.capture == CaptureMode::Hemicube {
                // The texels below are measured here, where records are as dense as walls are near.
                settings.cache.radius = Radius::Harmonic;
            }
            let picture = picture(&scene, &camera, &settings);
            for layer in ["irradiance_direct", "irradiance", ""] {
                let light = picture.rgb(layer).unwrap();
                let largest = light.iter().flat_map(|c| c.iter()).fold(0.0f32, |a, b| a.max(*b));
                // Along the edge that two floors share, render passes interpolate the wall's depth and the far floor's
                // to the same number: a texel may see the far one.
                let rounding = outside == "room beside" && settings.cache.capture == CaptureMode::Hemicube;
                let limit = if rounding && layer != "irradiance_direct" { 1e6 * 1e-3 } else { 0.0 };
                assert!(largest <= limit, "{outside}: {largest} of 10⁶ in {layer:?}");
            }
        }
    }
}

/// Where one floor goes on under the wall, direct light ends at the wall exactly. A surface cell that lies on both sides of
/// it has one radiance for both, though, and shines into the dark room: below a hundredth of what is outside at cells of a
/// twentieth of the room.
#[test]
fn next_to_no_light_gets_along_a_floor_under_a_thin_wall() {
    let (scene, camera) = dark_room("next room");
    let picture = picture(&scene, &camera, &small(96));
    let direct = picture.rgb("irradiance_direct").unwrap()[0].iter().filter(|e| **e != 0.0).count();
    assert_eq!(direct, 0, "pixels with direct light");
    let light = picture.rgb("irradiance").unwrap()[0];
    let mean = light.iter().map(|e| f64::from(*e)).sum::<f64>() / light.len() as f64;
    eprintln!("next room: {:.4} % of what is outside", mean / 1e6 * 100.0);
    assert!(mean / 1e6 < 0.005, "{mean} of 10⁶");
}

/// The other side of the wall is lit everywhere.
#[test]
fn the_lit_side_of_a_thin_wall_is_lit() {
    let (scene, _) = dark_room("next room");
    let lit = picture(&scene, &look(dvec3(2.8, 0.4, 0.8), dvec3(1.0, -0.3, -0.2), 80.0), &small(48));
    assert!(lit.rgb("irradiance").unwrap()[0].iter().all(|e| *e > 1e4));
}

// Changes that must not change the light.

/// Every length times `scale`.
fn scaled(scene: &Scene, camera: &Camera, scale: f32) -> (Scene, Camera) {
    let (mut scene, mut camera) = (scene.clone(), camera.clone());
    scene.positions.iter_mut().for_each(|p| *p *= scale);
    for light in &mut scene.lights {
        if let Light::Point { position, intensity } | Light::Spot { position, intensity, .. } = light {
            *position *= scale;
            *intensity *= scale * scale;
        }
    }
    camera.camera_to_world.w_axis *= dvec3(1.0, 1.0, 1.0).extend(1.0 / f64::from(scale)) * f64::from(scale);
    (scene, camera)
}

#[test]
fn the_size_of_the_world_changes_no_bit() {
    let mut scene = cornell();
    scene.lights.push(Light::Point { position: vec3(0.1, 0.3, 0.2), intensity: vec3(0.1, 0.2, 0.3) });
    let camera = scene.cameras[0].clone();
    let reference = picture(&scene, &camera, &small(64));
    for power in [10, -10] {
        let scale = 2f32.powi(power);
        let (scene, camera) = scaled(&scene, &camera, scale);
        let mut scaled = picture(&scene, &camera, &small(64));
        for channel in ["P.X", "P.Y", "P.Z", "Z"] {
            scaled.channels.get_mut(channel).unwrap().iter_mut().for_each(|v| *v /= scale);
        }
        common::assert_same_bits(&scaled, &reference, &format!("world × 2^{power}"));
    }
}

#[test]
fn the_strength_of_the_light_scales_the_image_exactly() {
    let scene = cornell();
    let camera = scene.cameras[0].clone();
    let reference = picture(&scene, &camera, &small(64));
    for power in [12, -12] {
        let scale = 2f32.powi(power);
        let mut brighter = scene.clone();
        brighter.materials.iter_mut().for_each(|m| m.emission *= scale);
        let mut scaled = picture(&brighter, &camera, &small(64));
        let light = ["R", "G", "B", "direct.", "indirect.", "irradiance", "emission."];
        for (name, values) in &mut scaled.channels {
            if light.iter().any(|l| name == l || (l.len() > 1 && name.starts_with(l))) {
                values.iter_mut().for_each(|v| *v /= scale);
            }
        }
        common::assert_same_bits(&scaled, &reference, &format!("emission × 2^{power}"));
    }
}

/// The Cornell box's file with its root nodes below one more.
fn cornell_below(node: serde_json::Value) -> Scene {
    let mut file: serde_json::Value = serde_json::from_slice(include_bytes!("../assets/cornell.gltf")).unwrap();
    let scene = &mut file["scenes"][0]["nodes"];
    let roots = scene.take();
    let nodes = file["nodes"].as_array_mut().unwrap();
    let mut top = node;
    top["children"] = roots;
    nodes.push(top);
    let index = nodes.len() - 1;
    file["scenes"][0]["nodes"] = serde_json::json!([index]);
    let nothing = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    load_from_slice("below.gltf", &serde_json::to_vec(&file).unwrap(), &nothing, Default::default()).unwrap()
}

fn difference(a: &Picture, b: &Picture, layer: &str) -> hemicube::image::metrics::Metrics {
    let mask = hemicube::image::metrics::mask(b.scalar("mask").unwrap());
    let (a, b) = (a.layer(layer).unwrap(), b.layer(layer).unwrap());
    hemicube::image::metrics::measure(&a, &b, 96, Some(&mask))
}

#[test]
fn a_negative_scale_mirrors_the_image() {
    let scene = cornell();
    let reference = picture(&scene, &scene.cameras[0], &small(96));
    let mirrored = cornell_below(serde_json::json!({"scale": [-1.0, 1.0, 1.0]}));
    let mut camera = scene.cameras[0].clone();
    camera.camera_to_world.w_axis.x *= -1.0;
    let mut flipped = picture(&mirrored, &camera, &small(96));
    flipped.channels.values_mut().for_each(|plane| plane.chunks_mut(96).for_each(<[f32]>::reverse));
    let direct = difference(&flipped, &reference, "irradiance_direct");
    let indirect = difference(&flipped, &reference, "irradiance");
    eprintln!("mirrored: direct {:.3} %, indirect {:.3} %", direct.mae * 100.0, indirect.mae * 100.0);
    // Shadow edges move by a texel; hemicubes are turned otherwise.
    assert!(direct.mae < 0.01 && (direct.energy.unwrap() - 1.0).abs() < 0.005, "{direct:?}");
    assert!(indirect.mae < 0.03 && (indirect.energy.unwrap() - 1.0).abs() < 0.01, "{indirect:?}");
}

#[test]
fn far_from_zero_the_light_stays() {
    let scene = cornell();
    let reference = picture(&scene, &scene.cameras[0], &small(96));
    let far = cornell_below(serde_json::json!({"translation": [1e5, 0.0, -1e5]}));
    assert!(far.origin.length() > 1e5);
    let moved = picture(&far, &far.cameras[0], &small(96));
    let direct = difference(&moved, &reference, "irradiance_direct");
    let indirect = difference(&moved, &reference, "irradiance");
    eprintln!("far: direct {:.3} %, indirect {:.3} %", direct.mae * 100.0, indirect.mae * 100.0);
    assert!(direct.mae < 0.01 && (direct.energy.unwrap() - 1.0).abs() < 0.005, "{direct:?}");
    assert!(indirect.mae < 0.03 && (indirect.energy.unwrap() - 1.0).abs() < 0.01, "{indirect:?}");
    let (a, b) = (moved.xyz("P").unwrap(), reference.xyz("P").unwrap());
    let ulp = 2f64.powi(-7);
    let close = |axis: usize, offset: f32| {
        a[axis]
            .iter()
            .zip(b[axis])
            .all(|(a, b)| *a == 0.0 || (f64::from(*a) - f64::from(offset) - f64::from(*b)).abs() <= ulp)
    };
    assert!(close(0, 1e5) && close(1, 0.0) && close(2, -1e5), "positions are the file's");
}

//! Rectangular lights, whole and partly hidden.

use crate::common::build::{diffuse, emitter};
use crate::common::closed_forms::{parallelogram, polygon};
use crate::common::{Builder, TINT, against, assert_close, look, picture, small, tinted};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Material, Scene};

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
        assert_close(&format!("penumbra, {samples} samples"), deviation, 0.14 * spacing, f64::INFINITY, 0.03);
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

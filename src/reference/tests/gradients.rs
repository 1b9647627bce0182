//! Gradients of records against central differences of irradiance, and the interpolation's own promises.

use super::scenes::*;
use crate::reference::ward::{Cache, Gradients, Grid, Measurement, Settings, Weight};
use crate::reference::{SurfacePoint, Tracer};
use crate::scene::{Background, Light, Scene};
use glam::{DVec3, Vec3, dvec3, vec3};

fn surface(position: DVec3, normal: DVec3) -> SurfacePoint {
    SurfacePoint {
        position,
        ray_origin: position,
        geometric: normal,
        normal,
        albedo: DVec3::ONE,
        emission: DVec3::ZERO,
        emitter: false,
        triangle: 0,
    }
}

/// A wall, a block and a ceiling under a sun: indirect light with occlusion and slope.
fn yard() -> Scene {
    let sun = Light::Directional { direction: vec3(0.5, 0.3, -0.8).normalize(), irradiance: Vec3::ONE };
    let mut scene = Scene { lights: vec![sun], ..Scene::default() };
    add(&mut scene, diffuse(0.8), &box_faces(vec3(-3.0, -3.0, 0.0), vec3(3.0, 3.0, 4.0))[..5].concat());
    add(&mut scene, diffuse(0.5), &box_faces(vec3(-0.4, 0.6, 0.8), vec3(0.9, 1.2, 1.9)).concat());
    scene
}

fn mean(tracer: &Tracer, at: SurfacePoint, rays: u32, runs: u64) -> Measurement {
    let grid = Grid::new(rays);
    let mut sum = Measurement::default();
    for seed in 0..runs {
        let m = grid.measure(tracer, &at, 1, seed, 0).0;
        sum.irradiance += m.irradiance / runs as f64;
        sum.inverse_distance += m.inverse_distance / runs as f64;
        for c in 0..3 {
            sum.rotation[c] += m.rotation[c] / runs as f64;
            sum.translation[c] += m.translation[c] / runs as f64;
        }
    }
    sum
}

#[test]
fn both_gradients_match_central_differences() {
    let scene = yard();
    let tracer = Tracer::new(&scene);
    let (position, normal) = (dvec3(0.4, -0.5, 0.2), dvec3(0.1, 0.2, 1.0).normalize());
    let m = mean(&tracer, surface(position, normal), 4096, 40);
    let e = |p, n| mean(&tracer, surface(p, n), 16384, 20).irradiance.x;
    for axis in [DVec3::X, DVec3::Y] {
        let tangent = (axis - normal * axis.dot(normal)).normalize();
        let h = 0.05;
        let slope = (e(position + tangent * h, normal) - e(position - tangent * h, normal)) / (2.0 * h);
        let ours = m.translation[0].dot(tangent);
        println!("translation along {tangent:.2}: {ours:.5}, differences {slope:.5}");
        assert!((ours - slope).abs() < 0.1 * m.translation[0].length(), "{ours} {slope}");

        let turned = |s: f64| (normal + tangent * s * h).normalize();
        let slope = e(position, turned(1.0)) - e(position, turned(-1.0));
        let ours = normal.cross(turned(1.0)).dot(m.rotation[0]) - normal.cross(turned(-1.0)).dot(m.rotation[0]);
        println!("rotation towards {tangent:.2}: {ours:.5}, differences {slope:.5}");
        assert!((ours - slope).abs() < 0.05 * 2.0 * h * m.rotation[0].length(), "{ours} {slope}");
    }
}

#[test]
fn gradients_vanish_in_uniform_light() {
    // Every direction brings the same: a closed sphere with a light at its centre, measured at the centre.
    let mut scene = Scene { lights: vec![point_light(Vec3::ZERO)], ..Scene::default() };
    add(&mut scene, diffuse(0.5), &sphere(DVec3::ZERO, 2.0, 48));
    let tracer = Tracer::new(&scene);
    let m = mean(&tracer, surface(DVec3::ZERO, DVec3::Z), 1024, 4);
    assert!((m.irradiance.x - 0.125).abs() < 1e-3 && (m.inverse_distance - 0.5).abs() < 1e-3, "{m:?}");
    assert!(m.translation[0].length() < 1e-3 && m.rotation[0].length() < 1e-3, "{m:?}");
}

#[test]
fn harmonic_mean_of_a_ceiling_is_one_and_a_half_heights() {
    let far = 3000.0;
    let mut scene = Scene { background: Background::Constant(Vec3::ONE), ..Scene::default() };
    add(
        &mut scene,
        diffuse(0.5),
        &quad([vec3(-far, -far, 2.0), vec3(far, -far, 2.0), vec3(far, far, 2.0), vec3(-far, far, 2.0)]),
    );
    let m = mean(&Tracer::new(&scene), surface(DVec3::ZERO, DVec3::Z), 4096, 4);
    assert!((1.0 / m.inverse_distance - 3.0).abs() < 0.01, "{}", 1.0 / m.inverse_distance);
}

#[test]
fn one_record_returns_its_own_value_and_its_slope() {
    for weight in [Weight::Ward, Weight::Bounded] {
        let settings = Settings { weight, max_radius: 1e9, gradient_limit: false, ..Settings::default() };
        let mut cache = Cache::new(settings, DVec3::ZERO, 10.0);
        let m = Measurement {
            irradiance: dvec3(1.0, 2.0, 3.0),
            translation: [DVec3::X, DVec3::ZERO, DVec3::Y],
            rotation: [DVec3::Y, DVec3::ZERO, DVec3::ZERO],
            inverse_distance: 0.1,
        };
        cache.insert(DVec3::ONE, DVec3::Z, m, 0, 0.001);
        let (e, n) = cache.irradiance(DVec3::ONE, DVec3::Z).unwrap();
        assert!((e - m.irradiance).length() < 1e-12 && n == 1);
        let (e, _) = cache.irradiance(DVec3::ONE + DVec3::X * 0.1, DVec3::Z).unwrap();
        assert!((e - dvec3(1.1, 2.0, 3.0)).length() < 1e-12);
        let normal = dvec3(0.1, 0.0, 1.0).normalize();
        let (e, _) = cache.irradiance(DVec3::ONE, normal).unwrap();
        assert!((e.x - 1.0 - normal.x).abs() < 1e-12, "z × x turns along +y: {e}");
        assert!(cache.irradiance(DVec3::ONE, DVec3::NEG_Z).is_none());
        assert!(cache.irradiance(DVec3::ONE + DVec3::X * 2.1, DVec3::Z).is_none());
        assert!(cache.irradiance(DVec3::ONE - DVec3::Z, DVec3::Z).is_none(), "the record is in front");
    }
    assert_eq!(Gradients::default(), Gradients::Both);
}

#[test]
fn nothing_leaks_into_the_cache_through_a_thin_wall() {
    // A room without light inside, 1e6 outside; the camera sees the room's inside through a wall that is not there for it.
    let mut scene = Scene { background: Background::Constant(Vec3::splat(1e6)), ..Scene::default() };
    add(&mut scene, diffuse(0.9), &box_faces(vec3(-1.0, -1.0, -1.0), vec3(1.0, 1.0, 1.0)).concat());
    add(
        &mut scene,
        diffuse(0.9),
        &quad([vec3(-9.0, -9.0, -1.5), vec3(9.0, -9.0, -1.5), vec3(9.0, 9.0, -1.5), vec3(-9.0, 9.0, -1.5)]),
    );
    let tracer = Tracer::new(&scene);
    let grid = Grid::new(256);
    let mut cache = Cache::new(Settings { max_radius: 1e9, ..Settings::default() }, DVec3::ZERO, 10.0);
    for (i, (z, normal)) in [(-1.01, DVec3::NEG_Z), (-0.99, DVec3::Z)].into_iter().enumerate() {
        let at = surface(dvec3(0.2, 0.1, z), normal);
        let (m, _) = grid.measure(&tracer, &at, 3, 1, i as u64);
        cache.insert(at.position, at.normal, m, i as u32, 0.001);
    }
    assert_eq!(cache.records[1].measured.irradiance, DVec3::ZERO);
    assert!(cache.records[0].measured.irradiance.x > 1e3);
    for x in [0.1, 0.2, 0.3] {
        let (inside, _) = cache.irradiance(dvec3(x, 0.1, -0.99), DVec3::Z).unwrap();
        assert_eq!(inside, DVec3::ZERO);
        assert!(cache.irradiance(dvec3(x, 0.1, -1.01), DVec3::NEG_Z).unwrap().0.x > 1e3);
    }
}

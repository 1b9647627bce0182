//! Volumes in closed form: a furnace, and a plane in parallel light.

use super::{baked_in, settings};
use crate::common::build::{Builder, diffuse};
use glam::{DVec3, UVec3, Vec3, dvec3, vec3};
use hemicube::math::sh;
use hemicube::methods::volume::{Gradients, Places};
use hemicube::scene::{Background, Light};
use hemicube::volume::reader::ReadSettings;
use hemicube::volume::{Interpolation, Reader, State};
use std::f64::consts::PI;

const ALL: [Interpolation; 4] =
    [Interpolation::Trilinear, Interpolation::InverseDistance, Interpolation::Gradients, Interpolation::Hermite];

/// Radiance of the sky.
const SKY: DVec3 = dvec3(1.0, 2.0, 3.0);

/// Points all over the box from `low` to `high`, by a sequence of golden ratios (Roberts 2018).
fn points(low: DVec3, high: DVec3) -> impl Iterator<Item = DVec3> {
    let steps = dvec3(0.819_172_513, 0.671_043_607, 0.549_700_478);
    (1..=100).map(move |i| low + (steps * f64::from(i) - (steps * f64::from(i)).floor()) * (high - low))
}

/// Under an even sky the radiance is the sky's everywhere and in all directions, and irradiance is π times that. The scene's one
/// triangle is far away and tiny.
#[test]
fn a_furnace_is_even() {
    let mut b = Builder::default();
    let black = b.material(diffuse(0.0));
    b.quad(black, vec3(0.0, -3.0, 0.0), Vec3::X * 1e-3, Vec3::Z * 1e-3);
    b.background(Background::Constant(SKY.as_vec3()));
    let (low, high) = (DVec3::NEG_ONE, DVec3::ONE);
    let (volume, placement) =
        baked_in(&b.build(), &settings(Places::Uniform(UVec3::new(3, 2, 4)), Gradients::Edges, 32), [low, high]);
    assert_eq!((placement.samples, placement.cells, placement.inside), (24, 6, 0));
    let reader = Reader::new(&volume);
    let expected = (4.0 * PI).sqrt() * SKY;
    for interpolation in ALL {
        for point in points(low, high) {
            let light = reader.read(point, ReadSettings { interpolation, guard: true }).unwrap();
            for (i, c) in light.iter().enumerate() {
                let expected = if i == 0 { expected } else { DVec3::ZERO };
                assert!((*c - expected).length() < 1e-4 * expected.length().max(1.0), "{interpolation:?} {i}: {c}");
            }
            let green: Vec<f64> = light.iter().map(|c| c.y).collect();
            let e = sh::irradiance(&green, dvec3(0.6, -0.48, 0.64));
            assert!((e / (PI * SKY.y) - 1.0).abs() < 1e-4, "{interpolation:?}: {e}");
        }
    }
}

/// A wide plane in parallel light reflects the radiance L = ρE/π, and nothing comes from above: the radiance at any height is a step. Its
/// mean is L/2, the coefficient of y −L·√(3π)/2, that of every other even degree 0, and the irradiance on a normal n
/// πL·(1 − n.y)/2. Below the plane samples see its back.
#[test]
fn a_lit_plane_is_a_step() {
    let (albedo, irradiance) = (0.5, dvec3(1.0, 2.0, 3.0));
    let mut b = Builder::default();
    let grey = b.material(diffuse(albedo as f32));
    b.floor(grey, 0.0, 400.0);
    b.light(Light::Directional { direction: Vec3::NEG_Y, irradiance: irradiance.as_vec3() });
    let (low, high) = (dvec3(-1.0, 0.5, -1.0), dvec3(1.0, 1.5, 1.0));
    let settings = settings(Places::Uniform(UVec3::splat(3)), Gradients::Differences(0.01), 64);
    let scene = b.build();
    let (volume, placement) = baked_in(&scene, &settings, [low, high]);
    assert_eq!((placement.inside, placement.moved), (0, 0));
    let reader = Reader::new(&volume);
    let radiance = albedo / PI * irradiance;
    for interpolation in ALL {
        for point in points(low, high) {
            let light = reader.read(point, ReadSettings { interpolation, guard: true }).unwrap();
            let mut expected = [DVec3::ZERO; 9];
            expected[0] = PI.sqrt() * radiance;
            expected[1] = -(3.0 * PI).sqrt() / 2.0 * radiance;
            for (i, (c, expected)) in light.iter().zip(expected).enumerate() {
                assert!(
                    (*c - expected).abs().max_element() < 0.01 * radiance.z,
                    "{interpolation:?} {i}: {c} {expected}"
                );
            }
            let blue: Vec<f64> = light.iter().map(|c| c.z).collect();
            for n in [DVec3::Y, DVec3::NEG_Y, DVec3::X, dvec3(0.6, -0.48, 0.64)] {
                let expected = PI * radiance.z * (1.0 - n.y) / 2.0;
                let e = sh::irradiance(&blue, n);
                assert!((e - expected).abs() < 5e-3 * PI * radiance.z, "{interpolation:?} {n}: {e} {expected}");
            }
        }
    }
    let below = [low - DVec3::Y * 2.0, high - DVec3::Y * 2.0];
    let (volume, placement) = baked_in(&scene, &settings, below);
    assert_eq!(placement.inside, placement.samples);
    for sample in &volume.samples {
        assert!(sample.state == State::Inside && (sample.back_share - 0.5).abs() < 0.01, "{sample:?}");
    }
}

//! Irradiance of skies in closed form.

use crate::common::build::{Facing, diffuse};
use crate::common::{Builder, TINT, against, assert_close, look, picture, small, tinted};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::scene::{Background, EnvironmentMap};
use std::f64::consts::PI;

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
        // Where corners are rounded to a coarse part of a pixel, the far side may show at the ball's outline, a pixel or two.
        let outside = |p: DVec3, n: DVec3| (n.dot(p) > 0.0).then(|| expected(n));
        let deviation = against(&picture, "irradiance_direct", TINT, outside);
        let seen = picture.scalar("mask").unwrap().iter().filter(|m| **m == 1.0).count();
        assert!(
            (seen - deviation.pixels) * 1000 <= seen,
            "{} of {seen} pixels show the inside",
            seen - deviation.pixels
        );
        assert_close("πL₀ + (2π/3)L₁n", deviation, 0.003, 0.02, 0.003);
    }
}

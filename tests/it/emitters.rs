//! What emits reflects too.

use crate::common::build::diffuse;
use crate::common::energy::energies;
use crate::common::{Builder, look, picture, small};
use glam::{Vec3, dvec3};
use hemicube::scene::{Light, Material, Scene};
use std::f32::consts::PI;

const ALBEDO: f32 = 0.7;
const IRRADIANCE: f32 = 2.5;

/// A floor that emits and reflects, under a sun, beside a box that it lights.
fn floor(emission: f32) -> Scene {
    let mut b = Builder::default();
    let glows = b.material(Material { emission: Vec3::splat(emission), ..diffuse(ALBEDO) });
    b.floor(glows, 0.0, 1.0);
    b.light(Light::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(IRRADIANCE) });
    b.build()
}

/// Emission and reflection add up; emission of next to nothing changes next to nothing.
#[test]
fn what_emits_reflects_too() {
    let camera = look(dvec3(0.0, 2.0, 0.0), dvec3(0.0, 0.0, 0.0), 40.0);
    let draw = |emission| picture(&floor(emission), &camera, &small(32));
    let dull = draw(0.0);
    let should = ALBEDO * IRRADIANCE / PI;
    for emission in [0.0, 1e-6, 0.01] {
        let picture = draw(emission);
        for (is, without) in picture.rgb("").unwrap()[0].iter().zip(dull.rgb("").unwrap()[0]) {
            assert!((is - without - emission).abs() < 1e-6, "emission {emission}: {is} for {without} without");
            // The albedo is held in half precision.
            assert!((without / should - 1.0).abs() < 1e-3, "{without} for {should}");
        }
        assert!(picture.scalar("mask").unwrap().iter().all(|mask| *mask == 1.0));
    }
}

/// The path tracer says the same of what such a floor reflects of a wall, and the wall of it.
#[test]
fn bounces_of_what_emits() {
    let mut b = Builder::default();
    let glows = b.material(Material { emission: Vec3::new(0.3, 0.2, 0.1), ..diffuse(ALBEDO) });
    let grey = b.material(diffuse(0.5));
    b.floor(glows, 0.0, 1.0);
    b.quad(grey, Vec3::new(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    b.light(Light::Directional { direction: Vec3::new(0.0, -0.8, -0.6), irradiance: Vec3::splat(IRRADIANCE) });
    let camera = look(dvec3(0.3, 1.2, 2.0), dvec3(0.0, 0.6, -1.0), 60.0);
    for (kind, light) in ["direct", "indirect"].iter().zip(energies(&b.build(), &camera, &small(48), 256)) {
        assert!(!light.energy.is_off_by(0.01), "{kind}: {:?}", light.energy);
    }
}

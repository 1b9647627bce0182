//! `--contrast`: records where those of a pixel disagree.

use crate::common::build::diffuse;
use crate::common::closed_forms::{parallelogram, polygon};
use crate::common::{Builder, assert_same_bits, draw, look_parallel, picture, small};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Light, Scene};
use std::f64::consts::PI;

const IRRADIANCE: f32 = 2.0;
const ALBEDO: f32 = 0.5;

/// A wall, z = 0, lit evenly by a strip beside it, and above y = 1 by the upper side of a shelf before it: its irradiance has
/// a kink there, of which no record below knows. And a camera that sees the shelf edge-on.
fn wall_behind_a_shelf() -> (Scene, Camera, [[DVec3; 4]; 2]) {
    let mut b = Builder::default();
    let (grey, black) = (b.material(diffuse(ALBEDO)), b.material(diffuse(0.0)));
    b.quad(black, Vec3::ZERO, Vec3::X, Vec3::Y * 2.0);
    b.quad(grey, vec3(-1.0, 0.0, 0.3), Vec3::NEG_Z * 0.3, Vec3::Y * 2.0);
    b.quad(grey, vec3(0.0, 1.0, 1.4), Vec3::X, Vec3::NEG_Z);
    for direction in [Vec3::NEG_Y, Vec3::NEG_X] {
        b.light(Light::Directional { direction, irradiance: Vec3::splat(IRRADIANCE) });
    }
    let strip = parallelogram(dvec3(-1.0, 0.0, 0.0), DVec3::Y * 2.0, DVec3::Z * 0.3);
    let shelf = parallelogram(dvec3(0.0, 1.0, 0.4), DVec3::X, DVec3::Z);
    (b.build(), look_parallel(dvec3(0.5, 1.0, 4.0), dvec3(0.5, 1.0, 0.0), 0.45), [strip, shelf])
}

fn settings(contrast: f32) -> Settings {
    let mut settings = small(128);
    settings.cache.contrast = contrast;
    settings
}

#[test]
fn a_kink_of_the_irradiance_is_met_where_records_on_its_sides_disagree() {
    let (scene, camera, [strip, shelf]) = wall_behind_a_shelf();
    let expected = |p: DVec3, n: DVec3| {
        let above = if p.y > 1.0 { polygon(p, n, &shelf) } else { 0.0 };
        (n.z > 0.9 && p.z < 1e-3).then(|| f64::from(ALBEDO * IRRADIANCE) / PI * (polygon(p, n, &strip) + above))
    };
    let off = [0.0, 0.1].map(|contrast| {
        let picture = picture(&scene, &camera, &settings(contrast));
        let [p, n] = ["P", "N"].map(|layer| picture.xyz(layer).unwrap());
        let [red, ..] = picture.rgb("irradiance").unwrap();
        let at = |planes: [&[f32]; 3], i: usize| DVec3::from(planes.map(|plane| f64::from(plane[i])));
        let error = |i: usize| expected(at(p, i), at(n, i)).map(|e| (f64::from(red[i]) / e - 1.0).abs());
        let errors: Vec<f64> = (0..red.len()).filter_map(error).collect();
        assert!(errors.len() > 10_000, "the wall fills the picture");
        let off = errors.iter().filter(|error| **error > 0.15).count();
        eprintln!("contrast {contrast}: {off} of {} pixels off by more than 15 %", errors.len());
        off
    });
    let [free, tight] = off;
    assert!(2 * tight < free, "{tight} pixels off, {free} where records may disagree");
}

/// What no pixel exceeds changes nothing, and without a contrast nothing is built for it.
#[test]
fn a_contrast_that_nothing_exceeds_changes_no_bit() {
    let (scene, camera, _) = wall_behind_a_shelf();
    let [without, with] = [0.0, 1e4].map(|contrast| draw(&scene, &camera, &settings(contrast)));
    assert!(with.plan.run().contains(&"contrast") && !without.plan.run().contains(&"contrast"));
    assert_eq!(with.cache, without.cache);
    assert_same_bits(&with.picture, &without.picture, "contrast 10⁴");
}

/// Records of coarse captures disagree by the captures' own error: what that alone asks for are records for nothing.
#[test]
fn coarse_captures_are_not_asked_for_what_they_cannot_tell() {
    let scene = hemicube::scene::cornell();
    // At 8² texels a contrast of C is told from 4·C on; C/4 is what records would be put for if captures were taken for exact.
    let [never, usual, taken_for_exact] = [0.0, 0.15, 0.15 / 4.0].map(|contrast| {
        let mut settings = settings(contrast);
        settings.cache.capture_size = 8;
        draw(&scene, &scene.cameras[0], &settings).cache.records as f64
    });
    eprintln!("{never} records, {usual} by contrast, {taken_for_exact} if captures were exact");
    assert!(usual < 1.02 * never && taken_for_exact > 1.1 * never);
}

/// From 32² texels on the contrast is what it says.
#[test]
fn fine_captures_are_asked_for_the_contrast_itself() {
    let told = |size: u32| {
        let mut cache = settings(0.15).cache;
        cache.capture_size = size;
        cache.told_contrast()
    };
    assert_eq!([8, 16, 32, 64, 256].map(told), [0.6, 0.3, 0.15, 0.15, 0.15]);
}

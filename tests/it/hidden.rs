//! Records and what hides a point from them: no light passes a thin wall from a record on its other side.

use crate::common::build::{Facing, diffuse};
use crate::common::{Builder, draw, look, look_parallel, small};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::renderer::{Rendered, Settings};
use hemicube::scene::{Camera, Light, Scene, cornell};

/// Pixels a side, and the width of one on the floor of the two rooms.
const SIDE: u32 = 96;
const PIXEL: f32 = 2.0 / SIDE as f32;

/// Two rooms without ceilings over one floor, between them a wall without thickness with a slit of width `slit` in it. A
/// sun shines on the left room and on the left of the wall; no light reaches what the right room's floor can see.
fn two_rooms(slit: f32) -> (Scene, Camera) {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 1.0);
    for side in [-1.0, 1.0] {
        let from = vec3(0.0, 0.0, 0.5 * slit * side);
        b.quad(grey, from, Vec3::Z * (side - from.z), Vec3::Y * 1.5);
    }
    b.light(Light::Directional { direction: vec3(1.0, -1.0, 0.0).normalize(), irradiance: Vec3::splat(1e6) });
    (b.build(), look_parallel(dvec3(0.0, 4.0, 0.0), DVec3::ZERO, 1.0))
}

/// Mean irradiance on the right of the wall over that on its left, and the number of pixels on the right that have any. Through
/// the gap a record sees its smallest zone, two pixels wide, to both sides.
fn leak(rendered: &Rendered, gap: f32) -> (f64, usize) {
    let (p, e) = (rendered.picture.xyz("P").unwrap(), rendered.picture.rgb("irradiance").unwrap()[0]);
    let side = |right: bool| {
        let zone = 2.0 * PIXEL;
        let in_gap = |i: usize| gap > 0.0 && p[2][i].abs() < 0.5 * gap + zone && p[0][i].abs() < zone;
        let floor =
            |i: &usize| p[1][*i].abs() < 1e-3 && (p[0][*i] > 0.0) == right && p[0][*i].abs() > 1e-3 && !in_gap(*i);
        (0..e.len()).filter(floor).map(|i| f64::from(e[i])).collect::<Vec<_>>()
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (left, right) = (side(false), side(true));
    (mean(&right) / mean(&left), right.iter().filter(|e| **e != 0.0).count())
}

fn with(hidden: bool, settings: Settings) -> Settings {
    let mut settings = settings;
    settings.cache.hidden = hidden;
    settings
}

/// Two rooms leak through a gap of that width while hidden points are lit, and not at all once they are rejected.
fn check_leak(what: &str, gap: f32) {
    let (scene, camera) = two_rooms(gap);
    let [before, after] = [false, true].map(|hidden| leak(&draw(&scene, &camera, &with(hidden, small(SIDE))), gap));
    let [was, is] = [before.0, after.0].map(|share| share * 1e2);
    eprintln!("{what}: {was:.3} % in {} pixels before, {is:.5} % in {} after", before.1, after.1);
    assert!(before.0 > 0.002, "the scene does not leak: {before:?}");
    assert_eq!(after.1, 0, "{after:?}");
}

#[test]
fn records_do_not_light_the_other_side_of_a_thin_wall() {
    check_leak("thin wall", 0.0);
}

/// A door's slit lets no more through: what is seen through it is lit by records of its own.
#[test]
fn records_do_not_light_through_the_slit_of_a_door() {
    check_leak("door slit", 0.1);
}

/// What is in sight stays in sight: on a concave surface and in a room with corners no more than a few records more.
#[test]
fn nothing_in_sight_is_rejected() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 1.0, 48, Facing::In);
    b.light(Light::Point { position: vec3(0.0, -0.5, 0.0), intensity: Vec3::splat(3.0) });
    let sphere = (b.build(), look(dvec3(0.0, 0.3, 0.8), dvec3(0.0, 0.0, -1.0), 90.0));
    let box_ = (cornell(), cornell().cameras[0].clone());
    for (name, (scene, camera)) in [("sphere", sphere), ("Cornell box", box_)] {
        let [off, on] = [false, true].map(|hidden| draw(&scene, &camera, &with(hidden, small(96))).cache.records);
        eprintln!("{name}: {off} records without rejection, {on} with");
        assert!(on as f64 <= 1.05 * off as f64, "{name}: {off} records become {on}");
    }
}

/// Zones far beyond what gradients are good for: irradiance stays within what the brightest surface could give.
#[test]
fn extrapolation_stays_within_its_evidence() {
    let mut b = Builder::default();
    let (grey, black) = (b.material(diffuse(0.5)), b.material(diffuse(0.0)));
    b.quad(grey, vec3(0.0, 0.0, 2.0), Vec3::NEG_Z * 4.0, Vec3::Y);
    b.quad(black, vec3(0.0, 0.0, 2.0), Vec3::X * 3.0, Vec3::NEG_Z * 4.0);
    b.light(Light::Directional { direction: Vec3::NEG_X, irradiance: Vec3::splat(2.0) });
    let camera = look_parallel(dvec3(1.5, 4.0, 0.0), dvec3(1.5, 0.0, 0.0), 1.4);
    let [low, high] = extremes(&b.build(), &camera);
    // πL = ρE₀ = 1.
    assert!(low >= 0.0 && high > 0.1 && high <= 1.0 + 1e-5, "{low} {high}");
}

/// Where a ball turns away from the only thing that is lit, irradiance ends in a crease; its slope goes on below zero.
#[test]
fn extrapolation_by_turning_is_never_negative() {
    let mut b = Builder::default();
    let (white, black) = (b.material(diffuse(1.0)), b.material(diffuse(0.0)));
    b.sphere(black, Vec3::ZERO, 1.0, 64, Facing::Out);
    b.quad(white, vec3(6.0, -0.5, 0.5), Vec3::NEG_Z, Vec3::Y);
    b.light(Light::Point { position: vec3(5.5, 0.0, 0.0), intensity: Vec3::ONE });
    let [low, high] = extremes(&b.build(), &look_parallel(dvec3(0.0, 0.0, 4.0), DVec3::ZERO, 1.1));
    assert!(low >= 0.0 && high > 0.0, "{low} {high}");
}

/// Least and largest indirect irradiance, by zones of any size.
fn extremes(scene: &Scene, camera: &Camera) -> [f32; 2] {
    let mut settings = small(64);
    (settings.cache.accuracy, settings.cache.max_radius) = (10.0, 1.0);
    let rendered = draw(scene, camera, &settings);
    let e = rendered.picture.rgb("irradiance").unwrap()[0];
    let extremes = e.iter().fold([f32::MAX, f32::MIN], |[low, high], e| [low.min(*e), high.max(*e)]);
    eprintln!("{} records, irradiance from {extremes:?}", rendered.cache.records);
    extremes
}

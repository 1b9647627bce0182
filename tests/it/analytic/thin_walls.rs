//! Walls without thickness, between a dark room and 10⁶ outside.

use crate::common::build::{Facing, diffuse, emitter};
use crate::common::{Builder, each_capture, look, picture, small};
use glam::{Vec3, dvec3, vec3};
use hemicube::methods::captures::CaptureMode;
use hemicube::passes::integrate::Radius;
use hemicube::scene::{Background, Camera, Light, Scene};

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

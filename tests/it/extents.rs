//! What else a scene holds far away changes no light.

use crate::common::build::diffuse;
use crate::common::{Builder, look, picture, small};
use glam::{Vec3, dvec3, vec3};
use hemicube::scene::{Background, Scene};

/// A room of 4 × 3 × 4 whose side towards +z is open, on a ground `half` to each side, under a grey sky.
fn room_on_a_ground(half: f32) -> Scene {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.7));
    b.floor(white, 0.0, half);
    let (left, right) = (vec3(-2.0, 0.0, 2.0), vec3(2.0, 0.0, 2.0));
    let (deep, up) = (Vec3::NEG_Z * 4.0, Vec3::Y * 3.0);
    b.quad(white, left, deep, up);
    b.quad(white, right, deep, up);
    b.quad(white, left + deep, Vec3::X * 4.0, up);
    b.quad(white, left + up, Vec3::X * 4.0, deep);
    b.background(Background::Constant(Vec3::splat(0.5)));
    b.build()
}

/// Mean irradiance by the sky and by what it lights, of what a camera in the room's opening shows: floor and walls.
fn irradiance_inside(half: f32) -> [f64; 2] {
    let picture =
        picture(&room_on_a_ground(half), &look(dvec3(0.0, 1.5, 1.9), dvec3(0.0, 1.0, -2.0), 60.0), &small(64));
    ["irradiance_direct", "irradiance"].map(|layer| {
        let values = picture.rgb(layer).unwrap()[0];
        values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
    })
}

/// From 40 on the ground takes the whole horizon but for 3°: beyond, it changes nothing.
#[test]
fn a_larger_ground_changes_no_light_in_a_room() {
    let near = irradiance_inside(40.0);
    for half in [350.0, 5e3] {
        let far = irradiance_inside(half);
        eprintln!("ground {half}: {far:?} for {near:?}");
        assert!((0..2).all(|i| (far[i] / near[i] - 1.0).abs() < 0.03), "ground {half}: {far:?} for {near:?}");
    }
}

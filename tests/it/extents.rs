//! What else a scene holds far away changes no light.

use crate::common::build::diffuse;
use crate::common::energy::{Light, energies};
use crate::common::{Builder, look, small};
use glam::{Vec3, dvec3, vec3};
use hemicube::renderer::Settings;
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

/// The room's light is the path tracer's, whatever the ground's size.
#[test]
fn a_larger_ground_changes_no_light_in_a_room() {
    let camera = look(dvec3(0.0, 1.5, 1.9), dvec3(0.0, 1.0, -2.0), 60.0);
    for half in [10.0, 350.0, 5e3, 1e6] {
        let found = energies(&room_on_a_ground(half), &camera, &Settings { surface_cells: None, ..small(48) }, 256);
        for (kind, Light { energy, .. }) in ["direct", "indirect"].iter().zip(&found) {
            eprintln!("ground {half}, {kind}: {energy:?}, {:+.2} %", 1e2 * energy.off());
            assert!(!energy.is_off_by(0.03), "ground {half}, {kind}: {energy:?}");
        }
    }
}

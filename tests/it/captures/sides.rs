//! Which side of a triangle is seen, and from how far: by its corners, not by what a rasteriser rounds these to.

use super::{PLANE, mean, measure};
use crate::common::build::{Builder, Facing, diffuse};
use crate::common::closed_forms::{parallelogram, polygon};
use crate::common::probes::turned;
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::methods::captures::CaptureMode;
use hemicube::scene::Light;

const BY_PASSES: [CaptureMode; 2] = [CaptureMode::Hemicube, PLANE];

/// A rectangle that shines downwards, cut into strips of a 200th of a texel: corners that are rounded to a 256th of a texel turn
/// many of them over, and their upper sides are dark.
#[test]
fn slivers_show_the_side_that_faces_the_record() {
    const STRIPS: u32 = 4000;
    let mut b = Builder::default();
    let white = b.material(diffuse(1.0));
    for i in 0..STRIPS {
        let x = |i: u32| 0.3 + 1.2 * i as f32 / STRIPS as f32;
        b.quad(white, vec3(x(i), 1.0, -0.9), Vec3::X * (x(i + 1) - x(i)), Vec3::Z * 1.6);
    }
    b.light(Light::Directional { direction: Vec3::Y, irradiance: Vec3::splat(std::f32::consts::PI) });
    let scene = b.build();
    let e = polygon(DVec3::ZERO, DVec3::Y, &parallelogram(dvec3(0.3, 1.0, -0.9), DVec3::X * 1.2, DVec3::Z * 1.6));
    for capture in BY_PASSES {
        let probes = measure(&scene, capture, 32, &turned(Vec3::ZERO, 32));
        let seen = mean(&probes, |p| p.reflected.value.y) / e;
        eprintln!("{capture:?}: {seen:.4} of the closed form");
        assert!((seen - 1.0).abs() < 0.01, "{capture:?}: {seen} of the closed form");
    }
}

/// In a corner of a room whose walls go far on behind the eye, a thousandth of the room from two of them: 1/R by passes is
/// that in compute, which takes it from the planes.
#[test]
fn distances_of_walls_through_the_camera_plane() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.cuboid(grey, vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.0, 1.0), Facing::In);
    b.light(Light::Point { position: vec3(0.0, 0.5, 0.0), intensity: Vec3::ONE });
    let scene = b.build();
    for off in [1e-2f32, 1e-3, 1e-4] {
        let places = turned(vec3(1.0 - off, 0.0, off - 1.0), 16);
        let [passes, compute] =
            [CaptureMode::Hemicube, CaptureMode::Compute].map(|capture| measure(&scene, capture, 32, &places));
        for (a, b) in passes.iter().zip(&compute) {
            let [r, e] = [a.inverse_distance / b.inverse_distance, a.reflected.value.y / b.reflected.value.y];
            // A texel whose centre is as near to an edge as corners are rounded may fall to its other side.
            assert!((r - 1.0).abs() < 0.01 && (e - 1.0).abs() < 0.01, "{off}: 1/R {r}, E {e}");
        }
    }
}

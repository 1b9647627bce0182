//! Alpha masks, by render passes and as bits in compute.

use super::{WHOLE, mean, measure};
use crate::common::build::{Builder, diffuse};
use crate::common::closed_forms::{parallelogram, polygon};
use crate::common::probes::turned;
use glam::{DVec3, Mat3, Vec3, dvec3, vec3};
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::Probe;
use hemicube::scene::{Background, Material, SideLimit, TextureRef};
use std::f64::consts::PI;

/// A screen with square holes, the sky behind it: E = π − Σ over what is closed.
#[test]
fn alpha_masks_are_seen_through_by_every_kind() {
    let mut b = Builder::default();
    let texels = (0..64).map(|i| if (i + i / 8) % 2 == 0 { [255; 4] } else { [255, 255, 255, 0] }).collect();
    let texture = b.texture(8, 8, texels, true);
    let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let grid = b.material(Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.5) });
    b.floor(grid, 1.0, 1.0);
    b.background(Background::Constant(Vec3::ONE));
    let scene = b.build();
    let side = 0.25;
    let closed = |i: usize| {
        let corner = dvec3((i % 8) as f64 * side - 1.0, 1.0, (i / 8) as f64 * side - 1.0);
        polygon(DVec3::ZERO, DVec3::Y, &parallelogram(corner, DVec3::X * side, DVec3::Z * side))
    };
    let expected = PI - (0..64).filter(|i| (i + i / 8) % 2 == 0).map(closed).sum::<f64>();
    let fine = scene.tessellated(&SideLimit::even(0.1));
    for capture in WHOLE {
        let scene = if capture == CaptureMode::Hemisphere { &fine } else { &scene };
        let e = mean(&measure(scene, capture, 64, &turned(Vec3::ZERO, 32)), |p| p.sky.unwrap().value.y) / expected;
        eprintln!("{capture:?}: {e:.4} of the closed form through a mask");
        assert!((e - 1.0).abs() < 0.01, "{capture:?}: {e}");
    }
}

/// Leaves of every size and tilt over a floor, round by a filtered mask: of 12 texels, so that bits follow it.
fn leaves(b: &mut Builder) {
    let inside = |i: i32| {
        let (x, y) = (f64::from(i % 12) - 5.5, f64::from(i / 12) - 5.5);
        (6.0 - x.hypot(y)).clamp(0.0, 1.0)
    };
    let texels = (0..144).map(|i| [90, 180, 60, (255.0 * inside(i)) as u8]).collect();
    let texture = b.texture(12, 12, texels, false);
    let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let leaf = b.material(Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.9) });
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    for _ in 0..300 {
        let mut vector = || vec3(random() - 0.5, random() - 0.5, random() - 0.5);
        let (along, across) = (vector(), vector());
        let across = across.reject_from(along).normalize() * 0.4;
        let place = vector() * vec3(4.0, 1.5, 4.0) + Vec3::Y;
        b.quad(leaf, place - along.normalize() * 0.2 - 0.5 * across, along.normalize() * 0.4, across);
    }
}

/// Bits stand for a mask within half a texel of its texture at the mask's border, to either side: over many leaves nothing
/// is lost or gained, and a place's E differs by less than the few hemicube texels that a border sweeps.
#[test]
fn masks_in_compute_are_those_of_render_passes() {
    let mut b = Builder::default();
    leaves(&mut b);
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 4.0);
    b.background(Background::Constant(Vec3::ONE));
    let scene = b.build();
    let places: Vec<_> =
        (0..64).flat_map(|i| turned(vec3((i % 8) as f32 - 3.5, 0.0, (i / 8) as f32 - 3.5) * 0.4, 1)).collect();
    let [render, compute] =
        [CaptureMode::Hemicube, CaptureMode::Compute].map(|capture| measure(&scene, capture, 32, &places));
    let sky = |p: &Probe| p.sky.unwrap().value.y;
    let (a, b) = (mean(&render, sky), mean(&compute, sky));
    let off = |(r, c): (&Probe, &Probe)| f64::from((sky(r) - sky(c)).powi(2));
    let rms = (render.iter().zip(&compute).map(off).sum::<f64>() / places.len() as f64).sqrt() / a;
    eprintln!("through leaves: E {:.4} of that by render passes, {rms:.4} rms", b / a);
    assert!((0.2..0.8).contains(&(a / PI)), "leaves cover a good part: {a}");
    assert!((b / a - 1.0).abs() < 0.005 && rms < 0.02, "{a} {b} {rms}");
}

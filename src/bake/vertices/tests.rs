use super::{Off, VertexIrradiance, VertexMethod};
use crate::math::cells;
use crate::methods::surface_irradiance::SurfaceIrradiance;
use crate::scene::Scene;
use crate::scene::build::{Builder, diffuse, tessellated};
use glam::{DVec2, Vec3};

/// A square of 2 × 4^levels triangles with the irradiance of a function of the place.
fn square(levels: u32, irradiance: impl Fn(Vec3) -> f32) -> (Scene, SurfaceIrradiance) {
    const CUTS: u32 = 8;
    let mut b = Builder::default();
    let white = b.material(diffuse(0.5));
    b.floor(white, 0.0, 1.0);
    let scene = tessellated(&b.build(), levels);
    let count = scene.triangles.len() as u32;
    let of_cell = |cell: u32| {
        let [a, b, c] = scene.corners(cell / (CUTS * CUTS));
        let at = cells::point(CUTS, cell % (CUTS * CUTS), DVec2::splat(1.0 / 3.0)).as_vec2();
        [[irradiance(a + (b - a) * at.x + (c - a) * at.y); 3], [0.0; 3]]
    };
    let reflected: Vec<_> = (0..count * CUTS * CUTS).map(of_cell).collect();
    let found = SurfaceIrradiance {
        triangles: scene.triangles.clone(),
        parts: scene.parts.clone(),
        first_cell: (0..=count).map(|t| t * CUTS * CUTS).collect(),
        direct: vec![[[0.0; 3]; 2]; reflected.len()],
        reflected,
        ..SurfaceIrradiance::default()
    };
    (scene, found)
}

fn both(levels: u32, irradiance: impl Fn(Vec3) -> f32) -> [Off; 2] {
    let (scene, found) = square(levels, irradiance);
    [VertexMethod::LeastSquares, VertexMethod::Sampled].map(|method| VertexIrradiance::new(&scene, &found, method).off)
}

/// What is linear is met exactly, but for the size of the cells.
#[test]
fn linear_irradiance_is_met() {
    let (scene, found) = square(2, |p| 2.0 + p.x - 0.5 * p.z);
    let fit = VertexIrradiance::new(&scene, &found, VertexMethod::LeastSquares);
    assert!(fit.off.rms < 2e-3 && (fit.off.energy - 1.0).abs() < 1e-6, "{:?}", fit.off);
    for (p, value) in scene.positions.iter().zip(&fit.values) {
        assert!((value.x - (2.0 + p.x - 0.5 * p.z)).abs() < 0.02, "{p}: {value}");
    }
}

/// Of what is bent, and of a shadow's edge, samples at the vertices take what happens to be there.
#[test]
fn fits_err_less_than_samples() {
    let [fit, sampled] = both(2, |p| 1.0 + p.x * p.x + 0.5 * p.z * p.z);
    assert!(fit.rms <= 0.6 * sampled.rms, "{fit:?} {sampled:?}");
    let [fit, sampled] = both(3, |p| if p.x + 0.3 * p.z > 0.1 { 1.0 } else { 0.0 });
    assert!(fit.rms < sampled.rms, "{fit:?} {sampled:?}");
}

/// Beside a bright spot values would swing below zero: they are held at it, and what is left errs no more than samples do.
#[test]
fn nothing_is_negative() {
    let (scene, found) = square(4, |p| if p.length() < 0.3 { 10.0 } else { 0.0 });
    let [fit, sampled] =
        [VertexMethod::LeastSquares, VertexMethod::Sampled].map(|method| VertexIrradiance::new(&scene, &found, method));
    assert!(fit.values.iter().all(|value| value.min_element() >= 0.0));
    assert!(fit.values.contains(&Vec3::ZERO));
    assert!(fit.off.rms < sampled.off.rms, "{:?} {:?}", fit.off, sampled.off);
}

/// Where seams cut the vertices apart, both sides have one value.
#[test]
fn seams_do_not_show() {
    let (scene, found) = square(0, |p| 1.0 + p.x * p.x);
    let fit = VertexIrradiance::new(&scene, &found, VertexMethod::LeastSquares);
    assert_eq!(fit.unknowns, 4);
    for (i, p) in scene.positions.iter().enumerate() {
        for (j, q) in scene.positions.iter().enumerate().filter(|(_, q)| *q == p) {
            assert_eq!(fit.values[i], fit.values[j], "{p} {q}");
        }
    }
}

//! Outlines that are followed over the triangles' edges, by every kind of hemicube.

use super::WHOLE;
use super::workgroups::by_workgroups;
use crate::common::build::{Builder, Facing, diffuse};
use crate::common::gpu;
use crate::common::probes::{measure_on, settings, turned};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::math::form_factor::polygon;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::{Place, Probe, Probes};
use hemicube::scene::{Background, EnvironmentMap, Light, Scene, cornell};
use hemicube::vk::Device;
use hemicube::vk::pass::Recorder;
use std::f64::consts::PI;
use std::sync::Arc;

/// Hemicubes by subgroups, by whole workgroups and by render passes.
fn hemicubes(scene: &Scene, size: u32, places: &[Place]) -> [(&'static str, Vec<Probe>); 3] {
    let (usual, shared) = (gpu(), by_workgroups());
    let measured = |device, capture| measure_on(device, scene, &settings(capture, size), places);
    [
        ("subgroups", measured(&usual, CaptureMode::Compute)),
        ("workgroups", measured(&shared, CaptureMode::Compute)),
        ("render passes", measured(&usual, CaptureMode::Hemicube)),
    ]
}

/// In scenes of no more triangles than a hemicube has texels.
#[test]
fn hemicubes_of_few_triangles_follow_outlines() {
    let follows = |device: &Arc<Device>, scene: &Scene, capture, size| {
        Probes::new(device, &mut Recorder::new(device), scene, &settings(capture, size)).unwrap().follows_outlines()
    };
    let (device, shared) = (&*gpu(), &by_workgroups());
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 1.0, 40, Facing::In);
    let (few, many) = (cornell(), b.build());
    for size in [16, 32, 64] {
        for (device, capture) in
            [(device, CaptureMode::Compute), (shared, CaptureMode::Compute), (device, CaptureMode::Hemicube)]
        {
            assert!(follows(device, &few, capture, size), "{capture:?}, {size}");
            let texels = 3 * size * size;
            assert_eq!(follows(device, &many, capture, size), many.triangles.len() as u32 <= texels, "{size}");
        }
    }
    for capture in WHOLE.into_iter().filter(|capture| capture.projection() != CaptureMode::Hemicube.projection()) {
        assert!(!follows(device, &few, capture, 32), "{capture:?}");
    }
}

/// Corners of a bright side that is seen from near to its plane, and of a dim one below its nearest edge.
const BRIGHT: [DVec3; 4] =
    [dvec3(1.0, -0.02, 0.1), dvec3(3.0, -0.02, 0.1), dvec3(3.0, -0.02, 0.8), dvec3(1.0, -0.02, 0.8)];
const DIM: [DVec3; 4] = [dvec3(1.0, -1.0, 0.1), BRIGHT[0], BRIGHT[3], dvec3(1.0, -1.0, 0.8)];
/// Radiance of the dim side; the other's is 1.
const GLOW: f64 = 0.01;

/// E at a place across z from both.
fn irradiance(x: f64, y: f64) -> f64 {
    let of = |corners: [DVec3; 4]| polygon(DVec3::Z, &corners.map(|c| c - dvec3(x, y, 0.0))).abs();
    of(BRIGHT) + GLOW * of(DIM)
}

/// A side thinner than a texel of 64 a side, which most hemicubes miss: its own light is lost, the change of it is not. Without
/// outlines most of that is, too (`math::outline`). Where there is no light at all, there are no gradients: what the dim side is for.
#[test]
fn a_side_between_two_texels_is_followed() {
    let mut b = Builder::default();
    let [white, grey] = [1.0, GLOW as f32].map(|rho| b.material(diffuse(rho)));
    let [a, _, _, d] = BRIGHT.map(|c| c.as_vec3());
    b.quad(white, a, Vec3::X * 2.0, d - a);
    b.quad(grey, a, DIM[0].as_vec3() - a, d - a);
    for direction in [Vec3::NEG_Y, Vec3::X] {
        b.light(Light::Directional { direction, irradiance: Vec3::splat(PI as f32) });
    }
    let step = 1e-3;
    let slope =
        dvec3(irradiance(step, 0.0) - irradiance(-step, 0.0), irradiance(0.0, step) - irradiance(0.0, -step), 0.0);
    let slope = slope / (2.0 * step);
    let places = turned(Vec3::ZERO, 12).into_iter();
    let places: Vec<_> =
        places.map(|p| Place { normal: Vec3::Z, geometric: Vec3::Z, turn: p.turn + 0.137, ..p }).collect();
    for (by, probes) in hemicubes(&b.build(), 64, &places) {
        let off = |probe: &Probe| (probe.reflected.translation[0].as_dvec3() - slope).length() / slope.length();
        let error = probes.iter().map(off).sum::<f64>() / probes.len() as f64;
        eprintln!("{by}: {error:.4}");
        // The side is some fifteen texels high, its ends are up to half a texel off.
        assert!(error < 1.0 / 15.0, "{by}: {error}");
    }
}

/// Whole workgroups and render passes follow the same outlines, each by its own triangles, before surfaces and before a sky.
/// Wherever they see the same: rasterisers place corners on a grid, so that here and there a texel sees what its neighbour does.
#[test]
fn workgroups_follow_what_render_passes_do() {
    if !gpu().capabilities.clips_before_setup {
        eprintln!("corners are rounded to 1/16 of a texel here: no two records see the same, nothing is checked");
        return;
    }
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 4.0);
    b.quad(grey, vec3(1.5, 0.1, 4.0), Vec3::NEG_Z * 8.0, Vec3::Y * 2.0);
    for i in 0..12 {
        let low = vec3((i % 4) as f32 * 0.6 - 1.3, 0.1 + i as f32 * 0.1, (i / 4) as f32 * 0.7 - 0.9);
        b.cuboid(grey, low, low + vec3(0.2, 0.05, 0.3), Facing::Out);
    }
    b.light(Light::Point { position: vec3(0.5, 1.0, 0.0), intensity: vec3(3.0, 2.0, 1.0) });
    let rgb = (0..32).map(|i| [(i % 8) as f32, 1.0, (i / 8) as f32]).collect();
    b.background(Background::Map(EnvironmentMap { width: 8, height: 4, rgb }));
    let scene = b.build();
    let places: Vec<_> = (0..8)
        .flat_map(|i| turned(vec3(i as f32 * 0.3 - 1.0, 0.0, i as f32 * 0.2 - 0.8), 4))
        .map(|p| Place { turn: p.turn + 0.137, ..p })
        .collect();
    for size in [8, 16, 32] {
        let [_, (_, shared), (_, passes)] = hemicubes(&scene, size, &places);
        let close = |a: Vec3, b: Vec3| (a - b).length() < 1e-5 * b.length();
        let (mut same, mut off, mut total) = (0, 0.0, 0.0);
        for (a, b) in shared.iter().zip(&passes) {
            let kinds = [(a.reflected, b.reflected), (a.sky.unwrap(), b.sky.unwrap())];
            let as_near = (a.inverse_distance / b.inverse_distance - 1.0).abs() < 1e-5;
            if !as_near || kinds.iter().any(|(a, b)| !close(a.value, b.value)) {
                continue;
            }
            same += 1;
            for (a, b) in kinds.iter().flat_map(|(a, b)| a.translation.into_iter().zip(b.translation)) {
                off += (a - b).length();
                total += b.length();
            }
        }
        eprintln!("{size}: {same} of {} see the same, gradients are {:.1e} off", places.len(), off / total);
        // Of an outline that is just worth it rounding decides.
        assert!(off < 1e-3 * total, "{size}: {off} of {total}");
        assert!(same > places.len() / 2, "{size}: {same}");
    }
}

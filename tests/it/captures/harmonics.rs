//! Captures projected onto harmonics, by render passes and in compute: against the twin on the CPU in double, against a sky in
//! closed form, and against another renderer's probes.

use crate::common::build::{Builder, Facing, diffuse};
use crate::common::{gpu, scene_folder};
use glam::{DMat3, DVec3, Vec3, vec3};
use hemicube::math::capture::{Basis, Coefficient, Projection, Seen, Weights};
use hemicube::math::sh;
use hemicube::methods::Ground;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::gather::{Gather, GatherDesc};
use hemicube::methods::sphere_probes::{SphereProbeSettings, SphereProbes};
use hemicube::passes::cluster_tree::Detail;
use hemicube::passes::geometry::{CellBudget, Geometry};
use hemicube::passes::project::Projected;
use hemicube::renderer::Settings;
use hemicube::scene::{Background, Scene};
use hemicube::vk::gpu_types::Frame;
use hemicube::vk::pass::Recorder;

const SIZE: u32 = 32;

/// Some boxes of all kinds of slopes around the origin.
fn boxes() -> Scene {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.cuboid(grey, vec3(-2.1, -1.3, -1.9), vec3(2.3, 1.7, 2.5), Facing::In);
    b.cuboid(grey, vec3(0.4, 0.3, 0.5), vec3(1.1, 1.2, 1.3), Facing::Out);
    b.cuboid(grey, vec3(-1.4, -0.6, 0.2), vec3(-0.7, 0.5, 1.6), Facing::Out);
    b.cuboid(grey, vec3(-0.3, -1.1, -1.2), vec3(0.6, -0.5, -0.6), Facing::Out);
    b.build()
}

/// Radiance of a triangle by its middle: another one each, and the same to both sides.
fn radiance(corners: [DVec3; 3]) -> [f64; 3] {
    let middle = corners.iter().sum::<DVec3>();
    [1.0, 2.0, 3.0].map(|c| 1.0 + (c * middle.x + 1.7 * middle.y - 0.6 * c * middle.z).sin())
}

/// A turned frame near the origin.
fn frame(has_horizon: bool) -> (Frame, DVec3, DMat3) {
    let turn = glam::Quat::from_axis_angle(vec3(1.0, 2.0, 2.0) / 3.0, 0.8);
    let [x, y, z] = Vec3::AXES.map(|axis| turn * axis);
    let origin = vec3(0.07, -0.13, 0.11);
    let horizon = if has_horizon { z.extend(-z.dot(origin)).to_array() } else { [0.0, 0.0, 0.0, 1.0] };
    let [tangent, bitangent, normal] = [x, y, z].map(|axis| axis.extend(1.0).to_array());
    let axes = DMat3::from_cols(x.as_dvec3(), y.as_dvec3(), z.as_dvec3());
    let frame = Frame { origin: origin.extend(1e-9).to_array(), tangent, bitangent, normal, horizon };
    (frame, origin.as_dvec3(), axes)
}

/// What a direction of the frame sees of triangles around its origin: radiance in one channel, and the plane.
fn see(triangles: &[[DVec3; 3]], light: &[[f64; 3]], axes: &DMat3, local: DVec3, channel: usize) -> Seen {
    let way = *axes * local;
    let mut best = Seen { radiance: 0.0, inverse_distance: 0.0, plane: DVec3::ZERO };
    for ([a, b, c], light) in triangles.iter().zip(light) {
        let sides = [a.cross(*b), b.cross(*c), c.cross(*a)].map(|side| side.dot(way));
        let normal = (b - a).cross(c - a);
        let plane = normal / normal.dot(*a);
        let inverse_distance = plane.dot(way);
        let within = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
        if within && inverse_distance > best.inverse_distance {
            best = Seen { radiance: light[channel], inverse_distance, plane: axes.transpose() * plane };
        }
    }
    best
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

/// Errors of values and gradients over all coefficients and channels, as shares of their root mean square.
fn errors(got: &Projected, twin: &[Vec<Coefficient>; 3]) -> [f64; 2] {
    let all = || (0..3).flat_map(|channel| twin[channel].iter().enumerate().map(move |(i, c)| (channel, i, c)));
    let slope =
        |channel, i: usize| DVec3::from([0, 1, 2].map(|axis: usize| f64::from(got.gradients[i][axis][channel])));
    let value = all().map(|(channel, i, c)| f64::from(got.coefficients[i][channel]) - c.value);
    let slopes = all().map(|(channel, i, c)| (slope(channel, i) - c.translation).length());
    [rms(value) / rms(all().map(|(_, _, c)| c.value)), rms(slopes) / rms(all().map(|(_, _, c)| c.translation.length()))]
}

/// The device's sums are the twin's, in all bases and by both ways to capture: single precision is all that lies between, and
/// here and there a texel whose centre lies within rounding of an edge.
#[test]
fn harmonics_are_those_of_the_twin() {
    let device = gpu();
    let before = device.instance.validation_messages();
    let scene = boxes();
    let geometry = Geometry::new(&device, &scene, &CellBudget::even(1), Some(Detail::Exact)).unwrap();
    let corners = |t: &[u32; 3]| t.map(|v| scene.positions[v as usize].as_dvec3());
    let triangles: Vec<[DVec3; 3]> = geometry.triangles.iter().map(corners).collect();
    let cells: Vec<[f32; 6]> = triangles
        .iter()
        .map(|t| {
            let [r, g, b] = radiance(*t).map(|c| c as f32);
            [r, g, b, r, g, b]
        })
        .collect();
    assert_eq!(cells.len(), geometry.cell_count as usize);
    geometry.cell_radiance.upload(&cells).unwrap();
    let ground = Ground { scene: &scene, geometry: &geometry, textures: None };
    let mut recorder = Recorder::new(&device);
    for (projection, basis) in [
        (Projection::Cube, Basis::Sh(3)),
        (Projection::Hemicube, Basis::Hsh(6)),
        (Projection::Hemicube, Basis::Cosine),
        (Projection::Hemisphere, Basis::Hsh(3)),
    ] {
        let table = projection.table(SIZE);
        let weights = Weights::new(projection, SIZE, &table, basis);
        let (frame, origin, axes) = frame(projection.has_horizon());
        let around: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|p| p - origin)).collect();
        let light: Vec<[f64; 3]> = triangles.iter().map(|t| radiance(*t)).collect();
        let twin = [0, 1, 2].map(|channel| {
            let seen: Vec<Seen> =
                table.texels.iter().map(|t| see(&around, &light, &axes, t.direction, channel)).collect();
            weights.integrate(&table, &seen)
        });
        let distance = twin[0].1;
        let twin = twin.map(|(coefficients, _)| coefficients);
        // Render passes draw the sides of triangles straight on the disc, where they are curves.
        let ways: &[bool] = if projection == Projection::Hemisphere { &[true] } else { &[false, true] };
        for &in_compute in ways {
            let desc = GatherDesc { projection, basis, size: SIZE, gradients: true, in_compute, distances: None };
            let gather = Gather::new(&device, &ground, None, desc).unwrap();
            let measured = gather.run(&mut recorder, &ground, &[frame; 3]).unwrap();
            let [value, slope] = errors(&measured[2].projected, &twin);
            eprintln!("{projection:?} {basis:?}, in compute: {in_compute}: {value:.1e} {slope:.1e}");
            assert!(value < 1e-3 && slope < 5e-3, "{projection:?} {basis:?} {in_compute}: {value} {slope}");
            assert!((f64::from(measured[2].projected.inverse_distance) / distance - 1.0).abs() < 1e-3);
            assert_eq!(measured[0], measured[2]);
        }
    }
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
}

fn settings(capture: CaptureMode, order: u32) -> SphereProbeSettings {
    let lights = Settings::default().lights;
    SphereProbeSettings {
        order,
        capture_size: SIZE,
        capture,
        gradients: true,
        distances: None,
        lights,
        surface_cells: 1 << 16,
    }
}

const WAYS: [CaptureMode; 2] = [CaptureMode::Hemicube, CaptureMode::Compute];

/// Alone under a constant sky: √4π times its radiance, and nothing else; irradiance π times that all around, but where the one
/// black triangle, far away and tiny, hides it.
#[test]
fn a_constant_sky_is_the_first_coefficient() {
    let device = gpu();
    let mut b = Builder::default();
    let black = b.material(diffuse(0.0));
    b.quad(black, vec3(50.0, 50.0, 50.0), Vec3::X * 1e-3, Vec3::Y * 1e-3);
    b.background(Background::Constant(vec3(1.0, 2.0, 3.0)));
    let scene = b.build();
    let mut recorder = Recorder::new(&device);
    for capture in WAYS {
        let probes = SphereProbes::new(&device, &mut recorder, &scene, &settings(capture, 6)).unwrap();
        let found = &probes.measure(&mut recorder, &[Vec3::ZERO], |_| {}).unwrap()[0];
        for (i, c) in found.projected.coefficients.iter().enumerate() {
            let expected = if i == 0 { (4.0 * std::f32::consts::PI).sqrt() } else { 0.0 };
            assert!((*c - expected * vec3(1.0, 2.0, 3.0)).length() < 1e-4, "{capture:?} {i}: {c}");
        }
        let sky: Vec<f64> = found.projected.coefficients.iter().map(|c| f64::from(c.y)).collect();
        assert!((sh::irradiance(&sky, DVec3::Z) / (2.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4);
    }
}

/// 59 points of the Cornell box by another renderer, light that was reflected once (../shared/scenes/README.md).
#[test]
fn irradiance_in_the_cornell_box_is_another_renderers() {
    let Some(folder) = scene_folder("cornell") else { return };
    let scene = hemicube::scene::load(&folder.join("cornell.gltf")).unwrap();
    let file = std::fs::read_to_string(folder.join("volume.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&file).unwrap();
    let points = file["points"].as_array().unwrap();
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let places: Vec<Vec3> =
        points.iter().map(|point| (DVec3::from_slice(&numbers(&point["p"])) - scene.origin).as_vec3()).collect();
    let device = gpu();
    let mut recorder = Recorder::new(&device);
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    for capture in WAYS {
        let probes = SphereProbes::new(&device, &mut recorder, &scene, &settings(capture, 5)).unwrap();
        let found = probes.measure(&mut recorder, &places, |_| {}).unwrap();
        let (mut off, mut sum, mut energy, mut of_sh, mut all_sh) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (probe, point) in found.iter().zip(points) {
            for channel in 0..3 {
                let got: Vec<f64> = probe.projected.coefficients.iter().map(|c| f64::from(c[channel])).collect();
                for (axis, expected) in axes.iter().zip(point["one"]["E"].as_array().unwrap()) {
                    let (e, expected) = (sh::irradiance(&got, *axis), numbers(expected)[channel]);
                    off += (e - expected).abs();
                    energy += e;
                    sum += expected;
                }
                for (c, expected) in got.iter().zip(point["one"]["sh"].as_array().unwrap()) {
                    of_sh += (c - numbers(expected)[channel]).powi(2);
                    all_sh += numbers(expected)[channel].powi(2);
                }
            }
        }
        let sh_error = f64::sqrt(of_sh / all_sh);
        eprintln!(
            "{capture:?}: irradiance off by {:.2} %, energy {:.4}, SH off by {:.2} %",
            1e2 * off / sum,
            energy / sum,
            1e2 * sh_error
        );
        assert!(off / sum < 0.015 && (energy / sum - 1.0).abs() < 0.01 && sh_error < 0.04, "{capture:?}");
    }
}

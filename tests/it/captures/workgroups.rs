//! Captures in compute by whole workgroups and by subgroups.

use super::measure;
use crate::common::build::{Builder, Facing, diffuse};
use crate::common::probes::{measure_on, settings, turned};
use glam::{Vec3, vec3, vec4};
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::Irradiance;
use hemicube::scene::{Background, EnvironmentMap, Light, Material};
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::sync::Arc;

/// A device without subgroups that talk.
pub(super) fn by_workgroups() -> Arc<Device> {
    let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    Arc::get_mut(&mut device).unwrap().capabilities.subgroup = None;
    device
}

/// A device that cannot ballot in subgroups captures by whole workgroups, which list octets in another order: only where
/// two surfaces are equally far may they see the other one. Of a sphere's 130,000 triangles, as many as one subgroup
/// draws, more are seen than are listed at once.
#[test]
fn workgroups_capture_what_subgroups_do() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 2.0, 181, Facing::In);
    b.light(Light::Point { position: vec3(0.5, 0.3, 0.0), intensity: Vec3::splat(3.0) });
    let scene = b.build();
    let device = by_workgroups();
    let places = turned(vec3(0.0, -1.0, 0.0), 8);
    for capture in [CaptureMode::Compute, CaptureMode::ComputeHemisphere] {
        let usual = measure(&scene, capture, 32, &places);
        for (a, b) in usual.iter().zip(measure_on(&device, &scene, &settings(capture, 32), &places)) {
            let (a, b) = (a.reflected.value.y, b.reflected.value.y);
            assert!((a / b - 1.0).abs() < 1e-4, "{capture:?}: {a} {b}");
        }
    }
}

/// Subgroups sum the faces that they draw, edges within faces too; workgroups write texels, which are summed afterwards. All
/// sums are the same but for the order in which they add up: of surfaces that nowhere touch, so that no two are equally far,
/// and of a sky. A sphere under the floor, of more triangles than texels, keeps outlines from being followed, which subgroups do
/// within faces only.
#[test]
fn sums_of_faces_are_those_of_their_texels() {
    let mut b = Builder::default();
    let red = Material { base_color: vec4(0.8, 0.2, 0.1, 1.0), ..diffuse(0.5) };
    let [grey, red] = [diffuse(0.5), red].map(|m| b.material(m));
    b.floor(grey, 0.0, 4.0);
    b.quad(red, vec3(1.5, 0.1, 4.0), Vec3::NEG_Z * 8.0, Vec3::Y * 2.0);
    for i in 0..12 {
        let low = vec3((i % 4) as f32 * 0.6 - 1.3, 0.1 + i as f32 * 0.1, (i / 4) as f32 * 0.7 - 0.9);
        b.cuboid(red, low, low + vec3(0.2, 0.05, 0.3), Facing::Out);
    }
    b.sphere(grey, vec3(0.0, -3.0, 0.0), 1.0, 60, Facing::Out);
    b.light(Light::Point { position: vec3(0.5, 1.0, 0.0), intensity: vec3(3.0, 2.0, 1.0) });
    let rgb = (0..32).map(|i| [(i % 8) as f32, 1.0, (i / 8) as f32]).collect();
    b.background(Background::Map(EnvironmentMap { width: 8, height: 4, rgb }));
    let scene = b.build();
    let places: Vec<_> =
        (0..8).flat_map(|i| turned(vec3(i as f32 * 0.3 - 1.0, 0.0, i as f32 * 0.2 - 0.8), 2)).collect();
    let device = by_workgroups();
    for size in [8, 16, 32, 64] {
        let summed = measure(&scene, CaptureMode::Compute, size, &places);
        let texels = measure_on(&device, &scene, &settings(CaptureMode::Compute, size), &places);
        for (a, b) in summed.iter().zip(&texels) {
            assert!((a.inverse_distance / b.inverse_distance - 1.0).abs() < 1e-5);
            for (a, b) in [(a.reflected, b.reflected), (a.sky.unwrap(), b.sky.unwrap())] {
                let of = |i: &Irradiance| [[i.value; 1].as_slice(), &i.rotation, &i.translation].concat();
                let most = of(&b).iter().map(|v| v.abs().max_element()).fold(0.0, f32::max);
                let off = of(&a).iter().zip(of(&b)).map(|(a, b)| (*a - b).abs().max_element()).fold(0.0, f32::max);
                assert!(off < 2e-5 * most, "{size}: {a:?} {b:?}");
            }
        }
    }
}

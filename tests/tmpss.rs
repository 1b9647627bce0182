#![allow(clippy::unwrap_used)]
mod common;
use common::build::{Builder, Facing, diffuse};
use common::probes::{measure_on, settings, turned};
use common::{look, small};
use glam::*;
use hemicube::methods::captures::CaptureMode;
use hemicube::renderer::render;
use hemicube::scene::*;
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::sync::Arc;

#[test]
fn cut() {
    let mut b = Builder::default();
    let texels = |a: [u8; 4], c: [u8; 4]| (0..64).map(|i| if (i + i / 8) % 2 == 0 { a } else { c }).collect::<Vec<_>>();
    let colours = b.texture(8, 8, texels([220, 180, 60, 255], [60, 90, 200, 255]), false);
    let holes = b.texture(8, 8, texels([255; 4], [255, 255, 255, 0]), true);
    let map = |texture| Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let tiles = b.material(Material { base_texture: map(colours), ..diffuse(0.8) });
    let grid = b.material(Material { base_texture: map(holes), alpha_cutoff: Some(0.5), ..diffuse(0.6) });
    b.cuboid(tiles, vec3(-3.0, 0.0, -3.0), vec3(3.0, 3.0, 3.0), Facing::In);
    b.floor(grid, 0.5, 3.0);
    b.light(Light::Point { position: vec3(1.0, 2.0, 0.5), intensity: Vec3::splat(3.0) });
    let scene = b.build();
    let mut settings = small(32);
    (settings.cache.capture, settings.cache.capture_size, settings.cache.accuracy) = (CaptureMode::Hemicube, 16, 0.6);
    let [whole, cut] = [true, false].map(|clips| {
        let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
        Arc::get_mut(&mut device).unwrap().capabilities.clips_before_setup = clips;
        let camera = look(dvec3(2.5, 1.2, 2.5), dvec3(0.0, 0.8, 0.0), 80.0);
        render(&device, &scene, &camera, &settings, &mut |_, _, _| {}).unwrap().picture
    });
    for (name, values) in whole.channels.iter() {
        let scale = values.iter().fold(0.0f32, |most, v| most.max(v.abs()));
        let off: Vec<_> = values
            .iter()
            .zip(&cut.channels[name])
            .enumerate()
            .filter(|(_, (a, b))| (*a - *b).abs() > 0.01 * scale)
            .map(|(i, (a, b))| (i % 32, i / 32, *a, *b))
            .collect();
        eprintln!("{name} of {scale}: {} {:?}", off.len(), &off[..off.len().min(40)]);
    }
}

#[test]
fn sheets() {
    let make = |behind: bool, size: u32, apart: f32| {
        let mut b = Builder::default();
        let black = b.material(diffuse(0.0));
        b.quad(black, vec3(-0.3, -0.5, 0.1), Vec3::X * 1e-3, Vec3::Z * 1e-3);
        if behind {
            b.quad(black, vec3(0.3, 1.0, -0.9) * (1.0 + 1.0 / apart), Vec3::X * 1.2, Vec3::Z * 1.6);
        }
        let white = b.material(diffuse(1.0));
        b.quad(white, vec3(0.3, 1.0, -0.9), Vec3::X * 1.2, Vec3::Z * 1.6);
        b.light(Light::Directional { direction: Vec3::Y, irradiance: Vec3::splat(std::f32::consts::PI) });
        let device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
        measure_on(&device, &b.build(), &settings(CaptureMode::Hemicube, size), &turned(Vec3::ZERO, 16))
    };
    for size in [32, 64] {
        for apart in [100.0, 300.0, 1e3, 3e3, 13e3, 52e3] {
            let mut worst = 0.0f32;
            let mut n = 0;
            for (one, two) in make(false, size, apart).iter().zip(&make(true, size, apart)) {
                let [one, two] = [one, two].map(|p| p.reflected.value.y);
                let off = (two / one - 1.0).abs();
                if off > 1e-5 {
                    n += 1;
                }
                worst = worst.max(off);
            }
            eprintln!("{size} {apart}: {n} of 16 off, {worst}");
        }
    }
}

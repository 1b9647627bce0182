//! Validation, synchronisation included, is silent on every kind of scene; and it does speak where a hazard is.

use crate::common::build::{diffuse, emitter};
use crate::common::{Builder, check_complete, draw, every_capture, gpu, look, small};
use glam::{DVec3, Mat3, Vec3, Vec4, dvec3, vec3};
use hemicube::methods::rates::Rates;
use hemicube::renderer::Settings;
use hemicube::scene::{Background, EnvironmentMap, Light, Material, TextureRef, cornell};
use hemicube::vk::{Buffer, Commands, Device, DeviceChoice, Instance, Memory, barrier};

/// Messages for two copies into one buffer, with `between` them.
fn messages_of_two_writes(between: impl FnOnce(&Commands)) -> u32 {
    // An instance of its own: its messages are wanted.
    let instance = Instance::new(true).expect("Vulkan and its validation");
    let device = Device::new(instance.clone(), &DeviceChoice::Best).expect("a device");
    let buffer = |name| Buffer::new(&device, name, 1024, Memory::Device).expect("a buffer");
    let (a, b, target) = (buffer("first source"), buffer("second source"), buffer("target of both"));
    let commands = Commands::begin(&device).expect("commands");
    commands.copy_buffer(&a, &target, 1024);
    between(&commands);
    commands.copy_buffer(&b, &target, 1024);
    commands.finish().expect("a finished submission");
    instance.validation_messages()
}

#[test]
fn a_deliberate_hazard_is_counted() {
    let messages = messages_of_two_writes(|_| {});
    assert!(messages > 0, "two writes without a barrier: synchronisation validation is not at work");
    assert_eq!(messages_of_two_writes(barrier::full), 0, "with a barrier nothing is wrong");
}

/// Orders of magnitude apart from any device's: a rate by a wrong count or unit is seen, a busy machine is not.
#[test]
fn rates_of_a_device_are_measured() {
    let device = gpu();
    let before = device.instance.validation_messages();
    let rates = Rates::measure(&device).expect("rates");
    assert_eq!(device.instance.validation_messages() - before, 0);
    for rate in [rates.triangle_views, rates.blended_fragments, rates.integrated_texels] {
        assert!((1e4..1e13).contains(&rate), "{rates:?}");
    }
    assert!(rates.timestamp_ms > 0.0 && rates.timestamp_ms < 100.0, "{rates:?}");
}

#[test]
fn the_cornell_box() {
    let scene = cornell();
    for settings in every_capture(small(64)) {
        check_complete(&draw(&scene, &scene.cameras[0], &settings));
    }
}

/// A room whose every texture kind is in use: colour, alpha mask, normal map, emission.
#[test]
fn textures_masks_and_normal_maps() {
    let mut b = Builder::default();
    let checker =
        |a: [u8; 4], c: [u8; 4]| (0..64).map(|i| if (i + i / 8) % 2 == 0 { a } else { c }).collect::<Vec<_>>();
    let colour = b.texture(8, 8, checker([200, 120, 40, 255], [40, 120, 200, 255]), false);
    let cut = b.texture(8, 8, checker([255; 4], [255, 255, 255, 0]), true);
    let bumps = b.texture(8, 8, checker([150, 128, 240, 255], [100, 140, 240, 255]), false);
    let glow = b.texture(8, 8, checker([255; 4], [0, 0, 0, 255]), true);
    let map = |texture| Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let wall = b.material(Material { base_texture: map(colour), normal_texture: map(bumps), ..diffuse(0.9) });
    let grid = b.material(Material { base_texture: map(cut), alpha_cutoff: Some(0.5), ..diffuse(0.6) });
    let shade =
        b.material(Material { base_color: Vec4::new(0.5, 0.5, 0.5, 0.4), alpha_cutoff: Some(0.5), ..diffuse(0.5) });
    let lamp = b.material(Material { emission_texture: map(glow), ..emitter(vec3(9.0, 8.0, 7.0)) });
    b.cuboid(wall, Vec3::splat(-1.0), Vec3::splat(1.0), crate::common::build::Facing::In);
    b.floor(grid, 0.3, 0.7);
    b.floor(shade, 0.6, 0.5);
    b.ceiling(lamp, 0.98, 0.4);
    let camera = look(dvec3(0.9, 0.6, 0.9), dvec3(0.0, -0.2, 0.0), 70.0);
    let scene = b.build();
    for settings in every_capture(small(64)) {
        check_complete(&draw(&scene, &camera, &settings));
    }
}

#[test]
fn an_open_scene_under_a_sky_map() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.6));
    b.floor(grey, 0.0, 2.0);
    b.cuboid(grey, vec3(-0.5, 0.0, -0.5), vec3(0.5, 1.0, 0.5), crate::common::build::Facing::Out);
    let rgb = (0..32 * 16).map(|i| [1.0 + (i % 32) as f32 / 32.0, 1.0, 2.0 - i as f32 / 512.0]).collect();
    b.background(Background::Map(EnvironmentMap { width: 32, height: 16, rgb }));
    let scene = b.build();
    for settings in every_capture(small(64)) {
        check_complete(&draw(&scene, &look(dvec3(2.0, 2.0, 3.0), DVec3::ZERO, 60.0), &settings));
    }
}

#[test]
fn every_kind_of_light_at_once() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.6));
    b.floor(grey, 0.0, 2.0);
    b.cuboid(grey, vec3(-0.3, 0.2, -0.3), vec3(0.3, 0.8, 0.3), crate::common::build::Facing::Out);
    let (position, intensity) = (vec3(1.0, 1.5, 0.0), Vec3::splat(2.0));
    b.light(Light::Point { position, intensity });
    for cos_outer in [0.9, 0.05] {
        b.light(Light::Spot {
            position: -position * vec3(1.0, -1.0, 1.0),
            direction: Vec3::NEG_Y,
            intensity,
            cos_inner: 0.95,
            cos_outer,
        });
    }
    b.light(Light::Directional { direction: vec3(1.0, -2.0, 0.5).normalize(), irradiance: Vec3::ONE });
    let scene = b.build();
    for settings in every_capture(small(64)) {
        check_complete(&draw(&scene, &look(dvec3(2.0, 2.0, 3.0), DVec3::ZERO, 60.0), &settings));
    }
}

#[test]
fn every_part_at_once_and_direct_light_alone() {
    let scene = cornell();
    draw(&scene, &scene.cameras[0], &Settings { full_plan: true, ..small(48) });
    draw(&scene, &scene.cameras[0], &Settings { bounces: 0, ..small(48) });
}

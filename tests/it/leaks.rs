//! A frame gives back all device memory that it took, and the second takes no more than the first.

use crate::common::{look, small};
use glam::{DVec3, dvec3};
use hemicube::renderer::render;
use hemicube::scene::{Background, cornell};
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::sync::Arc;

/// A device of this test alone: nothing else may hold memory of it.
fn device() -> Arc<Device> {
    let instance = Instance::new(true).expect("Vulkan and its validation");
    Device::new(instance, &DeviceChoice::Best).expect("a device")
}

#[test]
fn device_memory_returns_to_zero() {
    let device = device();
    let mut scene = cornell();
    scene.background = Background::Constant(glam::Vec3::ONE);
    let outside = look(dvec3(0.278, 0.273, -0.8), DVec3::splat(0.27), 60.0);
    assert_eq!(device.memory().now, 0, "nothing is made before it is needed");
    let mut peaks = Vec::new();
    for _ in 0..2 {
        let rendered = render(&device, &scene, &outside, &small(32), &mut |_, _, _| {}).expect("a frame");
        peaks.push(rendered.memory.peak);
        assert_eq!(device.memory().now, 0, "left: {:?}", device.memory());
    }
    assert!(peaks[0] > 0 && peaks[0] == peaks[1], "{peaks:?}");
    let by_use: u64 = device.memory().by_use.values().sum();
    assert!(by_use >= peaks[0], "each use is counted: {by_use} of {}", peaks[0]);
    assert_eq!(device.instance.validation_messages(), 0);
}

#[test]
fn a_frame_that_is_refused_leaves_nothing_either() {
    let device = device();
    let scene = cornell();
    let mut wrong = small(32);
    wrong.width = 0;
    assert!(render(&device, &scene, &scene.cameras[0], &wrong, &mut |_, _, _| {}).is_err());
    let mut lights = cornell();
    let light = hemicube::scene::Light::Point { position: glam::Vec3::ZERO, intensity: glam::Vec3::ONE };
    lights.lights = vec![light; hemicube::methods::light_samples::MAX_LIGHTS + 1];
    assert!(render(&device, &lights, &scene.cameras[0], &small(32), &mut |_, _, _| {}).is_err());
    assert_eq!(device.memory().now, 0, "left: {:?}", device.memory());
}

use super::*;
use crate::passes::geometry::CellBudget;
use crate::vk::{Commands, DeviceChoice, Instance, barrier};

/// A frame at the middle of the built-in Cornell box, looking up, turned a little.
fn frame() -> Frame {
    let (s, c) = 0.3_f32.sin_cos();
    let origin = [0.27, 0.2, 0.25];
    Frame {
        origin: [origin[0], origin[1], origin[2], 1e-6],
        tangent: [c, 0.0, -s, 1.0],
        bitangent: [-s, 0.0, -c, 1.0],
        normal: [0.0, 1.0, 0.0, 1.0],
        horizon: [0.0, 1.0, 0.0, -origin[1]],
    }
}

fn identities(device: &Arc<Device>, geometry: &Geometry, scene: &Scene, culled: bool) -> Vec<u32> {
    let desc = CaptureDesc { name: "capture", views: Views::Hemicube, size: 16, capacity: 4, identity: true, culled };
    let capture = Capture::new(device, scene, geometry, None, desc).unwrap();
    capture.frames.upload(&[frame(); 3]).unwrap();
    let image = capture.identity.as_ref().unwrap();
    let texels = 32 * 32 * 5;
    let readback = Buffer::new(device, "read-back", texels * 4, Memory::Readback).unwrap();
    let commands = Commands::begin(device).unwrap();
    capture.record_cull(&commands, 3);
    barrier::full(&commands);
    capture.record(&commands, geometry, None, 3);
    commands.copy_image(image, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, &readback);
    commands.finish().unwrap();
    readback.read(texels as usize)
}

#[test]
fn multi_view_draws_and_culled_views_see_the_same() {
    let device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    let scene = crate::scene::cornell();
    let geometry = Geometry::new(&device, &scene, &CellBudget::even(1000), None).unwrap();
    let whole = identities(&device, &geometry, &scene, false);
    let culled = identities(&device, &geometry, &scene, true);
    for layer in 0..5 {
        let of = |all: &[u32]| all[layer * 1024..(layer + 1) * 1024].to_vec();
        let seen = |all: &[u32]| of(all).iter().filter(|i| **i != 0).count();
        assert!(layer == 3 || seen(&culled) > 3 * 80, "face {layer} sees the box");
    }
    assert!(whole == culled);
    assert_eq!(device.instance.validation_messages(), 0);
}

/// Walls and floor go on behind the eye: every view cuts some. A corner that is made where a side is cut is rounded, so
/// that a texel whose centre is as near to an edge may fall to its other side.
#[test]
fn triangles_cut_to_the_view_look_the_same() {
    let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    let mut scene = crate::scene::cornell();
    for masked in [false, true] {
        scene.materials.iter_mut().for_each(|material| material.alpha_cutoff = masked.then_some(0.5));
        for culled in [false, true] {
            let [whole, fans] = [true, false].map(|clips| {
                Arc::get_mut(&mut device).unwrap().capabilities.clips_before_setup = clips;
                let geometry = Geometry::new(&device, &scene, &CellBudget::even(1000), None).unwrap();
                identities(&device, &geometry, &scene, culled)
            });
            let differ = whole.iter().zip(&fans).filter(|(a, b)| a != b).count();
            assert!(whole.iter().filter(|i| **i != 0).count() > 1000);
            assert!(differ <= 2, "{differ} texels differ; masked: {masked}, culled: {culled}");
        }
    }
    assert_eq!(device.instance.validation_messages(), 0);
}

//! Each capability by force, on whatever driver runs the tests: what a device has or lacks changes paths, not pictures.
//! The table that this prints is in `src/guide/capabilities.md`.

use crate::common::build::{Builder, Facing, diffuse};
use crate::common::{look, small};
use glam::{Mat3, Vec3, dvec3, vec3};
use hemicube::methods::captures::CaptureMode;
use hemicube::renderer::render;
use hemicube::scene::{Background, Camera, Light, Material, Scene, TextureRef, cornell};
use hemicube::vk::{Device, DeviceOptions, Instance};
use std::sync::Arc;

/// Lists for HEMICUBE_FORCE, one a row.
const FORCED: [&str; 9] = [
    "primitive_id=off",
    "multiview_draws=off",
    "draw_indirect_count=off",
    "multi_draw_indirect=off",
    "clips_before_setup=off",
    "logic_op=off",
    "subgroup=none",
    "shared_memory=16384",
    "invocations=128",
];

/// Mean difference of the irradiance, relative to its mean, that rounding at edges may make.
const TOLERANCE: f64 = 0.02;

fn open(list: &str) -> Option<Arc<Device>> {
    let options = DeviceOptions { forced: list.parse().expect("a list"), ..DeviceOptions::default() };
    match Device::open(Instance::new(true).expect("Vulkan and its validation"), &options) {
        Ok(device) => Some(device),
        Err(error) => {
            eprintln!("{list}: not on this driver: {error}");
            None
        }
    }
}

/// A box with a texture, a masked screen and a light; the same without them under a sky.
fn room(sky: bool) -> (Scene, Camera) {
    let mut b = Builder::default();
    let texels = |a: [u8; 4], c: [u8; 4]| (0..64).map(|i| if (i + i / 8) % 2 == 0 { a } else { c }).collect::<Vec<_>>();
    let map = |texture| Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let colours = b.texture(8, 8, texels([220, 180, 60, 255], [60, 90, 200, 255]), false);
    let holes = b.texture(8, 8, texels([255; 4], [255, 255, 255, 0]), true);
    let tiles = b.material(Material { base_texture: map(colours), ..diffuse(0.8) });
    let grid = b.material(Material { base_texture: map(holes), alpha_cutoff: Some(0.5), ..diffuse(0.6) });
    if sky {
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 3.0);
        b.sphere(tiles, vec3(0.0, 0.5, 0.0), 0.5, 16, Facing::Out);
        b.background(Background::Constant(Vec3::ONE));
    } else {
        b.cuboid(tiles, vec3(-3.0, 0.0, -3.0), vec3(3.0, 3.0, 3.0), Facing::In);
        b.floor(grid, 0.5, 3.0);
        b.light(Light::Point { position: vec3(1.0, 2.0, 0.5), intensity: Vec3::splat(3.0) });
    }
    (b.build(), look(dvec3(2.5, 1.2, 2.5), dvec3(0.0, 0.8, 0.0), 80.0))
}

fn irradiance(device: &Arc<Device>, (scene, camera): &(Scene, Camera), capture: CaptureMode) -> Vec<f32> {
    let mut settings = small(24);
    (settings.cache.capture, settings.cache.capture_size, settings.cache.accuracy) = (capture, 16, 0.6);
    let rendered = render(device, scene, camera, &settings, &mut |_, _, _| {}).expect("a frame");
    assert_eq!(device.instance.validation_messages(), 0, "validation messages; they are printed above");
    let channels = rendered.picture.channels.into_iter().filter(|(name, _)| name.starts_with("irradiance."));
    let values: Vec<f32> = channels.flat_map(|(_, values)| values).collect();
    assert!(!values.is_empty());
    values
}

#[test]
fn forced_capabilities_make_the_same_pictures() {
    let cornell = cornell();
    let camera = cornell.cameras[0].clone();
    let scenes = [("Cornell", (cornell, camera)), ("masked, textured", room(false)), ("sky", room(true))];
    let modes = [CaptureMode::Hemicube, CaptureMode::Auto];
    let plain = open("").expect("a device");
    let all = |device: &Arc<Device>| {
        scenes.iter().flat_map(|(_, of)| modes.map(|mode| irradiance(device, of, mode))).collect::<Vec<_>>()
    };
    let expected = all(&plain);
    for list in FORCED {
        let Some(device) = open(list) else { continue };
        let mut row = format!("| `{list}` |");
        for (a, b) in expected.iter().zip(all(&device)) {
            let total: f64 = a.iter().map(|v| f64::from(v.abs())).sum();
            let off: f64 = a.iter().zip(&b).map(|(a, b)| f64::from((a - b).abs())).sum();
            row += &format!(" {:.2} % |", 100.0 * off / total);
            assert!(off <= TOLERANCE * total, "{row}");
        }
        eprintln!("{row}");
    }
}

//! Changes that must not change the light.

use super::difference;
use crate::common::{picture, small};
use glam::{DVec3, vec3};
use hemicube::scene::{Camera, Light, Limits, Scene, cornell, load_from_slice};

/// Every length times `scale`, also of the scene's own cameras, near which its cells are finer.
fn scaled(scene: &Scene, camera: &Camera, scale: f32) -> (Scene, Camera) {
    let (mut scene, mut camera) = (scene.clone(), camera.clone());
    scene.positions.iter_mut().for_each(|p| *p *= scale);
    for light in &mut scene.lights {
        if let Light::Point { position, intensity } | Light::Spot { position, intensity, .. } = light {
            *position *= scale;
            *intensity *= scale * scale;
        }
    }
    for camera in scene.cameras.iter_mut().chain([&mut camera]) {
        camera.camera_to_world.w_axis *= DVec3::splat(f64::from(scale)).extend(1.0);
    }
    (scene, camera)
}

#[test]
fn the_size_of_the_world_changes_no_bit() {
    let mut scene = cornell();
    scene.lights.push(Light::Point { position: vec3(0.1, 0.3, 0.2), intensity: vec3(0.1, 0.2, 0.3) });
    let camera = scene.cameras[0].clone();
    let reference = picture(&scene, &camera, &small(64));
    for power in [10, -10] {
        let scale = 2f32.powi(power);
        let (scene, camera) = scaled(&scene, &camera, scale);
        let mut scaled = picture(&scene, &camera, &small(64));
        for channel in ["P.X", "P.Y", "P.Z", "Z"] {
            scaled.channels.get_mut(channel).unwrap().iter_mut().for_each(|v| *v /= scale);
        }
        crate::common::assert_same_bits(&scaled, &reference, &format!("world × 2^{power}"));
    }
}

#[test]
fn the_strength_of_the_light_scales_the_image_exactly() {
    let scene = cornell();
    let camera = scene.cameras[0].clone();
    let reference = picture(&scene, &camera, &small(64));
    for power in [12, -12] {
        let scale = 2f32.powi(power);
        let mut brighter = scene.clone();
        brighter.materials.iter_mut().for_each(|m| m.emission *= scale);
        let mut scaled = picture(&brighter, &camera, &small(64));
        let light = ["R", "G", "B", "direct.", "indirect.", "irradiance", "emission."];
        for (name, values) in &mut scaled.channels {
            if light.iter().any(|l| name == l || (l.len() > 1 && name.starts_with(l))) {
                values.iter_mut().for_each(|v| *v /= scale);
            }
        }
        crate::common::assert_same_bits(&scaled, &reference, &format!("emission × 2^{power}"));
    }
}

/// The Cornell box's file with its root nodes below one more.
fn cornell_below(node: serde_json::Value) -> Scene {
    let mut file: serde_json::Value = serde_json::from_slice(include_bytes!("../../../assets/cornell.gltf")).unwrap();
    let scene = &mut file["scenes"][0]["nodes"];
    let roots = scene.take();
    let nodes = file["nodes"].as_array_mut().unwrap();
    let mut top = node;
    top["children"] = roots;
    nodes.push(top);
    let index = nodes.len() - 1;
    file["scenes"][0]["nodes"] = serde_json::json!([index]);
    let nothing = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    load_from_slice("below.gltf", &serde_json::to_vec(&file).unwrap(), &nothing, Limits::default()).unwrap()
}

#[test]
fn a_negative_scale_mirrors_the_image() {
    let scene = cornell();
    let reference = picture(&scene, &scene.cameras[0], &small(96));
    let mirrored = cornell_below(serde_json::json!({"scale": [-1.0, 1.0, 1.0]}));
    let mut camera = scene.cameras[0].clone();
    camera.camera_to_world.w_axis.x *= -1.0;
    let mut flipped = picture(&mirrored, &camera, &small(96));
    flipped.channels.values_mut().for_each(|plane| plane.chunks_mut(96).for_each(<[f32]>::reverse));
    let direct = difference(&flipped, &reference, "irradiance_direct");
    let indirect = difference(&flipped, &reference, "irradiance");
    eprintln!("mirrored: direct {:.3} %, indirect {:.3} %", direct.mae * 100.0, indirect.mae * 100.0);
    // Shadow edges move by a texel; hemicubes are turned otherwise.
    assert!(direct.mae < 0.01 && (direct.energy.unwrap() - 1.0).abs() < 0.005, "{direct:?}");
    assert!(indirect.mae < 0.03 && (indirect.energy.unwrap() - 1.0).abs() < 0.01, "{indirect:?}");
}

#[test]
fn far_from_zero_the_light_stays() {
    let scene = cornell();
    let reference = picture(&scene, &scene.cameras[0], &small(96));
    let far = cornell_below(serde_json::json!({"translation": [1e5, 0.0, -1e5]}));
    assert!(far.origin.length() > 1e5);
    let moved = picture(&far, &far.cameras[0], &small(96));
    let direct = difference(&moved, &reference, "irradiance_direct");
    let indirect = difference(&moved, &reference, "irradiance");
    eprintln!("far: direct {:.3} %, indirect {:.3} %", direct.mae * 100.0, indirect.mae * 100.0);
    assert!(direct.mae < 0.01 && (direct.energy.unwrap() - 1.0).abs() < 0.005, "{direct:?}");
    assert!(indirect.mae < 0.03 && (indirect.energy.unwrap() - 1.0).abs() < 0.01, "{indirect:?}");
    let (a, b) = (moved.xyz("P").unwrap(), reference.xyz("P").unwrap());
    let ulp = 2f64.powi(-7);
    let close = |axis: usize, offset: f32| {
        a[axis]
            .iter()
            .zip(b[axis])
            .all(|(a, b)| *a == 0.0 || (f64::from(*a) - f64::from(offset) - f64::from(*b)).abs() <= ulp)
    };
    assert!(close(0, 1e5) && close(1, 0.0) && close(2, -1e5), "positions are the file's");
}

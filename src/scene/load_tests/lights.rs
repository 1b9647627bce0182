use super::*;
use crate::scene::{Lens, Light};
use std::f32::consts::FRAC_PI_4;

/// A triangle and a node that carries `light`, turned so that −z is −y, at (0, 2, 0).
fn lit(light: Value) -> Light {
    let mut file = File::triangle().set("/scenes/0/nodes", json!([0, 1]));
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let node = json!({"translation": [0, 2, 0], "rotation": [-h, 0, 0, h], "scale": [3, 3, 3],
        "extensions": {"KHR_lights_punctual": {"light": 0}}});
    file.push("nodes", node);
    let file = file.set("/extensions", json!({"KHR_lights_punctual": {"lights": [light]}}));
    file.set("/extensionsRequired", json!(["KHR_lights_punctual"])).load().lights[0]
}

#[test]
fn lights_stand_at_their_node_and_shine_along_minus_z() {
    let light = lit(json!({"type": "directional", "color": [1, 0.5, 0], "intensity": 4, "range": 1}));
    let Light::Directional { direction, irradiance } = light else { panic!("{light:?}") };
    assert!(close(direction, Vec3::NEG_Y) && irradiance == Vec3::new(4.0, 2.0, 0.0), "{light:?}");
    let light = lit(json!({"type": "point"}));
    let Light::Point { position, intensity } = light else { panic!("{light:?}") };
    assert!(close(position, Vec3::new(0.0, 2.0, 0.0)) && intensity == Vec3::ONE);
    let light = lit(json!({"type": "spot", "spot": {"innerConeAngle": 0.25}}));
    let Light::Spot { direction, cos_inner, cos_outer, .. } = light else { panic!("{light:?}") };
    assert!(close(direction, Vec3::NEG_Y));
    assert!((cos_inner - 0.25f64.cos()).abs() < 1e-6 && (cos_outer - f64::from(FRAC_PI_4).cos()).abs() < 1e-6);
}

#[test]
fn a_hair_thin_cone_still_has_an_edge() {
    let light = lit(json!({"type": "spot", "spot": {"innerConeAngle": 0, "outerConeAngle": 1e-6}}));
    let Light::Spot { cos_inner, cos_outer, .. } = light else { panic!("{light:?}") };
    assert!(cos_outer < cos_inner);
}

fn camera(camera: Value, node: Value) -> Scene {
    let mut file = File::triangle().set("/scenes/0/nodes", json!([0, 1]));
    file.push("cameras", camera);
    file.push("nodes", node);
    file.load()
}

#[test]
fn cameras_are_rigid_and_named() {
    let lens =
        json!({"name": "lens", "type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1.5, "znear": 1}});
    let scene = camera(lens.clone(), json!({"camera": 0, "scale": [-2, 3, 4], "translation": [1, 2, 3]}));
    let camera_to_world = scene.cameras[0].camera_to_world;
    assert_eq!(camera_to_world, glam::DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)), "no scale, no mirror");
    assert_eq!(
        (scene.cameras[0].name.as_str(), scene.cameras[0].lens),
        ("lens", Lens::Perspective { yfov: 0.5, aspect: Some(1.5) })
    );
    assert_eq!(camera(lens.clone(), json!({"camera": 0, "name": "node"})).cameras[0].name, "node");
    let flat = camera(lens, json!({"camera": 0, "scale": [1, 1, 0]}));
    assert!(flat.cameras.is_empty() && flat.notes[0].contains("camera 0"), "{:?}", flat.notes);
}

#[test]
fn orthographic_cameras_give_half_heights_and_a_shape() {
    let lens = json!({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0, "zfar": 9}});
    assert_eq!(camera(lens, json!({"camera": 0})).cameras[0].lens, Lens::Orthographic { ymag: 2.0, aspect: Some(1.5) });
}

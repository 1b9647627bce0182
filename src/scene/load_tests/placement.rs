use super::*;
use glam::DQuat;

#[test]
fn transforms_compose_in_double_precision() {
    let file = File::triangle().set("/nodes/0", json!({"mesh": 0, "translation": [0, 1e-4, 0], "scale": [2, 2, 2]}));
    let quarter = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let mut file = file.set("/scenes/0/nodes", json!([1]));
    file.push("nodes", json!({"children": [0], "translation": [0, 0, 1], "rotation": quarter.to_array()}));
    let scene = file.load();
    assert!(close(scene.positions[0], Vec3::new(0.0, 0.0, 1.0001)), "{:?}", scene.positions);
    assert!(close(scene.positions[2], Vec3::new(0.0, 0.0, 3.0001)));
    assert!(close(scene.normals[0], Vec3::NEG_Y));
    let matrix = glam::DMat4::from_scale_rotation_translation(DVec3::splat(2.0), quarter, DVec3::new(0.0, 0.0, 1.0));
    let same = File::triangle().set("/nodes/0/matrix", json!(matrix.to_cols_array().to_vec())).load();
    assert!(close(same.positions[2], Vec3::new(0.0, 0.0, 3.0)));
}

#[test]
fn mirroring_keeps_the_front_in_front() {
    for (scale, front) in [([-1, 1, 1], DVec3::Z), ([1, 1, -1], DVec3::NEG_Z), ([-1, -1, -1], DVec3::NEG_Z)] {
        let file = File::triangle().attribute("NORMAL", &[[0.0, 0.0, 1.0]; 3]).set("/nodes/0/scale", json!(scale));
        let scene = file.load();
        assert_eq!(area_vector(&scene), 0.5 * front, "{scale:?}");
        assert_eq!(scene.normals[0].as_dvec3(), front, "{scale:?}");
    }
}

#[test]
fn normals_follow_uneven_scale() {
    let n = Vec3::new(1.0, 1.0, 0.0).normalize().to_array();
    let scene = File::triangle().attribute("NORMAL", &[n; 3]).set("/nodes/0/scale", json!([2, 1, 1])).load();
    assert!(close(scene.normals[0], Vec3::new(1.0, 2.0, 0.0).normalize()));
    let flat =
        File::triangle().attribute("NORMAL", &[[0.1, 0.0, 1.0]; 3]).set("/nodes/0/scale", json!([1, 1, 0])).load();
    assert_eq!(flat.normals[0], Vec3::Z);
    let tiny = File::triangle().attribute("NORMAL", &[n; 3]).set("/nodes/0/scale", json!([2e-30, 1e-30, 1e-30])).load();
    assert_eq!(tiny.normals[0], scene.normals[0]);
}

#[test]
fn the_default_scene_is_shown_else_the_first() {
    let mut file = File::triangle();
    file.push("nodes", json!({"mesh": 0, "translation": [5, 0, 0]}));
    file.push("scenes", json!({"nodes": [1]}));
    assert_eq!(file.load().positions[0], Vec3::ZERO);
    let second = file.set("/scene", json!(1));
    assert_eq!(second.load().positions[0], Vec3::new(5.0, 0.0, 0.0));
    let mut all = second;
    all.document.as_object_mut().unwrap().retain(|key, _| key != "scene" && key != "scenes");
    assert_eq!(all.load().triangles.len(), 2);
}

#[test]
fn a_distant_scene_is_moved_to_its_centre() {
    let mut file = File::triangle().set("/nodes/0/translation", json!([1e6, 0.25, -3e6]));
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    file.push("nodes", json!({"camera": 0, "translation": [1e6, 0.25, -2_999_997.75]}));
    file.document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    file.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [1e6, 2.25, -3e6]}));
    let scene = file.set("/scenes/0/nodes", json!([0, 1, 2])).load();
    assert_eq!(scene.origin, DVec3::new(1_000_000.5, 0.75, -3e6));
    assert_eq!(scene.positions[0], Vec3::new(-0.5, -0.5, 0.0));
    assert_eq!(scene.cameras[0].camera_to_world.w_axis.truncate(), DVec3::new(-0.5, -0.5, 2.25));
    let crate::scene::Light::Point { position, .. } = scene.lights[0] else { panic!("a point light") };
    assert_eq!(position, Vec3::new(-0.5, 1.5, 0.0));
    assert_eq!(File::triangle().set("/nodes/0/translation", json!([7, 0, 0])).load().origin, DVec3::ZERO);
}

#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let place = |k: f64| {
        let (t, s) = ([1000.1 * k, 0.3 * k, 77.7 * k], [0.7 * k, 1.1 * k, 1.3 * k]);
        let rotation = DQuat::from_rotation_y(0.4).to_array();
        File::triangle().set("/nodes/0", json!({"mesh": 0, "translation": t, "scale": s, "rotation": rotation})).load()
    };
    let one = place(1.0);
    assert_ne!(one.origin, DVec3::ZERO);
    for exponent in [-40, 40] {
        let k = f64::from(exponent).exp2();
        let scaled = place(k);
        assert_eq!(scaled.origin, one.origin * k);
        assert!(scaled.positions.iter().zip(&one.positions).all(|(a, b)| *a == *b * k as f32));
        assert_eq!(scaled.normals, one.normals);
    }
}

#[test]
fn gpu_instances_stand_under_their_node() {
    let mut file = File::triangle();
    let translation = file.floats(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    let scale = file.floats(&[[1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]);
    file.document["nodes"][0]["translation"] = json!([0, 0, 1]);
    file.document["nodes"][0]["extensions"] = json!({
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation, "SCALE": scale}}
    });
    let scene = file.set("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"])).load();
    assert_eq!(scene.triangles.len(), 2);
    assert_eq!(area_vector(&scene), DVec3::new(0.0, 0.0, 2.5));
    assert!(close(scene.positions[4], Vec3::new(5.0, 0.0, 1.0)));
}

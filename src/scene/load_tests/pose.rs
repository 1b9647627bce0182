use super::*;
use crate::scene::Light;
use std::f64::consts::FRAC_1_SQRT_2;

impl File {
    fn load_at(&self, pose: Pose) -> std::result::Result<Scene, SceneError> {
        let options = Options { pose, ..Options::default() };
        load_from_slice("test.glb", &self.glb(), &no_files, options)
    }

    fn at(&self, seconds: f64) -> Scene {
        self.load_at(Pose { seconds: Some(seconds), animation: None }).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Adds an animation of one channel.
    fn animate<const N: usize>(
        mut self,
        node: usize,
        path: &str,
        interpolation: &str,
        times: &[f32],
        values: &[[f32; N]],
    ) -> Self {
        let times: Vec<[f32; 1]> = times.iter().map(|t| [*t]).collect();
        let (input, output) = (self.floats(&times), self.floats(values));
        let channel = json!({"sampler": 0, "target": {"node": node, "path": path}});
        let sampler = json!({"input": input, "output": output, "interpolation": interpolation});
        self.push("animations", json!({"name": path, "channels": [channel], "samplers": [sampler]}));
        self
    }

    /// Binds the triangle's vertices to joints, by weight.
    fn skinned(mut self, joints: [[u8; 4]; 3], weights: [[f32; 4]; 3]) -> Self {
        let accessor = self.accessor(joints.as_flattened(), 5121, 3, "VEC4");
        self.primitive()["attributes"]["JOINTS_0"] = json!(accessor);
        self.attribute("WEIGHTS_0", &weights)
    }
}

/// Nodes: 0 the triangle, under 3; 1 a joint; 2 another; 3 a node whose transform must not count.
fn two_joints(weights: [[f32; 4]; 3]) -> File {
    let mut file = File::triangle().skinned([[0, 1, 0, 0]; 3], weights).set("/nodes/0/skin", json!(0));
    file.push("nodes", json!({"translation": [0, 0, 1], "scale": [2, 2, 2]}));
    file.push("nodes", json!({"translation": [4, 0, 1], "scale": [2, 2, 2]}));
    file.push("nodes", json!({"children": [0], "scale": [100, 100, 100], "translation": [0, 7, 0]}));
    let half: [f32; 16] = glam::Mat4::from_scale(Vec3::splat(0.5)).to_cols_array();
    let view = file.view(bytemuck::cast_slice(&[half, half]));
    let matrices =
        file.push("accessors", json!({"bufferView": view, "componentType": F32, "count": 2, "type": "MAT4"}));
    file.push("skins", json!({"joints": [1, 2], "inverseBindMatrices": matrices}));
    file.set("/scenes/0/nodes", json!([1, 2, 3]))
}

#[test]
fn a_skinned_mesh_stands_where_its_joints_are() {
    let scene = two_joints([[1.0, 0.0, 0.0, 0.0]; 3]).load();
    assert_eq!(scene.positions, [Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)]);
    let scene = two_joints([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]]).load();
    assert_eq!(scene.positions, [Vec3::Z, Vec3::new(5.0, 0.0, 1.0), Vec3::new(2.0, 1.0, 1.0)]);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn joints_outside_the_scene_count_and_weights_are_scaled() {
    let file = two_joints([[0.5, 0.0, 0.0, 0.0], [0.0; 4], [1.0, 0.0, 0.0, 0.0]]).set("/scenes/0/nodes", json!([3]));
    let scene = file.load();
    assert_eq!(scene.positions, [Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)]);
    assert_eq!(scene.notes, ["joint weights whose sum is not 1 are scaled to it (2×)"]);
}

#[test]
fn joints_turn_normals_and_mirror_triangles() {
    let file = two_joints([[1.0, 0.0, 0.0, 0.0]; 3]).attribute("NORMAL", &[[0.0, 0.0, 1.0]; 3]);
    let turned = file.set("/nodes/1", json!({"rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2]})).load();
    assert!(close(turned.normals[0], Vec3::X) && close(turned.geometric_normal(0), Vec3::X), "{:?}", turned.normals);
    let file = two_joints([[1.0, 0.0, 0.0, 0.0]; 3]).attribute("NORMAL", &[[0.0, 0.0, 1.0]; 3]);
    let mirrored = file.set("/nodes/1", json!({"scale": [-1, 1, 1]})).load();
    assert_eq!((mirrored.normals[0], mirrored.geometric_normal(0)), (Vec3::Z, Vec3::Z));
}

#[test]
fn broken_skins_are_refused_and_missing_joints_noted() {
    let whole = [[0.5, 0.5, 0.0, 0.0]; 3];
    let cases = [
        (two_joints(whole).set("/nodes/0/skin", json!(4)), "skin 4"),
        (two_joints(whole).set("/skins/0/joints", json!([1])), "joint 1"),
        (two_joints(whole).set("/skins/0/joints", json!([1, 99])), "joint node 99"),
        (two_joints(whole).set("/skins/0/joints", json!([1, 2, 3])), "fewer inverse bind matrices"),
    ];
    for (file, words) in cases {
        let line = file.try_load().unwrap_err().to_string();
        assert!(line.contains(words) && line.contains("node 0"), "{line}");
    }
    let mut without = two_joints(whole);
    without.primitive()["attributes"].as_object_mut().unwrap().remove("JOINTS_0");
    let scene = without.load();
    assert_eq!(scene.positions[1], Vec3::new(100.0, 7.0, 0.0));
    assert_eq!(scene.notes, ["meshes with a skin but without joints stand at their node"]);
}

fn morphing() -> File {
    let mut file = File::triangle();
    let up = file.floats(&[[0.0, 0.0, 2.0]; 3]);
    let wide = file.floats(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
    file.primitive()["targets"] = json!([{"POSITION": up}, {"POSITION": wide}]);
    file
}

#[test]
fn morph_targets_add_up_by_the_weights_of_node_or_mesh() {
    assert_eq!(morphing().load().positions[1], Vec3::X);
    let of_mesh = morphing().set("/meshes/0/weights", json!([0.5, 1]));
    assert_eq!(of_mesh.load().positions, [Vec3::Z, Vec3::new(4.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)]);
    let of_node = of_mesh.set("/nodes/0/weights", json!([0, 2]));
    assert_eq!(of_node.load().positions[1], Vec3::new(7.0, 0.0, 0.0));
}

#[test]
fn keys_are_held_mixed_or_splined() {
    let step = File::triangle().animate(0, "translation", "STEP", &[1.0, 2.0], &[[1.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
    assert_eq!([0.0, 1.0, 1.9, 2.0, 9.0].map(|t| step.at(t).positions[0].x), [1.0, 1.0, 1.0, 5.0, 5.0]);
    let linear = File::triangle().animate(0, "translation", "LINEAR", &[1.0, 2.0], &[[1.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
    assert_eq!([0.0, 1.25, 1.5, 7.0].map(|t| linear.at(t).positions[0].x), [1.0, 2.0, 3.0, 5.0]);
    // p(t) = t³ over two seconds: 0 with slope 0, 8 with slope 12.
    let keys = [[0.0; 3], [0.0; 3], [0.0; 3], [12.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0; 3]];
    let cubic = File::triangle().animate(0, "translation", "CUBICSPLINE", &[0.0, 2.0], &keys);
    for t in [0.0, 0.5, 1.0, 1.5, 2.0] {
        let scene = cubic.at(t);
        let x = scene.origin.x + f64::from(scene.positions[0].x);
        assert!((x - t.powi(3)).abs() < 1e-6, "{x} at {t}");
    }
    assert!(cubic.load().positions[0].x == 0.0 && cubic.load().notes[0].contains("--time"));
    assert!(cubic.at(1.0).notes.is_empty());
}

#[test]
fn turns_take_the_short_way_at_even_speed() {
    // A quarter turn about z, its end written with the opposite sign.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let keys = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -half, -half]];
    let file = File::triangle().animate(0, "rotation", "LINEAR", &[0.0, 3.0], &keys);
    let expected = Vec3::new(30f32.to_radians().cos(), 30f32.to_radians().sin(), 0.0);
    assert!(close(file.at(1.0).positions[1], expected), "{:?}", file.at(1.0).positions);
}

#[test]
fn animated_weights_lights_cameras_and_joints_move() {
    let file = morphing().animate(0, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [0.0], [1.0], [1.0]]);
    assert_eq!(file.at(0.5).positions[1], Vec3::new(2.5, 0.0, 1.0));
    let file = two_joints([[1.0, 0.0, 0.0, 0.0]; 3]).animate(1, "translation", "LINEAR", &[0.0], &[[0.0, 0.0, 8.0]]);
    assert_eq!(file.at(0.0).positions[0], Vec3::new(0.0, 0.0, 8.0));
    let mut file = File::triangle().animate(1, "translation", "LINEAR", &[0.0], &[[0.0, 0.0, 8.0]]);
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    file.document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    file.push("nodes", json!({"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    let scene = file.set("/scenes/0/nodes", json!([0, 1])).at(1.0);
    assert_eq!(scene.cameras[0].camera_to_world.w_axis.truncate(), 8.0 * DVec3::Z);
    assert!(matches!(scene.lights[0], Light::Point { position, .. } if position == 8.0 * Vec3::Z));
}

#[test]
fn animations_are_chosen_by_name_or_index() {
    let file = File::triangle().animate(0, "translation", "STEP", &[0.0], &[[1.0, 0.0, 0.0]]).animate(
        0,
        "scale",
        "STEP",
        &[0.5],
        &[[3.0, 1.0, 1.0]],
    );
    let at = |name: &str| file.load_at(Pose { animation: Some(name.into()), seconds: None });
    assert_eq!(at("scale").unwrap().positions[1], Vec3::new(3.0, 0.0, 0.0));
    assert_eq!(at("0").unwrap().positions[1], Vec3::new(2.0, 0.0, 0.0));
    let line = at("walk").unwrap_err().to_string();
    assert!(line.contains("there are 0 \"translation\", 1 \"scale\""), "{line}");
    let lengths: Vec<_> = file.load().animations.iter().map(|a| (a.name.clone(), a.seconds)).collect();
    assert_eq!(lengths, [("translation".to_owned(), 0.0), ("scale".to_owned(), 0.5)]);
    let none = File::triangle().load_at(Pose { animation: None, seconds: Some(1.0) }).unwrap_err().to_string();
    assert!(none.contains("no animations"), "{none}");
}

#[test]
fn pointers_to_nodes_are_followed_and_others_named() {
    let mut file = File::triangle().animate(0, "translation", "STEP", &[0.0], &[[1.0, 0.0, 0.0]]);
    let target = |to: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": to}}});
    file = file.set("/animations/0/channels/0/target", target("/nodes/0/translation"));
    assert_eq!(file.at(0.0).positions[0], Vec3::X);
    file = file.set("/animations/0/channels/0/target", target("/materials/0/alphaCutoff"));
    let notes = file.at(0.0).notes;
    assert_eq!(notes, ["KHR_animation_pointer: the animation of /materials/0/alphaCutoff is left out"]);
}

#[test]
fn broken_animations_are_refused_only_when_shown() {
    let base = || File::triangle().animate(0, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3]; 2]);
    let cases = [
        base().set("/animations/0/samplers/0/interpolation", json!("CUBICSPLINE")),
        base().set("/animations/0/channels/0/sampler", json!(3)),
        base().set("/animations/0/channels/0/target/node", json!(9)),
        base().set("/animations/0/samplers/0/output", json!(77)),
        base().set("/animations/0", json!(5)),
    ];
    for file in cases {
        let line = file.load_at(Pose { seconds: Some(0.5), animation: None }).unwrap_err().to_string();
        assert!(line.contains("animation 0"), "{line}");
        file.load();
    }
}

//! Sequences of frames.

use super::folder;
use crate::common::gltf::{data_uri, triangle};
use crate::common::program::hemicube;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn frames(folder: &Path) -> Vec<Value> {
    let stats: Value = serde_json::from_slice(&fs::read(folder.join("s.json")).unwrap()).unwrap();
    stats["frames"].as_array().unwrap().clone()
}

#[test]
fn a_camera_that_stands_still_shows_the_same_for_no_record_more() {
    let folder = folder();
    let run = hemicube(
        folder.path(),
        "render -q -o f.exr --frames 3-5 --orbit 0 --width 32 --height 32 --stats s.json --validate",
    );
    assert!(run.code == 0 && run.out.is_empty() && run.err.is_empty(), "{run:?}");
    let rows = frames(folder.path());
    let count = |key: &str| rows.iter().map(|row| row[key].as_u64().unwrap()).collect::<Vec<_>>();
    let all = count("records")[0];
    assert!(all > 0);
    assert_eq!(
        (count("frame"), count("records"), count("reused")),
        (vec![3, 4, 5], vec![all, 0, 0], vec![0, all, all])
    );
    let file = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(file("f.0003.exr") == file("f.0004.exr") && file("f.0004.exr") == file("f.0005.exr"));
}

#[test]
fn an_orbit_turns_about_the_middle_and_a_walk_follows_its_keys() {
    let folder = folder();
    let walk = json!({"keys": [
        {"time": 0, "eye": [0.28, 0.27, -0.8], "target": [0.28, 0.27, 0]},
        {"time": 2, "eye": [0.4, 0.27, -0.7], "target": [0.28, 0.27, 0]},
    ]});
    fs::write(folder.path().join("w.json"), walk.to_string()).unwrap();
    let common = "--frames 0-2 --fps 1 --width 24 --height 24 --stats s.json";
    for way in ["--orbit 10", "--walk w.json"] {
        let run = hemicube(folder.path(), &format!("render -o f_%02d.png {common} {way}"));
        assert!(run.is_clean(), "{run:?}");
        assert_eq!(run.err.matches("exposure +").count(), 1, "one exposure for all frames: {run:?}");
        let file = |name: &str| fs::read(folder.path().join(name)).unwrap();
        assert!(
            file("f_00.png") != file("f_01.png") && file("f_01.png") != file("f_02.png"),
            "{way}: the camera moves"
        );
        assert!(frames(folder.path())[2]["reused"].as_u64().unwrap() > 0);
    }
}

/// A triangle before a camera that moves along X from second 0 to 1, or that moves itself.
fn animated(moves_camera: bool) -> Value {
    let z = if moves_camera { 3.0 } else { -1.0 };
    let numbers: Vec<u8> = [0.0_f32, 1.0, 0.0, 0.0, z, 0.5, 0.0, z].iter().flat_map(|x| x.to_le_bytes()).collect();
    triangle(|document| {
        let push = |document: &mut Value, list: &str, value: Value| {
            if document[list].is_null() {
                document[list] = json!([]);
            }
            let list = document[list].as_array_mut().unwrap();
            list.push(value);
            list.len() - 1
        };
        let buffer = push(document, "buffers", json!({"byteLength": numbers.len(), "uri": data_uri(&numbers)}));
        let view = |offset, length| json!({"buffer": buffer, "byteOffset": offset, "byteLength": length});
        let times = push(document, "bufferViews", view(0, 8));
        let places = push(document, "bufferViews", view(8, 24));
        let accessor = |view, kind| json!({"bufferView": view, "componentType": 5126, "count": 2, "type": kind, "min": [0.0], "max": [1.0]});
        let input = push(document, "accessors", accessor(times, "SCALAR"));
        let mut output = accessor(places, "VEC3");
        output.as_object_mut().unwrap().retain(|key, _| key != "min" && key != "max");
        let output = push(document, "accessors", output);
        push(document, "cameras", json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}));
        let camera = push(document, "nodes", json!({"camera": 0, "translation": [0, 0, 3]}));
        document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(camera));
        let node = if moves_camera { camera } else { 0 };
        push(
            document,
            "animations",
            json!({
                "samplers": [{"input": input, "output": output}],
                "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}],
            }),
        );
    })
}

#[test]
fn frames_follow_the_animation_of_the_file() {
    for moves_camera in [true, false] {
        let folder = folder();
        fs::write(folder.path().join("m.gltf"), animated(moves_camera).to_string()).unwrap();
        let common = "--width 24 --height 24 --background 1,1,1 --layers N,Z";
        let run =
            hemicube(folder.path(), &format!("render m.gltf -o f.exr --frames 0-2 --fps 2 --stats s.json {common}"));
        assert!(run.is_clean(), "{run:?}");
        assert_eq!(run.err.contains("geometry changed"), !moves_camera, "{run:?}");
        let last = hemicube(folder.path(), &format!("render -q m.gltf -o one.exr --time 1 {common}"));
        assert_eq!(last.code, 0, "{last:?}");
        let depth = |name: &str| {
            let picture = hemicube::image::exr::read(&folder.path().join(name)).unwrap();
            picture.scalar("Z").unwrap().to_vec()
        };
        assert!(depth("f.0002.exr") == depth("one.exr") && depth("f.0000.exr") != depth("one.exr"));
    }
}

#[test]
fn sequences_without_a_way_are_refused() {
    let folder = folder();
    fs::write(folder.path().join("w.json"), r#"{"keys": [{"time": 1, "eye": [0, 0, 0], "target": [0, 0, 1]}, {"time": 1, "eye": [0, 0, 0], "target": [0, 0, 1]}]}"#)
        .unwrap();
    for (flags, words) in [
        ("--frames 0-2", "no animation to follow"),
        ("--frames 2-0 --orbit 1", "comes after"),
        ("--frames 0-2 --walk w.json", "key 1 is not later"),
        ("--frames 0-2 --walk none.json", "cannot read the walk"),
        ("--frames 0-2 --orbit 1 --fps 0", "not a positive number"),
        ("--orbit 1", "--frames"),
    ] {
        let run = hemicube(folder.path(), &format!("render -o f.exr {flags}"));
        assert!(run.code == 2 && run.err.contains(words), "{flags}: {run:?}");
    }
}

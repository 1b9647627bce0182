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

/// A triangle before a camera and a lamp; the `mover` among them moves along X from second 0 to 1.
fn animated(mover: &str) -> Value {
    let z = if mover == "triangle" { -1.0 } else { 3.0 };
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
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 9}]}});
        document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        let lamp = json!({"translation": [0, 0, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}});
        let lamp = push(document, "nodes", lamp);
        document["scenes"][0]["nodes"].as_array_mut().unwrap().extend([json!(camera), json!(lamp)]);
        let node = match mover {
            "triangle" => 0,
            "camera" => camera,
            _ => lamp,
        };
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
    for (mover, change) in [("camera", None), ("triangle", Some("geometry changed")), ("lamp", Some("light changed"))] {
        let folder = folder();
        fs::write(folder.path().join("m.gltf"), animated(mover).to_string()).unwrap();
        let common = "--width 24 --height 24 --background 1,1,1 --layers N,Z";
        let run =
            hemicube(folder.path(), &format!("render m.gltf -o f.exr --frames 0-2 --fps 2 --stats s.json {common}"));
        assert!(run.is_clean(), "{run:?}");
        assert_eq!(
            run.err.matches("changed, so that its records are made anew").count(),
            change.map_or(0, |_| 2),
            "{run:?}"
        );
        assert!(change.is_none_or(|change| run.err.contains(&format!("note: frame 1: {change}"))), "{run:?}");
        let last = hemicube(folder.path(), &format!("render -q m.gltf -o one.exr --time 1 {common}"));
        assert_eq!(last.code, 0, "{last:?}");
        let read = |name: &str| hemicube::image::exr::read(&folder.path().join(name)).unwrap();
        let depth = |name: &str| read(name).scalar("Z").unwrap().to_vec();
        let moved = depth("f.0000.exr") != depth("f.0002.exr");
        assert!(depth("f.0002.exr") == depth("one.exr") && moved == (mover != "lamp"), "{mover}");
        let red = |name: &str| read(name).rgb("").unwrap()[0].to_vec();
        assert!(red("f.0000.exr") != red("f.0002.exr"), "{mover}");
        // Frames do not depend on those before, but for the records that these leave.
        let alone = hemicube(folder.path(), &format!("render -q m.gltf -o g.exr --frames 2 --fps 2 {common}"));
        assert!(alone.code == 0 && depth("g.0002.exr") == depth("f.0002.exr"), "{alone:?}");
        if change.is_some() {
            assert!(red("g.0002.exr") == red("f.0002.exr"), "{mover}");
        }
    }
}

#[test]
fn frames_go_to_the_standard_output_as_video() {
    let folder = folder();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_hemicube"));
    let arguments = "render --frames 0-2 --fps 12 --orbit 20 --width 10 --height 6 --y4m --stats s.json --tone srgb";
    let output = command.current_dir(folder.path()).args(arguments.split_whitespace()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("frame 2: "), "{said}");
    let header = b"YUV4MPEG2 W10 H6 F12:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
    let frames = output.stdout.strip_prefix(header).unwrap();
    assert_eq!(frames.len(), 3 * (6 + 3 * 60));
    assert!(frames.chunks(186).all(|frame| frame.starts_with(b"FRAME\n")) && frames[..186] != frames[186..372]);
    // What the first frame's picture shows is what the video does: lightness rises with its code.
    let run = hemicube(folder.path(), "render -q -o f.png --frames 0-0 --orbit 20 --width 10 --height 6 --tone srgb");
    assert_eq!(run.code, 0, "{run:?}");
    let png = image::open(folder.path().join("f.0000.png")).unwrap().to_rgb8();
    for (pixel, y) in png.pixels().zip(&frames[6..66]) {
        let [r, g, b] = pixel.0.map(f64::from);
        let luma = 16.0 + 219.0 / 255.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b);
        assert!((luma - f64::from(*y)).abs() <= 0.51, "{luma} {y}");
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

//! Bad input and bad usage: one clear line, an exit code, and nothing left behind.

use super::{OLD, assert_refused, folder, names};
use crate::common::gltf::triangle;
use crate::common::program::{hemicube, hemicube_with};
use serde_json::json;
use std::time::Duration;

#[test]
fn bad_input_is_one_line_and_leaves_nothing() {
    let folder = folder();
    let before = names(folder.path());
    let huge = "--width 100000 --height 100000";
    let cases = [
        ("none.gltf -o new.exr", 2, "none.gltf"),
        (". -o new.exr", 2, "not a regular file"),
        ("text.gltf -o new.exr", 2, "text.gltf: not a glTF 2.0 file"),
        ("truncated.glb -o new.exr", 2, "truncated.glb: "),
        ("short.gltf -o new.exr", 2, "buffer 0"),
        ("index.gltf -o new.exr", 2, "index 7"),
        ("nan.gltf -o new.exr", 2, "NaN"),
        ("infinite.gltf -o new.exr", 2, "inf"),
        ("empty.gltf -o new.exr", 2, "no triangles"),
        ("required.gltf -o new.exr", 2, "ACME_unheard_of"),
        ("good.gltf --camera side -o new.exr", 2, "no camera \"side\""),
        ("--camera 7 -o new.exr", 2, "no camera \"7\""),
        ("good.gltf --background 1,2 -o new.exr", 2, "background 1,2"),
        ("good.gltf --background none.exr -o new.exr", 2, "none.exr"),
        ("good.gltf --width 0 -o new.exr", 2, "--width 0"),
        ("good.gltf --width 16 --height 0 -o new.exr", 2, "--height 0"),
        (&format!("good.gltf {huge} -o new.exr"), 2, "100000"),
        ("good.gltf --capture-size 7 -o new.exr", 2, "--capture-size 7"),
        ("good.gltf --accuracy 0 -o new.exr", 2, "--accuracy 0"),
        ("good.gltf -o no/new.exr", 2, "no/new.exr"),
        ("good.gltf -o folder.exr", 2, "folder.exr"),
        ("good.gltf -o good.gltf/new.exr", 2, "good.gltf/new.exr"),
        ("good.gltf -o new.bmp", 2, "new.bmp"),
        ("good.gltf -o new", 2, "new"),
        ("good.gltf -o new.exr --stats no/s.json", 2, "no/s.json"),
        ("good.gltf -o new.exr --trace no/t.json", 2, "no/t.json"),
        ("good.gltf -o new.exr --device nonesuch", 3, "nonesuch"),
        ("good.gltf -o new.exr --device 99", 3, "99"),
    ];
    for (arguments, code, words) in cases {
        let size = if arguments.contains("--width") { "" } else { "--width 16 --height 16" };
        let run = hemicube(folder.path(), &format!("render {arguments} {size}"));
        assert_refused(&run, code, words);
        assert!(run.out.is_empty() || code == 3, "{arguments}: {}", run.out);
        assert_eq!(names(folder.path()), before, "{arguments} leaves something behind");
    }
    // What was there before stays as it was.
    for arguments in ["none.gltf", "nan.gltf", "good.gltf --device 99", "good.gltf --width 0"] {
        let run = hemicube(folder.path(), &format!("render {arguments} -o old.exr"));
        assert!(run.code > 1 && run.err.lines().count() == 1, "{run:?}");
        assert_eq!(std::fs::read(folder.path().join("old.exr")).unwrap(), OLD, "{arguments}");
    }
}

#[test]
fn bad_usage_names_the_flag() {
    let folder = folder();
    let before = names(folder.path());
    let cases = [
        ("render good.gltf", "--output"),
        ("render good.gltf -o new.exr --layers glow", "glow"),
        ("render good.gltf -o new.exr --width x", "--width"),
        ("render good.gltf -o new.exr --width -5", "-5"),
        ("render good.gltf -o new.exr --gradients up", "--gradients"),
        ("render good.gltf -o new.exr -q -v", "--verbose"),
        ("brew", "brew"),
    ];
    for (arguments, words) in cases {
        let run = hemicube(folder.path(), arguments);
        assert!(run.code == 2 && run.err.contains(words) && run.out.is_empty(), "{run:?}");
        assert_eq!(names(folder.path()), before);
    }
}

#[test]
fn without_a_driver_the_exit_code_is_3() {
    let folder = folder();
    let none = [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent")];
    let run = hemicube_with(folder.path(), "render good.gltf -o new.exr --width 16 --height 16", &none);
    assert_refused(&run, 3, "install");
    assert!(!folder.path().join("new.exr").exists());
    let run = hemicube_with(folder.path(), "info", &none);
    assert_refused(&run, 3, "install");
}

#[test]
fn a_million_lights_are_refused_with_figures() {
    let folder = folder();
    let count = 1_000_000;
    let scene = triangle(|d| {
        let nodes = d["nodes"].as_array_mut().unwrap();
        let light = |i: u32| json!({"translation": [i % 1000, i / 1000, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}});
        nodes.extend((0..count).map(light));
        d["scenes"][0]["nodes"] = (0..=count).collect::<Vec<_>>().into();
        d["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    });
    std::fs::write(folder.path().join("lights.gltf"), serde_json::to_vec(&scene).unwrap()).unwrap();
    let run = hemicube(folder.path(), "render lights.gltf -o new.exr --width 16 --height 16");
    eprintln!("{:?}: {}", run.time, run.err);
    assert_refused(&run, 2, "1000000 punctual lights");
    assert!(run.err.contains("4096"), "the limit is named: {}", run.err);
    assert!(run.time < Duration::from_secs(30), "{:?}", run.time);
    assert!(!folder.path().join("new.exr").exists());
}

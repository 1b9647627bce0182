//! Files of records: `--cache` and `--cache-ro`.

use super::{assert_refused, folder, names, read_json};
use crate::common::program::{Run, hemicube};
use std::fs;
use std::path::Path;

const SMALL: &str = "--width 48 --height 48 --surface-cells 4000";
const LARGE: &str = "--width 96 --height 96 --surface-cells 4000";

fn render(folder: &Path, rest: &str) -> Run {
    hemicube(folder, &format!("render -q {SMALL} {rest}"))
}

/// New records and those that there were.
fn counts(folder: &Path) -> (u64, u64) {
    let stats = read_json(&folder.join("s.json"));
    (stats["records"].as_u64().unwrap(), stats["reused"].as_u64().unwrap())
}

#[test]
fn a_second_run_with_the_file_needs_no_record_and_shows_the_same_bits() {
    let folder = folder();
    for more in ["", "--background .2,.4,.8 --contrast 0", "--capture hemisphere --accuracy 0.6"] {
        let file = |name: &str| fs::read(folder.path().join(name)).unwrap();
        let sized = |size: &str, rest: &str| {
            let run = hemicube(folder.path(), &format!("render -q {size} --stats s.json --layers all {more} {rest}"));
            assert!(run.code == 0 && run.err.is_empty(), "{run:?}");
            counts(folder.path())
        };
        let run = |rest: &str| sized(SMALL, rest);
        let _ = fs::remove_file(folder.path().join("r.bin"));
        let (all, none) = run("-o plain.exr");
        assert!(all > 0 && none == 0);
        assert_eq!(run("-o first.exr --cache r.bin"), (all, 0));
        let records = file("r.bin");
        assert_eq!(run("-o second.exr --cache r.bin"), (0, all));
        assert_eq!(run("-o third.exr --cache-ro r.bin"), (0, all));
        for other in ["first.exr", "second.exr", "third.exr"] {
            assert!(file("plain.exr") == file(other), "{other} differs ({more})");
        }
        assert!(file("r.bin") == records, "nothing was added");
        // A larger image needs more; only --cache keeps them.
        let (added, _) = sized(LARGE, "-o large.exr --cache-ro r.bin");
        assert!(added > 0 && file("r.bin") == records);
        assert_eq!(sized(LARGE, "-o large.exr --cache r.bin"), (added, all));
        assert_eq!(sized(LARGE, "-o large.exr --cache-ro r.bin"), (0, all + added));
    }
}

#[test]
fn files_of_other_scenes_lights_and_settings_are_refused_by_name() {
    let folder = folder();
    let scene = |name: &str, change: &dyn Fn(&mut serde_json::Value)| {
        fs::write(folder.path().join(name), crate::common::gltf::triangle(change).to_string()).unwrap();
    };
    scene("a.gltf", &|_| ());
    scene("moved.gltf", &|d| d["nodes"][0]["translation"] = serde_json::json!([0, 0, 0.01]));
    scene("painted.gltf", &|d| {
        d["materials"] = serde_json::json!([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.4, 1]}}]);
        d["meshes"][0]["primitives"][0]["material"] = serde_json::json!(0);
    });
    scene("lit.gltf", &|d| {
        d["extensions"] = serde_json::json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3}]}});
        d["extensionsUsed"] = serde_json::json!(["KHR_lights_punctual"]);
        d["nodes"][0]["extensions"] = serde_json::json!({"KHR_lights_punctual": {"light": 0}});
    });
    let sky = "--background 1,1,1";
    let first = render(folder.path(), &format!("a.gltf -o a.exr {sky} --cache r.bin"));
    assert!(first.code == 0 && folder.path().join("r.bin").exists(), "{first:?}");
    let (before, bytes) = (names(folder.path()), fs::read(folder.path().join("r.bin")).unwrap());
    for (words, rest) in [
        ("another geometry than the scene's, of the scene \"a\"", format!("moved.gltf {sky}")),
        ("another material", format!("painted.gltf {sky}")),
        ("another light", format!("lit.gltf {sky}")),
        ("another background", "a.gltf --background 1,1,2".into()),
        ("--accuracy 0.3, and this run has --accuracy 0.2", format!("a.gltf {sky} --accuracy 0.2")),
        ("--capture-size 32, and this run has --capture-size 16", format!("a.gltf {sky} --capture-size 16")),
        ("--seed 0", format!("a.gltf {sky} --seed 1")),
        ("--bounces 1", format!("a.gltf {sky} --bounces 0")),
        ("--light-samples 64", format!("a.gltf {sky} --light-samples 65")),
    ] {
        for flag in ["--cache", "--cache-ro"] {
            let run = render(folder.path(), &format!("{rest} -o b.exr {flag} r.bin"));
            assert_refused(&run, 2, words);
            assert!(run.err.contains("r.bin") && run.err.contains("delete the file or name another one"), "{run:?}");
        }
    }
    assert_refused(&render(folder.path(), &format!("a.gltf {sky} -o b.exr --cache-ro none.bin")), 2, "none.bin");
    fs::write(folder.path().join("r.bin"), &bytes[..bytes.len() / 2]).unwrap();
    assert_refused(&render(folder.path(), &format!("a.gltf {sky} -o b.exr --cache r.bin")), 2, "it ends");
    fs::write(folder.path().join("r.bin"), b"something else").unwrap();
    assert_refused(&render(folder.path(), &format!("a.gltf {sky} -o b.exr --cache r.bin")), 2, "no file of records");
    assert_eq!(names(folder.path()), before);
}

/// Runs that are killed at any moment leave a file that serves, or none.
#[cfg(unix)]
#[test]
fn killed_runs_leave_the_file_as_it_was_or_as_it_is_to_be() {
    let folder = folder();
    let arguments = format!("render -q {SMALL} -o k.exr --accuracy 0.6 --stats s.json");
    let whole = render(folder.path(), "-o whole.exr --accuracy 0.6 --cache whole.bin");
    assert!(whole.code == 0, "{whole:?}");
    for round in 0..20_u64 {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_hemicube"));
        command.current_dir(folder.path()).args(arguments.split_whitespace()).args(["--cache", "k.bin"]);
        let mut child = command.spawn().unwrap();
        std::thread::sleep(whole.time.mul_f64(0.5 + 0.03 * round as f64));
        child.kill().unwrap();
        child.wait().unwrap();
        if folder.path().join("k.bin").exists() {
            assert!(
                fs::read(folder.path().join("k.bin")).unwrap() == fs::read(folder.path().join("whole.bin")).unwrap()
            );
            fs::remove_file(folder.path().join("k.bin")).unwrap();
        }
    }
    let again = render(folder.path(), "-o k.exr --accuracy 0.6 --cache k.bin");
    assert!(again.code == 0, "{again:?}");
    let file = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(file("k.exr") == file("whole.exr") && file("k.bin") == file("whole.bin"));
}

#[test]
fn a_sequence_in_two_runs_is_that_of_one() {
    let folder = folder();
    let walk = r#"{"keys": [{"time": 0, "eye": [0.28, 0.27, -0.8], "target": [0.28, 0.27, 0]},
        {"time": 3, "eye": [0.4, 0.27, -0.7], "target": [0.28, 0.27, 0]}]}"#;
    fs::write(folder.path().join("w.json"), walk).unwrap();
    let frames = |frames: &str, rest: &str| {
        let run = render(folder.path(), &format!("--frames {frames} --fps 1 --walk w.json {rest}"));
        assert!(run.code == 0 && run.err.is_empty(), "{run:?}");
    };
    frames("0-3", "-o one.exr");
    frames("0-1", "-o two.exr --cache r.bin");
    frames("2-3", "-o two.exr --cache r.bin");
    for frame in 0..4 {
        let file = |name: &str| fs::read(folder.path().join(format!("{name}.{frame:04}.exr"))).unwrap();
        assert!(file("one") == file("two"), "frame {frame}");
    }
}

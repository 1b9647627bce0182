//! The promises of `hemicube compare`: figures, exit codes, one clear line for bad input.

use assert_cmd::Command;
use hemicube::image::{Picture, exr};
use hemicube::reference::{Settings, Stop, path_trace};
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// A folder with `reference.exr` and, with 3 % less light, `test.exr`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let value = |i: usize| 0.2 + (i % 32) as f32 * 0.05;
    let picture = |scale: f32, layer: &str| {
        let mut picture = Picture::new(32, 24);
        picture.insert_rgb("", (0..768).map(|i| [scale * value(i); 3]));
        picture.insert_rgb(layer, (0..768).map(|i| [scale * value(i), scale, 0.5 * scale]));
        picture.insert_rgb("stderr.both", (0..768).map(|i| [scale * value(i); 3]));
        picture.insert_scalar("Z", (0..768).map(value));
        picture.insert_scalar("mask", (0..768).map(|i| if i < 700 { 1.0 } else { 0.0 }));
        picture
    };
    exr::write(&folder.path().join("test.exr"), &picture(0.97, "irradiance"), &[]).unwrap();
    exr::write(&folder.path().join("reference.exr"), &picture(1.0, "b1"), &[]).unwrap();
    folder
}

/// Exit code, standard output and standard error of `hemicube compare` in the folder.
fn compare(folder: &Path, arguments: &str) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemicube"));
    let output = command.current_dir(folder).arg("compare").args(arguments.split_whitespace()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn common_layers_are_shown_without_a_threshold() {
    let folder = folder();
    let (code, out, _) = compare(folder.path(), "test.exr reference.exr");
    assert_eq!(code, 0);
    assert!(out.contains("RGB") && out.contains("Z ") && !out.contains("b1") && out.contains("3.00 %"), "{out}");
    assert!(!out.contains("stderr"), "{out}");
    let (code, out, _) = compare(folder.path(), "test.exr reference.exr --layer stderr.both");
    assert!(code == 0 && out.contains("stderr.both"), "{out}");
}

#[test]
fn threshold_decides_the_exit_code() {
    let folder = folder();
    let pair = "test.exr reference.exr --layer irradiance=b1";
    assert_eq!(compare(folder.path(), &format!("{pair} --threshold 0.031")).0, 0);
    let (code, out, _) = compare(folder.path(), &format!("{pair} --threshold 0.029"));
    assert!(code == 1 && out.contains("FAILED: irradiance = b1: mae 0.03000 > 0.029"), "{out}");
    let ranges = [("energy", 0.029, 0.031), ("rms", 0.03, 0.06), ("p99", 0.02, 0.031), ("flip", 1e-4, 0.2)];
    for (metric, low, high) in ranges {
        assert_eq!(compare(folder.path(), &format!("{pair} --metric {metric} --threshold {low}")).0, 1, "{metric}");
        assert_eq!(compare(folder.path(), &format!("{pair} --metric {metric} --threshold {high}")).0, 0, "{metric}");
    }
}

#[test]
fn json_holds_the_figures() {
    let folder = folder();
    let (code, out, _) = compare(folder.path(), "test.exr reference.exr --layer RGB --layer Z --mask mask --json -");
    let value: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, value["layers"][0]["pixels"].as_u64()), (0, Some(700)));
    assert!((value["layers"][0]["energy"].as_f64().unwrap() - 0.97).abs() < 1e-6);
    assert!(value["layers"][1]["mae"] == 0.0 && value["layers"][1]["flip"].is_null());
}

#[test]
fn sums_of_layers_and_a_difference_picture() {
    let folder = folder();
    let arguments = "test.exr reference.exr --layer RGB+irradiance=RGB+b1 --diff d.png --json j.json --no-flip";
    let (code, out, _) = compare(folder.path(), arguments);
    assert!(code == 0 && out.contains("RGB+irradiance = RGB+b1"), "{out}");
    let (picture, value) = (image::open(folder.path().join("d.png")).unwrap(), folder.path().join("j.json"));
    assert_eq!((picture.width(), picture.height()), (32, 24));
    assert!(serde_json::from_slice::<Value>(&std::fs::read(value).unwrap()).unwrap()["layers"][0]["mae"].is_f64());
}

#[test]
fn values_that_are_no_numbers_fail_every_threshold() {
    let folder = folder();
    let mut picture = exr::read(&folder.path().join("reference.exr")).unwrap();
    picture.channels.get_mut("b1.G").unwrap()[5] = f32::NAN;
    exr::write(&folder.path().join("nan.exr"), &picture, &[]).unwrap();
    let (code, out, _) = compare(folder.path(), "nan.exr reference.exr --layer b1 --threshold 10");
    assert!(code == 1 && out.contains("no numbers") && out.contains("1 pixels of the test"), "{out}");
}

#[test]
fn bad_input_is_one_clear_line_and_exit_code_2() {
    let folder = folder();
    let mut small = Picture::new(2, 2);
    small.insert_rgb("", [[1.0; 3]; 4]);
    exr::write(&folder.path().join("small.exr"), &small, &[]).unwrap();
    std::fs::write(folder.path().join("text.exr"), "no picture").unwrap();
    let cases = [
        ("test.exr none.exr", "none.exr"),
        ("test.exr text.exr", "text.exr"),
        ("test.exr small.exr", "32 × 24"),
        ("test.exr reference.exr --layer glow", "it has RGB, Z, irradiance, mask"),
        ("test.exr reference.exr --layer irradiance=Z", "cannot be compared"),
        ("test.exr reference.exr --mask glow", "--mask glow"),
        ("test.exr reference.exr --diff d.png", "choose one with --layer"),
        ("test.exr reference.exr --layer RGB --diff no/d.png", "create the folder first"),
        ("test.exr reference.exr --layer Z --metric flip --threshold 1", "has no flip"),
        ("test.exr reference.exr --threshold NaN", "from 0 up"),
    ];
    for (arguments, words) in cases {
        let (code, out, error) = compare(folder.path(), arguments);
        assert!(code == 2 && error.contains(words) && error.lines().count() == 1, "{arguments}: {code} {error}");
        assert!(out.is_empty(), "{arguments}: {out}");
    }
    assert!(!folder.path().join("d.png").exists());
}

/// Side of the pictures below.
const SIDE: u32 = 64;

/// Two pictures of the Cornell box by other random numbers pass; each of three faults that an estimator may have is caught
/// through their noise.
#[test]
fn broken_estimators_are_seen_through_noise() {
    let folder = tempfile::tempdir().unwrap();
    let scene = hemicube::scene::cornell();
    let traced = |seed| {
        let settings = Settings { bounces: 1, seed, batch: 64 };
        path_trace(&scene, &scene.cameras[0], (SIDE, SIDE), settings, &Stop { spp: Some(256), ..Stop::default() }).0
    };
    let (test, reference) = (traced(1), traced(0));
    let side = SIDE as usize;
    let changed = |change: &dyn Fn(&[f32], usize) -> f32| {
        let mut picture = test.clone();
        for (name, channel) in picture.channels.iter_mut().filter(|(name, _)| name.as_str() != "mask") {
            let plane = &test.channels[name];
            *channel = (0..plane.len()).map(|i| change(plane, i)).collect();
        }
        picture
    };
    let write = |name: &str, picture: &Picture| exr::write(&folder.path().join(name), picture, &[]).unwrap();
    write("reference.exr", &reference);
    write("sound.exr", &test);
    write("loss.exr", &changed(&|plane, i| 0.97 * plane[i]));
    write("seam.exr", &changed(&|plane, i| if i % side == side / 2 { 0.0 } else { plane[i] }));
    write("shift.exr", &changed(&|plane, i| if i % side == 0 { plane[i] } else { plane[i - 1] }));
    for (fault, rule) in [
        ("loss", "--layer irradiance --metric energy --threshold 0.015"),
        ("seam", "--layer irradiance --metric p99 --threshold 0.9"),
        ("shift", "--layer direct --metric mae --threshold 0.03"),
    ] {
        let run = |name: &str| compare(folder.path(), &format!("{name}.exr reference.exr --mask mask {rule}"));
        let (sound, broken) = (run("sound"), run(fault));
        println!("{fault}:\n{}{}", sound.1, broken.1);
        assert_eq!((sound.0, broken.0), (0, 1), "{fault}: {}{}", sound.1, broken.1);
    }
}

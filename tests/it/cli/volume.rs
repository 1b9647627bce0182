//! `hemicube bake volume`, `hemicube probe --volume` and `hemicube reference --points`: what they write, and bad input.

use super::{assert_refused, folder, names, read_json};
use crate::common::program::hemicube;
use std::path::Path;

const POINTS: &str = "{\"points\": [[0.2, 0.3, 0.2], [0.4, 0.1, 0.3], [0.1, 0.45, 0.45]]}";

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Sum of all irradiances of a result.
fn irradiance(folder: &Path, name: &str) -> f64 {
    let points = read_json(&folder.join(name))["points"].as_array().unwrap().clone();
    points.iter().flat_map(|p| p["irradiance"].as_array().unwrap().clone()).flat_map(|rgb| numbers(&rgb)).sum()
}

#[test]
fn a_volume_is_baked_and_read_and_near_the_truth() {
    let folder = folder();
    let path = folder.path();
    write(path, "points.json", POINTS);
    let bake =
        hemicube(path, "bake volume -o v.json --uniform 10 --order 5 --capture-size 16 --stats stats.json --validate");
    assert_eq!(bake.code, 0, "{bake:?}");
    assert!(bake.out.contains("1000 samples of order 5") && bake.out.contains("with gradients"), "{bake:?}");
    let volume = read_json(&path.join("v.json"));
    assert_eq!((volume["version"].as_u64(), volume["order"].as_u64()), (Some(1), Some(5)));
    assert_eq!(volume["sample_count"], 1000);
    assert_eq!(volume["coefficients"][0].as_array().unwrap().len(), 25);
    assert_eq!(volume["gradients"][0][0].as_array().unwrap().len(), 3);
    assert_eq!(volume["cells"]["leaves"].as_array().unwrap().len(), 729);
    let stats = read_json(&path.join("stats.json"));
    assert_eq!((&stats["validation_messages"], &stats["placement"]["samples"]), (&0.into(), &1000.into()));
    assert_eq!(stats["sample_memory"]["by_order"][3]["floats_per_sample_with_gradients"], 300);
    for (command, name) in [
        ("probe --points points.json -o here.json", "here.json"),
        ("probe --volume v.json --points points.json -o read.json --window", "read.json"),
        ("reference --points points.json -o truth.json --spp 4096", "truth.json"),
    ] {
        let run = hemicube(path, command);
        assert_eq!(run.code, 0, "{run:?}");
        assert_eq!(read_json(&path.join(name))["points"].as_array().unwrap().len(), 3);
    }
    let [here, read, truth] = ["here.json", "read.json", "truth.json"].map(|name| irradiance(path, name));
    eprintln!("captured {here:.4}, read {read:.4}, traced {truth:.4}");
    assert!((here / truth - 1.0).abs() < 0.02 && (read / truth - 1.0).abs() < 0.05);
    assert!(read_json(&path.join("read.json"))["points"][0]["window"].is_number());
    let error = read_json(&path.join("truth.json"))["points"][0]["se"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.05, "{error}");
}

/// Each engine's file has its samples, from grids and from octrees.
#[test]
fn engines_get_their_files() {
    let folder = folder();
    let path = folder.path();
    let bake = |rest: &str| {
        let run = hemicube(path, &format!("bake volume --capture-size 8 {rest}"));
        assert_eq!(run.code, 0, "{run:?}");
        run
    };
    let run = bake("-o v.ktx2 --for bevy --uniform 3,2,4 --box 0.1,0.1,0.1,0.4,0.2,0.3");
    assert!(run.out.contains("Transform") && run.out.contains("wrote v.ktx2"), "{run:?}");
    let bytes = std::fs::read(path.join("v.ktx2")).unwrap();
    assert_eq!((&bytes[1..7], bytes[20], bytes[24], bytes[28]), (&b"KTX 20"[..], 3, 4, 12));
    assert!(run.out.contains("translation: Vec3::new(0.250000, 0.150000, 0.200000)"), "{run:?}");
    let octree = "--adaptive --min-level 0 --max-level 2";
    bake(&format!("-o godot.tres --for godot {octree}"));
    let text = std::fs::read_to_string(path.join("godot.tres")).unwrap();
    assert!(text.starts_with("[gd_resource type=\"LightmapGIData\"") && text.ends_with("}\n"), "{text}");
    for engine in ["three", "unity"] {
        bake(&format!("-o {engine}.json --for {engine} {octree}"));
        let file = read_json(&path.join(format!("{engine}.json")));
        assert_eq!(file["engine"], engine);
        assert_eq!(file["probes"].as_array().unwrap().len(), 125, "{engine}");
    }
}

#[test]
fn octrees_report_their_tests() {
    let folder = folder();
    let path = folder.path();
    let line =
        "bake volume -o v.json --adaptive --min-level 1 --max-level 3 --capture-size 16 --stats s.json --order 2";
    let run = hemicube(path, line);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.out.contains("by harmonic mean") && run.out.contains("of the 729 samples"), "{run:?}");
    let levels = read_json(&path.join("s.json"))["placement"]["levels"].as_array().unwrap().clone();
    assert!(levels[0]["by_geometry"].as_u64().unwrap() > 0 && levels[0]["cells"] == 8, "{levels:?}");
}

#[test]
fn bad_volumes_are_one_line_and_leave_nothing() {
    let folder = folder();
    let path = folder.path();
    write(path, "points.json", POINTS);
    write(path, "none.json", "{\"points\": []}");
    write(path, "far.json", "{\"points\": [[0.2, 0.3, 0.2], [0.9, 0.3, 0.2]]}");
    let bake = hemicube(path, "bake volume -o v.json --uniform 2 --capture-size 8 --order 2 --gradients none");
    assert_eq!(bake.code, 0, "{bake:?}");
    let text = std::fs::read_to_string(path.join("v.json")).unwrap();
    write(path, "torn.json", &text[..text.len() / 3]);
    write(path, "newer.json", &text.replace("\"version\":1", "\"version\":9"));
    let before = names(path);
    for (arguments, words) in [
        ("bake volume -o out.json --order 7", "--order 7"),
        ("bake volume -o out.json --box 50,0,0,51,1,1", "far outside"),
        ("bake volume -o out.json --for godot", ".tres file"),
        ("bake volume -o out.json --adaptive --min-level 5 --max-level 3", "--min-level 5"),
        ("bake volume -o out.json --adaptive --error 0", "--error 0"),
        ("bake volume -o out.json --inside 2", "--inside 2"),
        ("bake volume gone.glb -o out.json", "gone.glb"),
        ("bake volume -o no/out.json", "no/out.json"),
        ("bake volume -o out.ktx2", "out.ktx2"),
        ("bake volume -o out.json --for bevy", ".ktx2 file"),
        ("probe --volume torn.json --points points.json -o out.json", "torn.json"),
        ("probe --volume newer.json --points points.json -o out.json", "version 9"),
        ("probe --volume gone.json --points points.json -o out.json", "gone.json"),
        ("probe --volume v.json --points none.json -o out.json", "empty"),
        ("probe --volume v.json --points far.json -o out.json", "points[1]"),
        ("probe --volume v.json --points points.json -o out.json --order 3", "has order 2"),
        ("reference --points none.json -o out.json", "empty"),
        ("reference --points points.json -o out.exr", "out.exr"),
        ("reference --points points.json -o out.json --order 7", "--order 7"),
    ] {
        assert_refused(&hemicube(path, arguments), 2, words);
        assert_eq!(names(path), before, "{arguments} leaves something behind");
    }
    for (arguments, words) in [
        ("--uniform 1", "2 to 129"),
        ("--uniform 3,4", "X,Y,Z"),
        ("--box 0,0,0,1,1", "six numbers"),
        ("--box 0,0,0,1,1,0", "must differ"),
        ("--uniform 3 --adaptive", "cannot be used with"),
    ] {
        let run = hemicube(path, &format!("bake volume -o out.json {arguments}"));
        assert!(run.code == 2 && run.err.lines().next().unwrap().contains(words), "{run:?}");
        assert_eq!(names(path), before, "{arguments} leaves something behind");
    }
}

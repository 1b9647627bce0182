//! Statistics, trace and `info` hold what they should.

use super::{assert_refused, folder, read_json};
use crate::common::program::hemicube;
use serde_json::Value;
use std::path::Path;

#[test]
fn statistics_and_trace_explain_the_time() {
    let folder = folder();
    let run = hemicube(
        folder.path(),
        "render -o out.exr --width 96 --height 96 --validate --stats stats.json --trace trace.json",
    );
    assert!(run.is_clean() && run.out.contains("\n0 validation messages"), "{run:?}");
    let stats = read_json(&folder.path().join("stats.json"));
    let promised = "version device driver scene plan records rounds passes gpu_ms wall_ms memory validation_messages";
    promised.split(' ').for_each(|key| assert!(stats.get(key).is_some(), "{key}"));
    ["triangles", "vertices", "lights", "materials"].iter().for_each(|k| assert!(stats["scene"][k].is_u64(), "{k}"));
    assert_eq!(stats["scene"]["triangles"], 32);
    assert_eq!(stats["validation_messages"], 0);
    assert!(stats["records"].as_u64().unwrap() > 0 && stats["rounds"].as_u64().unwrap() > 0);
    assert!(stats["memory"]["gpu_bytes"].as_u64().unwrap() > 0 && stats["memory"]["by_use"].is_object());
    assert!(stats["plan"]["run"].as_array().unwrap().iter().all(Value::is_string));
    assert!(
        stats["plan"]["left_out"].as_array().unwrap().iter().all(|l| l["pass"].is_string() && l["why"].is_string())
    );

    // The passes are all there and make up the GPU's time.
    let passes = stats["passes"].as_array().unwrap();
    let named = |name: &str| passes.iter().any(|p| p["name"] == name);
    for pass in [
        "gbuffer",
        "shadow",
        "surface_light",
        "pixel_light",
        "place_records",
        "integrate",
        "clamp_records",
        "splat",
        "find_uncovered",
        "resolve",
    ] {
        assert!(named(pass), "no pass {pass}");
    }
    assert!(named("capture") != named("capture_compute"), "one way to capture");
    for pass in passes {
        let number = |key: &str| pass[key].as_f64().unwrap();
        assert!(number("count") >= 1.0 && number("total_ms") >= 0.0 && number("cpu_ms") >= 0.0, "{pass}");
        assert!(
            number("median_ms") <= number("p95_ms") + 1e-9 && number("p95_ms") <= number("total_ms") + 1e-9,
            "{pass}"
        );
    }
    let sum: f64 = passes.iter().map(|p| p["total_ms"].as_f64().unwrap()).sum();
    let gpu = stats["gpu_ms"].as_f64().unwrap();
    assert!((sum / gpu - 1.0).abs() < 0.1, "passes {sum} ms, GPU {gpu} ms");
    let wall = stats["wall_ms"].as_f64().unwrap();
    let stages: f64 = stats["cpu_stages"].as_array().unwrap().iter().map(|s| s["ms"].as_f64().unwrap()).sum();
    eprintln!(
        "passes {:.1} % of the GPU's time, stages {:.1} % of the clock",
        100.0 * sum / gpu,
        100.0 * stages / wall
    );
    assert!(stages / wall > 0.9 && stages <= wall * 1.001, "stages {stages} ms, wall clock {wall} ms");
    let process = run.time.as_secs_f64() * 1e3;
    assert!(wall <= process, "wall clock {wall} ms, process {process} ms");

    check_trace(&read_json(&folder.path().join("trace.json")), &stats);
}

fn check_trace(trace: &Value, stats: &Value) {
    let events: Vec<&Value> = trace["traceEvents"].as_array().unwrap().iter().filter(|e| e["ph"] == "X").collect();
    let number = |event: &Value, key: &str| event[key].as_f64().unwrap();
    let mut tracks: Vec<u64> = events.iter().map(|e| e["tid"].as_u64().unwrap()).collect();
    tracks.sort_unstable();
    tracks.dedup();
    assert!(tracks.len() >= 2, "a track of the GPU and one of the CPU: {tracks:?}");
    for track in tracks {
        let mut spans: Vec<[f64; 2]> = events
            .iter()
            .filter(|e| e["tid"] == track)
            .map(|e| [number(e, "ts"), number(e, "ts") + number(e, "dur")])
            .collect();
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(spans.iter().all(|[begin, end]| begin <= end && *begin >= 0.0));
        assert!(spans.windows(2).all(|pair| pair[0][1] <= pair[1][0] + 1e-6), "spans of track {track} overlap");
    }
    for pass in stats["passes"].as_array().unwrap() {
        let count = events.iter().filter(|e| e["name"] == pass["name"]).count() as u64;
        assert!(count >= pass["count"].as_u64().unwrap(), "{} is {count} times in the trace", pass["name"]);
    }
}

#[test]
fn info_lists_devices_and_needs() {
    let folder = folder();
    let run = hemicube(folder.path(), "info");
    assert!(run.code == 0 && run.out.starts_with("0  ") && run.out.contains("Vulkan 1."), "{run:?}");
    let run = hemicube(folder.path(), "info good.gltf");
    assert_eq!(run.code, 0);
    for words in [
        "triangles  1",
        "left out   textures (",
        "left out   area shadows (no emissive triangles)",
        "runs       gbuffer",
    ] {
        assert!(run.out.contains(words), "no {words:?}: {}", run.out);
    }
    let cornell = concat!("info ", env!("CARGO_MANIFEST_DIR"), "/assets/cornell.gltf");
    let of_box = hemicube(folder.path(), cornell);
    assert!(of_box.out.contains("cameras    0 \"camera\" (39.3° high)"), "{}", of_box.out);
    // A pass runs or is left out; the plan of a frame agrees.
    let stats = folder.path().join("stats.json");
    run_with_stats(folder.path());
    for left in read_json(&stats)["plan"]["left_out"].as_array().unwrap() {
        let line = format!("left out   {} (", left["pass"].as_str().unwrap());
        assert!(run.out.contains(&line) || left["pass"] == "record counts", "no {line:?}: {}", run.out);
    }
    assert_refused(&hemicube(folder.path(), "info none.gltf"), 2, "none.gltf");
}

#[test]
fn info_as_json_says_the_same() {
    let folder = folder();
    let json = |arguments: &str| -> Value {
        let run = hemicube(folder.path(), &format!("info --json {arguments}"));
        assert!(run.code == 0 && run.err.is_empty(), "{run:?}");
        serde_json::from_str(&run.out).unwrap()
    };
    let devices = json("");
    let (device, plain) = (&devices["devices"][0], hemicube(folder.path(), "info").out);
    let megabytes = device["memory"].as_u64().unwrap() >> 20;
    assert!(
        plain.contains(device["name"].as_str().unwrap()) && plain.contains(&format!("device memory {megabytes} MB"))
    );
    let scene = json(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cornell.gltf"));
    let cornell = hemicube::scene::cornell();
    assert_eq!((scene["triangles"].as_u64(), scene["emissive_triangles"].as_u64()), (Some(32), Some(2)));
    assert_eq!(scene["cameras"][0]["name"], "camera");
    let lens = &scene["cameras"][0]["lens"];
    assert!((lens["yfov"].as_f64().unwrap() - 39.3).abs() < 0.1 && lens["kind"] == "perspective", "{lens}");
    assert!((scene["bounds"][1][1].as_f64().unwrap() - f64::from(cornell.bounds().1.y)).abs() < 1e-6);
    assert!(scene["memory"]["bytes"].as_u64().unwrap() > 0 && scene["memory"]["misfit"].is_null());
    let stats = folder.path().join("stats.json");
    run_with_stats(folder.path());
    let (plan, stats) = (json("good.gltf"), read_json(&stats));
    let names = |of: &Value| -> Vec<String> {
        let passes = of["plan"]["left_out"].as_array().unwrap().iter();
        passes.map(|left| left["pass"].as_str().unwrap().to_owned()).filter(|name| name != "record counts").collect()
    };
    assert_eq!(names(&plan), names(&stats));
    assert_refused(&hemicube(folder.path(), "info none.gltf --json"), 2, "none.gltf");
}

fn run_with_stats(folder: &Path) {
    let run = hemicube(folder, "render good.gltf -q -o good.exr --width 16 --height 16 --stats stats.json");
    assert_eq!(run.code, 0, "{run:?}");
}

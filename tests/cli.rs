//! The program's promises: bad input is one clear line and an exit code, and leaves nothing behind; statistics and trace
//! hold what they should; every conformance file ends well.

#![allow(clippy::unwrap_used)] // the helpers belong to tests, which the lint cannot see

mod common;

use common::gltf::{document, glb, triangle};
use common::program::{Run, hemicube, hemicube_with, run, unread};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;
use tempfile::TempDir;

const OLD: &[u8] = b"an older picture";

/// A folder with a good scene, bad ones, and an older output.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let scene = |name: &str, value: &Value| write(name, &serde_json::to_vec(value).unwrap());
    scene("good.gltf", &triangle(|_| {}));
    write("text.gltf", b"not a scene");
    let whole = glb(&triangle(|_| {}), &[0; 64]);
    write("truncated.glb", &whole[..whole.len() - 40]);
    scene("short.gltf", &triangle(|d| d["buffers"][0]["byteLength"] = json!(5000)));
    scene("index.gltf", &document(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 7], |_| {}));
    let odd = |x: f32| document(&[[0.0; 3], [x, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2], |_| {});
    scene("nan.gltf", &odd(f32::NAN));
    scene("infinite.gltf", &odd(f32::INFINITY));
    scene("empty.gltf", &triangle(|d| d["nodes"][0] = json!({"name": "Nothing"})));
    scene(
        "texture.gltf",
        &triangle(|d| {
            d["images"] = json!([{"uri": "gone.png"}]);
            d["textures"] = json!([{"source": 0}]);
            d["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
            d["meshes"][0]["primitives"][0]["material"] = json!(0);
        }),
    );
    scene("required.gltf", &triangle(|d| d["extensionsRequired"] = json!(["ACME_unheard_of"])));
    scene("flat.gltf", &document(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[0, 1, 2], |_| {}));
    write("old.exr", OLD);
    std::fs::create_dir(folder.path().join("folder.exr")).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}

/// The run failed with `code` and one line that says `words`; the folder holds what it held.
#[track_caller]
fn assert_refused(run: &Run, code: i32, words: &str) {
    assert_eq!(run.code, code, "{run:?}");
    assert!(run.err.lines().count() == 1 && run.err.starts_with("error: "), "not one line: {run:?}");
    assert!(run.err.contains(words), "lacks {words:?}: {}", run.err);
    assert!(run.err.len() < 500, "a long line: {}", run.err);
}

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
        ("texture.gltf -o new.exr", 2, "gone.png"),
        ("required.gltf -o new.exr", 2, "ACME_unheard_of"),
        ("good.gltf --camera side -o new.exr", 2, "no camera \"side\""),
        ("--camera 7 -o new.exr", 2, "no camera \"7\""),
        ("good.gltf --background 1,2 -o new.exr", 2, "background 1,2"),
        ("good.gltf --background none.exr -o new.exr", 2, "none.exr"),
        ("good.gltf --width 0 -o new.exr", 2, "--width 0"),
        ("good.gltf --width 16 --height 0 -o new.exr", 2, "--height 0"),
        (&format!("good.gltf {huge} -o new.exr"), 2, "100000"),
        ("good.gltf --width 16000 --height 16000 -o new.exr", 2, "pixels"),
        ("good.gltf --capture-size 7 -o new.exr", 2, "--capture-size 7"),
        ("good.gltf --accuracy 0 -o new.exr", 2, "--accuracy 0"),
        ("good.gltf -o no/new.exr", 2, "no/new.exr"),
        ("good.gltf -o folder.exr", 2, "folder.exr"),
        ("good.gltf -o good.gltf/new.exr", 2, "good.gltf/new.exr"),
        ("good.gltf -o new.jpg", 2, "new.jpg"),
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

#[test]
fn triangles_without_area_show_the_background() {
    let folder = folder();
    let arguments = "render flat.gltf -o flat.exr --width 16 --height 16 --background 1,2,3 --layers all -v";
    let run = hemicube(folder.path(), arguments);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.out.contains("area"), "no note: {}", run.out);
    let picture = hemicube::image::exr::read(&folder.path().join("flat.exr")).unwrap();
    assert!(picture.non_finite().is_empty());
    let [r, g, b] = picture.rgb("").unwrap();
    assert!((0..256).all(|i| [r[i], g[i], b[i]] == [1.0, 2.0, 3.0]), "{:?}", (r[0], g[0], b[0]));
    assert!(picture.scalar("mask").unwrap().iter().all(|m| *m == 0.0));
    let run = hemicube(folder.path(), "render flat.gltf -o flat.exr --width 16 --height 16");
    assert_eq!(run.code, 0, "{run:?}");
    let picture = hemicube::image::exr::read(&folder.path().join("flat.exr")).unwrap();
    assert!(picture.rgb("").unwrap().iter().all(|c| c.iter().all(|v| *v == 0.0)));
}

#[test]
fn a_scene_without_camera_is_framed_and_says_so() {
    let folder = folder();
    let run =
        hemicube(folder.path(), "render good.gltf -o good.exr --width 16 --height 16 --background 1,1,1 --layers mask");
    assert!(run.code == 0 && run.out.contains("no camera"), "{run:?}");
    let picture = hemicube::image::exr::read(&folder.path().join("good.exr")).unwrap();
    assert!(picture.scalar("mask").unwrap().contains(&1.0), "the triangle is in the picture");
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn statistics_and_trace_explain_the_time() {
    let folder = folder();
    let run = hemicube(
        folder.path(),
        "render -o out.exr --width 96 --height 96 --validate --stats stats.json --trace trace.json",
    );
    assert!(run.code == 0 && run.err.is_empty(), "{run:?}");
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
fn a_picture_by_extension() {
    let folder = folder();
    let run = hemicube(folder.path(), "render -q -o out.png --width 32 --height 24 --exposure 1");
    assert!(run.code == 0 && run.out.is_empty() && run.err.is_empty(), "{run:?}");
    let bytes = std::fs::read(folder.path().join("out.png")).unwrap();
    assert!(bytes.starts_with(b"\x89PNG") && bytes[16..24] == [0, 0, 0, 32, 0, 0, 0, 24]);
    let run = hemicube(folder.path(), "render -q -o OUT.EXR --width 16 --height 16 --layers N,Z");
    assert_eq!(run.code, 0, "{run:?}");
    let picture = hemicube::image::exr::read(&folder.path().join("OUT.EXR")).unwrap();
    assert_eq!(picture.layers(), ["", "N", "Z"]);
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
    // A pass runs or is left out; the plan of a frame agrees.
    let stats = folder.path().join("stats.json");
    run_with_stats(folder.path());
    for left in read_json(&stats)["plan"]["left_out"].as_array().unwrap() {
        let line = format!("left out   {} (", left["pass"].as_str().unwrap());
        assert!(run.out.contains(&line) || left["pass"] == "record counts", "no {line:?}: {}", run.out);
    }
    assert_refused(&hemicube(folder.path(), "info none.gltf"), 2, "none.gltf");
}

/// Whoever reads what is said may stop at once, as `| head -0` does: nothing is said of it, and files are whole.
#[test]
fn what_nobody_reads_ends_no_run() {
    let size = "--width 16 --height 16 --background 1,1,1";
    let runs = [
        "--help",
        "render --help",
        "info",
        "info good.gltf",
        &format!("render good.gltf -v {size} -o out.exr --stats stats.json --trace trace.json"),
        &format!("reference good.gltf {size} --spp 4 -o truth.exr"),
        "compare out.exr truth.exr",
        "compare out.exr truth.exr --json -",
        "export good.gltf --width 16 --height 16 -o arrays",
        "convergence good.gltf -o plots --width 16 --height 16 --background 1,1,1 --methods path --spp 4 --reference-time 1",
    ];
    for neither in [false, true] {
        let folder = folder();
        let has = |name: &str| folder.path().join(name);
        for arguments in runs {
            let (code, said) = unread(folder.path(), arguments, neither);
            let failed = |line: &str| line.starts_with("error") || line.contains("panicked");
            assert!(code == Some(0) && !said.lines().any(failed), "{arguments}: {code:?} {said}");
        }
        for name in ["out.exr", "truth.exr"] {
            hemicube::image::exr::read(&has(name)).unwrap();
        }
        read_json(&has("stats.json"));
        read_json(&has("trace.json"));
        assert!(has("arrays").is_dir() && has("plots/index.html").is_file());
        // The exit code is the same, whoever hears why.
        assert_eq!(unread(folder.path(), "info none.gltf", neither).0, Some(2));
    }
}

/// What cannot be said for another reason is an error.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let folder = folder();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_hemicube"));
    let output = command.current_dir(folder.path()).args(["info", "good.gltf"]).stdout(full).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.lines().count() == 1, "{:?}: {said}", output.status);
    assert!(said.contains("cannot write the standard output"), "{said}");
}

fn run_with_stats(folder: &Path) {
    let run = hemicube(folder, "render good.gltf -q -o good.exr --width 16 --height 16 --stats stats.json");
    assert_eq!(run.code, 0, "{run:?}");
}

fn conformance() -> Vec<PathBuf> {
    let folder = std::env::var_os("HEMICUBE_CONFORMANCE")
        .map_or_else(|| PathBuf::from("../shared/gltf-conformance"), PathBuf::from);
    let mut found = Vec::new();
    let mut folders = vec![folder.clone()];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
                found.push(path);
            }
        }
    }
    found.sort();
    if found.is_empty() {
        eprintln!("!!! {} is absent: set HEMICUBE_CONFORMANCE; NOTHING IS CHECKED", folder.display());
    }
    found
}

/// The validator reports no errors, and triangles are drawn.
fn is_good(file: &Path) -> bool {
    let name = format!("{}.report.json", file.file_name().unwrap().to_str().unwrap());
    let Ok(report) = std::fs::read(file.with_file_name(name)) else { return false };
    let report: Value = serde_json::from_slice(&report).unwrap();
    // The validator counts triangles without positions, and those of meshes that no node draws.
    let document: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap_or_default();
    let nodes = document["nodes"].as_array().cloned().unwrap_or_default();
    let drawn = nodes.is_empty() || nodes.iter().any(|n| n.get("mesh").is_some());
    let placed = document.is_null() || document["meshes"].to_string().contains("\"POSITION\"");
    let triangles = report["info"]["totalTriangleCount"].as_u64().unwrap_or(0);
    report["issues"]["numErrors"] == 0 && triangles > 0 && drawn && placed
}

/// Says what is wrong with the end of `run`.
fn complaint(file: &Path, run: &Run, limit: Duration) -> Option<String> {
    let expected = match run.code {
        0 => run.err.is_empty() && !run.out.is_empty(),
        2 => run.err.lines().count() == 1 && run.out.is_empty() && !is_good(file),
        _ => false,
    };
    (!expected || run.time > limit).then(|| format!("{}: {run:?}", file.display()))
}

#[test]
fn every_conformance_file_ends_well() {
    let files = conformance();
    let next = Mutex::new(files.iter());
    let wrong = Mutex::new(Vec::new());
    let here = std::env::current_dir().unwrap();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(file) = next.lock().unwrap().next() else { break };
                    let run = run(&here, &["info", file.to_str().unwrap()], &[]);
                    wrong.lock().unwrap().extend(complaint(file, &run, Duration::from_secs(5)));
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    let good = files.iter().filter(|f| is_good(f)).count();
    eprintln!("{} files, {good} without errors and with triangles", files.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(files.is_empty() || (files.len() > 200 && good > 0));
}

/// Some of them as pictures: the good ones come out, and of the others a sample is refused.
#[test]
fn some_conformance_files_are_rendered() {
    let files = conformance();
    let (good, bad): (Vec<_>, Vec<_>) = files.iter().partition(|f| is_good(f));
    let folder = tempfile::tempdir().unwrap();
    let here = std::env::current_dir().unwrap();
    let output = folder.path().join("out.exr");
    for file in good.iter().step_by(good.len() / 8 + 1).chain(bad.iter().step_by(40)) {
        let words = [
            "render",
            file.to_str().unwrap(),
            "-o",
            output.to_str().unwrap(),
            "--width",
            "16",
            "--height",
            "16",
            "--background",
            "1,1,1",
            "--layers",
            "all",
        ];
        let run = run(&here, &words, &[]);
        if let Some(wrong) = complaint(file, &run, Duration::from_secs(20)) {
            panic!("{wrong}");
        }
        assert_eq!(output.exists(), run.code == 0, "{}", file.display());
        if run.code == 0 {
            let picture = hemicube::image::exr::read(&output).unwrap();
            assert!(picture.non_finite().is_empty(), "{}: {:?}", file.display(), picture.non_finite());
            std::fs::remove_file(&output).unwrap();
        }
    }
}

//! Every conformance file ends well.

use crate::common::program::{Run, run};
use crate::common::{conformance_folder, gltf_files};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

/// The validator's files; where they are absent the broken scenes of the project, and the built-in one.
fn conformance() -> Vec<PathBuf> {
    conformance_folder().map(gltf_files).unwrap_or_else(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        [gltf_files(root.join("tests/bad_scenes")), gltf_files(root.join("assets"))].concat()
    })
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
        0 => run.is_clean() && !run.out.is_empty(),
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
    assert!(conformance_folder().is_none() && files.len() > 50 || files.len() > 200 && good > 0);
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

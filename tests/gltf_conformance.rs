//! The Khronos validator's files: none panics or hangs, and those without errors load.
//!
//! `HEMICUBE_CONFORMANCE` names their folder (default `../shared/gltf-conformance`).

use hemicube::scene::{SceneError, load};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest that a file may take.
const LONGEST: Duration = Duration::from_secs(2);

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
}

/// Errors that the validator reports, if there is a report.
fn errors(file: &Path) -> Option<u64> {
    let name = format!("{}.report.json", file.file_name()?.to_str()?);
    let report = std::fs::read(file.with_file_name(name)).ok()?;
    let report: serde_json::Value = serde_json::from_slice(&report).ok()?;
    report["issues"]["numErrors"].as_u64()
}

#[test]
fn validator_files() {
    let folder = std::env::var_os("HEMICUBE_CONFORMANCE")
        .map_or_else(|| PathBuf::from("../shared/gltf-conformance"), PathBuf::from);
    if !folder.is_dir() {
        eprintln!("!!! {} is absent: set HEMICUBE_CONFORMANCE; only tests/bad_scenes is checked", folder.display());
        return;
    }
    let mut found = Vec::new();
    files(&folder, &mut found);
    assert!(found.len() > 100, "{} files", found.len());
    let (mut loaded, mut tolerated) = (0, Vec::new());
    for file in &found {
        let (start, result, errors) = (Instant::now(), load(file), errors(file));
        assert!(start.elapsed() < LONGEST, "{} takes {:?}", file.display(), start.elapsed());
        match result {
            Ok(_) if errors.is_some_and(|n| n > 0) => tolerated.push(file),
            Ok(_) => loaded += 1,
            Err(error) => {
                let line = error.to_string();
                assert!(!line.contains('\n') && line.starts_with(&*file.to_string_lossy()), "{line}");
                let holds_none = matches!(error, SceneError::Empty { .. });
                assert!(holds_none || errors != Some(0), "refused a file without errors: {line}");
                eprintln!("{line}");
            }
        }
    }
    eprintln!(
        "{} files: {loaded} without errors load, {} with errors load: {tolerated:#?}",
        found.len(),
        tolerated.len()
    );
}

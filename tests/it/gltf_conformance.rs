//! The Khronos validator's files: none panics or hangs, and those without errors load.
//!
//! `HEMICUBE_CONFORMANCE` names their folder (default `../shared/gltf-conformance`).

use crate::common::{conformance_folder, gltf_files};
use hemicube::scene::{SceneError, load};
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest that a file may take.
const LONGEST: Duration = Duration::from_secs(2);

/// Errors that the validator reports, if there is a report.
fn errors(file: &Path) -> Option<u64> {
    let name = format!("{}.report.json", file.file_name()?.to_str()?);
    let report = std::fs::read(file.with_file_name(name)).ok()?;
    let report: serde_json::Value = serde_json::from_slice(&report).ok()?;
    report["issues"]["numErrors"].as_u64()
}

#[test]
fn validator_files() {
    // Without them, `bad_scenes` still loads the broken files of the project.
    let Some(folder) = conformance_folder() else { return };
    let found = gltf_files(folder);
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

//! Files that are not part of the project: the reference scenes and the Khronos validator's glTF files.
//!
//! A folder that a variable names, or that is at its default place, must hold every file that a test asks for. Where there
//! is no such folder the test returns early and [`not_checked`] reports it.

use std::io::Write;
use std::path::PathBuf;

/// The folder that `variable` names, else `default` if that exists.
fn outside(variable: &str, default: &str) -> Option<PathBuf> {
    let named = std::env::var_os(variable).map(PathBuf::from);
    named.or_else(|| Some(PathBuf::from(default)).filter(|folder| folder.is_dir()))
}

/// The folder of the reference scene `name`, below `HEMICUBE_SCENES` or `../shared/scenes`.
pub fn scene_folder(name: &str) -> Option<PathBuf> {
    let Some(root) = outside("HEMICUBE_SCENES", "../shared/scenes") else {
        not_checked("the reference scenes are absent, set HEMICUBE_SCENES");
        return None;
    };
    let folder = root.join(name);
    assert!(folder.is_dir(), "the reference scene {} is missing", folder.display());
    Some(folder)
}

/// The folder of the conformance files, `HEMICUBE_CONFORMANCE` or `../shared/gltf-conformance`.
pub fn conformance_folder() -> Option<PathBuf> {
    let Some(folder) = outside("HEMICUBE_CONFORMANCE", "../shared/gltf-conformance") else {
        not_checked("the conformance files are absent, set HEMICUBE_CONFORMANCE");
        return None;
    };
    assert!(folder.is_dir(), "the folder of conformance files {} is missing", folder.display());
    Some(folder)
}

/// All glTF files below a folder, in order.
pub fn gltf_files(folder: PathBuf) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder]);
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Reports that this test checks less than it should: on the standard error output, where no capture of a passing test's
/// output hides it, and as a line of the file that `HEMICUBE_NOT_CHECKED` names. `tools/test.sh` ends with those lines.
pub fn not_checked(why: &str) {
    let thread = std::thread::current();
    let line = format!("{}: {why}\n", thread.name().unwrap_or("a test"));
    let _ = write!(std::io::stderr(), "!!! not checked: {line}");
    if let Some(file) = std::env::var_os("HEMICUBE_NOT_CHECKED") {
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(file).unwrap();
        file.write_all(line.as_bytes()).unwrap();
    }
}

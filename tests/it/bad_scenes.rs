//! Broken files end in one line that names the object, or load with a note; `tools/make_bad_scenes.py` wrote them.

use hemicube::scene::{SceneError, load};
use std::path::Path;
use std::time::{Duration, Instant};

const LONGEST: Duration = Duration::from_secs(2);

/// Says what is wrong with the outcome for one line of `expected.txt`, if anything is.
fn check(folder: &Path, line: &str) -> Result<(), String> {
    let mut parts: Vec<&str> = line.split('|').collect();
    let file = folder.join(parts.remove(0));
    let loads = parts.first() == Some(&"ok");
    let start = Instant::now();
    let said = match (load(&file), loads) {
        (Ok(scene), true) => format!("ok: {}", scene.notes.join("; ")),
        (Ok(_), false) => return Err(format!("{line}: loads")),
        (Err(error), true) => return Err(format!("{line}: {error}")),
        (Err(error), false) => error.to_string(),
    };
    eprintln!("{said}");
    let names_file = loads || said.starts_with(&format!("{}: ", file.display()));
    let bad = said.contains(char::is_control) || !names_file || start.elapsed() > LONGEST;
    let missing = parts.iter().find(|part| !said.contains(**part));
    if bad || missing.is_some() { Err(format!("{line}: {said} (lacks {missing:?})")) } else { Ok(()) }
}

#[test]
fn each_bad_scene_is_told_from_the_others() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_scenes");
    let expected = std::fs::read_to_string(folder.join("expected.txt")).expect("expected.txt");
    let files = std::fs::read_dir(&folder).expect("the corpus").count() - 1;
    assert_eq!(expected.lines().count(), files, "every file has a line");
    let wrong: Vec<String> = expected.lines().filter_map(|line| check(&folder, line).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_missing_file_and_a_folder_are_read_errors() {
    for (path, reason) in [("tests/bad_scenes/none.gltf", "No such file"), ("tests", "not a regular file")] {
        let error = load(Path::new(path)).expect_err(path);
        assert!(matches!(error, SceneError::Read { .. }));
        assert!(error.to_string().starts_with(path) && error.to_string().contains(reason), "{error}");
    }
}

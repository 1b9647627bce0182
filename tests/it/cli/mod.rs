//! The program's promises: bad input is one clear line and an exit code, and leaves nothing behind; statistics and trace
//! hold what they should; every conformance file ends well.

mod conformance;
mod first_use;
mod pictures;
mod probe;
mod record_files;
mod refusals;
mod reports;
mod sequences;
#[cfg(unix)]
mod stops;
mod unread;
mod volume;

use crate::common::gltf::{document, glb, triangle};
use crate::common::program::Run;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
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

/// The run failed with `code` and one line that says `words`; where the scene was loaded,
/// the line of what it is comes before, with notes.
#[track_caller]
fn assert_refused(run: &Run, code: i32, words: &str) {
    assert_eq!(run.code, code, "{run:?}");
    let (before, last) = run.err.trim_end().rsplit_once('\n').unwrap_or(("", &run.err));
    let loaded = before
        .lines()
        .enumerate()
        .all(|(i, line)| line.starts_with("note: ") || i == 0 && line.contains(" triangles, "));
    assert!(last.starts_with("error: ") && loaded, "not one line: {run:?}");
    assert!(run.err.contains(words), "lacks {words:?}: {}", run.err);
    assert!(run.err.len() < 500, "a long line: {}", run.err);
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

//! Any bytes are a scene or an error with one line; what loads can be looked at anywhere.
//!
//! Seeds: `tests/bad_scenes`, `assets` and, written by `HEMICUBE_SEEDS=folder cargo test --release --lib scene`, the
//! files of the loader's own tests. On a stable compiler set `RUSTC_BOOTSTRAP=1`:
//! `cargo fuzz run load_scene -O fuzz/corpus/load_scene tests/bad_scenes assets -- -rss_limit_mb=1024 -timeout=5
//! -max_len=16384 -dict=fuzz/gltf.dict`.

#![no_main]

use glam::Vec2;
use hemicube::scene::{Limits, Options, Pose, Scene, load_from_slice};
use libfuzzer_sys::fuzz_target;
use std::io;

/// Small enough that a scene within them stays far below the fuzzer's memory limit.
const LIMITS: Limits = Limits { triangles: 1 << 16, texels: 1 << 20 };

fuzz_target!(|bytes: &[u8]| {
    // Every file that a scene names is the scene's own bytes: images and buffers are fuzzed with it.
    let resolve = |name: &str| if name.is_empty() { Err(io::ErrorKind::NotFound.into()) } else { Ok(bytes.to_vec()) };
    let moment = Pose { seconds: Some(0.4), animation: None };
    let _ = load_from_slice("fuzz.gltf", bytes, &resolve, Options { limits: LIMITS, pose: moment }).map(|s| check(&s));
    match load_from_slice("fuzz.gltf", bytes, &resolve, LIMITS) {
        Ok(scene) => check(&scene),
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error}"),
    }
});

/// What holds for every scene.
fn check(scene: &Scene) {
    assert!(scene.positions.iter().all(|p| p.is_finite()));
    assert!(scene.normals.iter().all(|n| n.is_normalized()));
    let last = scene.triangles.len().checked_sub(1).map(|last| last as u32);
    for triangle in last.into_iter().flat_map(|last| [0, last / 2, last]) {
        let point = scene.surface(triangle, Vec2::splat(1.0 / 3.0));
        assert!(point.shading_normal.is_normalized() && point.geometric_normal.is_normalized());
        assert!(point.albedo.is_finite() && point.emission.is_finite(), "{point:?}");
    }
    scene.emitters();
    scene.camera(None).expect("a camera can always be framed");
}

//! What a new user tries first: files as programs write them, lamps in candela, scenes without light.

use super::folder;
use crate::common::program::hemicube;
use serde_json::{Value, json};

/// A floor under a lamp of `candela`, if any, by the camera above it.
fn floor(candela: Option<f64>) -> String {
    let positions: [f32; 12] = [-2.0, 0.0, 2.0, 2.0, 0.0, 2.0, -2.0, 0.0, -2.0, 2.0, 0.0, -2.0];
    let bytes: String = positions.iter().flat_map(|x| x.to_le_bytes()).map(|b| format!("%{b:02X}")).collect();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut document: Value = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 3, 0], "rotation": [-half, 0, 0, half]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}],
        "buffers": [{"byteLength": 48, "uri": format!("data:application/octet-stream,{bytes}")}],
    });
    if let Some(candela) = candela {
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": candela}]}});
        document["nodes"][1]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    }
    document.to_string()
}

const SIZE: &str = "--width 32 --height 32";

/// Mean code value of a PNG.
fn mean(path: &std::path::Path) -> f64 {
    let codes = image::open(path).unwrap().into_rgb8().into_raw();
    codes.iter().map(|c| f64::from(*c)).sum::<f64>() / codes.len() as f64
}

#[test]
fn lamps_of_any_strength_give_a_picture() {
    let folder = folder();
    for candela in [1e-3, 1.0, 54_351.4] {
        std::fs::write(folder.path().join("lamp.gltf"), floor(Some(candela))).unwrap();
        let run = hemicube(folder.path(), &format!("render lamp.gltf -o lamp.png {SIZE}"));
        assert!(run.code == 0 && (run.out.clone() + &run.err).contains("exposure "), "{run:?}");
        let mean = mean(&folder.path().join("lamp.png"));
        assert!((80.0..180.0).contains(&mean), "{candela}: {mean}");
    }
    let run = hemicube(folder.path(), &format!("render lamp.gltf -o lamp.png {SIZE} --exposure 0 -q"));
    assert!(run.code == 0 && mean(&folder.path().join("lamp.png")) > 250.0, "{run:?}");
}

#[test]
fn a_scene_without_light_gives_a_warning_and_is_lit_on_demand() {
    let folder = folder();
    std::fs::write(folder.path().join("dark.gltf"), floor(None)).unwrap();
    let run = hemicube(folder.path(), &format!("render dark.gltf -o dark.png {SIZE}"));
    assert!(run.code == 0 && run.err.contains("no light") && run.err.contains("--default-light"), "{run:?}");
    assert!(mean(&folder.path().join("dark.png")) < 5.0);
    let run = hemicube(folder.path(), &format!("render dark.gltf -o lit.png {SIZE} --default-light"));
    assert!(run.code == 0 && run.err.is_empty() && mean(&folder.path().join("lit.png")) > 80.0, "{run:?}");
}

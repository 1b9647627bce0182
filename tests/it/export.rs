//! `hemicube export` as another program reads it.

use crate::common::gltf::triangle;
use crate::common::program::hemicube;
use hemicube::image::exr;
use serde_json::{Value, json};
use std::path::Path;

fn floats(file: &Path) -> Vec<f32> {
    std::fs::read(file).unwrap().as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

fn doubles(file: &Path) -> Vec<f64> {
    std::fs::read(file).unwrap().as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

fn description(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("scene.json")).unwrap()).unwrap()
}

#[test]
fn pixels_are_where_the_reference_sees_them() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let size = "--width 20 --height 12";
    assert_eq!(hemicube(here, &format!("export -o out -q {size}")).code, 0);
    assert_eq!(hemicube(here, &format!("reference -o truth.exr -q --spp 2 {size}")).code, 0);
    let truth = exr::read(&here.join("truth.exr")).unwrap();
    let (p, n, mask) = (truth.xyz("P").unwrap(), truth.xyz("N").unwrap(), truth.scalar("mask").unwrap());
    let pixels = doubles(&here.join("out/pixels"));
    assert_eq!(pixels.len(), 20 * 12 * 11);
    for (i, row) in pixels.chunks(11).enumerate() {
        for axis in 0..3 {
            assert_eq!([row[axis] as f32, row[3 + axis] as f32], [p[axis][i], n[axis][i]], "pixel {i}");
        }
        assert_eq!(row[9] as f32, mask[i]);
    }
    let told = description(&here.join("out"));
    let triangles = std::fs::metadata(here.join("out/triangles")).unwrap().len() / 12;
    let parts = told["parts"].as_array().unwrap();
    assert_eq!(parts.iter().map(|part| part["triangle_count"].as_u64().unwrap()).sum::<u64>(), triangles);
    assert!(pixels.chunks(11).all(|row| row[10] < triangles as f64));
    assert_eq!((told["width"].as_u64(), told["height"].as_u64()), (Some(20), Some(12)));
}

#[test]
fn lights_materials_and_background_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let document = triangle(|document| {
        document["nodes"][0]["translation"] = json!([0.0, 0.0, -3.0]);
        document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        let spot = json!({"type": "spot", "intensity": 2.0, "spot": {"innerConeAngle": 0.0, "outerConeAngle": 0.5}});
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [spot]}});
        document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        document["materials"] = json!([{"name": "grey", "alphaMode": "MASK", "alphaCutoff": 0.25}]);
        document["meshes"][0]["primitives"][0]["material"] = json!(0);
    });
    std::fs::write(here.join("one.gltf"), document.to_string()).unwrap();
    let run = hemicube(here, "export one.gltf -o out --background 1,2,3");
    assert!(run.code == 0 && run.out.contains("1 triangles"), "{run:?}");
    let told = description(&here.join("out"));
    assert_eq!(told["background"]["radiance"], json!([1.0, 2.0, 3.0]));
    let light = &told["lights"][0];
    assert_eq!((&light["kind"], &light["colour"]), (&json!("spot"), &json!([2.0, 2.0, 2.0])));
    assert!((light["cos_outer"].as_f64().unwrap() - 0.5f64.cos()).abs() < 1e-6);
    assert_eq!((&told["materials"][0]["name"], &told["materials"][0]["alpha_cutoff"]), (&json!("grey"), &json!(0.25)));
    // In world space, as the node places it.
    assert!(floats(&here.join("out/positions")).chunks(3).all(|p| p[2] == -3.0));
    assert_eq!(told["files"]["positions"], json!({"kind": "<f4", "columns": 3}));
    assert!(told["files"].get("tangents").is_none());
}

#[test]
fn bad_input_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    for (arguments, part) in [
        ("nowhere.gltf -o out", "nowhere.gltf"),
        ("-o file", "cannot make the folder"),
        ("-o out --width 0", "0 × "),
        ("-o out --camera 7", "no camera"),
        ("-o out --background 1,2", "1,2"),
    ] {
        let run = hemicube(folder.path(), &format!("export {arguments}"));
        assert!(run.code == 2 && run.err.contains(part), "{arguments}: {run:?}");
        assert!(!folder.path().join("out/scene.json").exists());
    }
}

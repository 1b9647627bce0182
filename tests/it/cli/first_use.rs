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
        assert!(run.code == 0 && run.err.contains("exposure "), "{run:?}");
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
    assert!(run.is_clean() && mean(&folder.path().join("lit.png")) > 80.0, "{run:?}");
}

/// Messages go to the standard error output and results to the standard output; the plan is for `-v`.
#[test]
fn messages_are_few_and_apart_from_results() {
    let folder = folder();
    let run = hemicube(folder.path(), &format!("render -o box.exr {SIZE}"));
    assert!(run.is_clean() && run.err.lines().count() == 1 && run.err.contains("32 triangles"), "{run:?}");
    assert!(run.out.contains("wrote box.exr") && !run.out.contains("left out"), "{run:?}");
    let run = hemicube(folder.path(), &format!("render -o box.exr {SIZE} -v"));
    assert!(run.is_clean() && run.err.contains("plan: ") && run.err.contains("left out: sky"), "{run:?}");
    assert!(!run.err.contains('\u{1b}'), "no colours in a pipe: {run:?}");
}

#[test]
fn flags_without_effect_get_a_note() {
    let folder = folder();
    let notes = |arguments: &str| {
        let run = hemicube(folder.path(), arguments);
        assert!(run.is_clean(), "{run:?}");
        let flag =
            |line: &str| line.strip_prefix("note: ")?.split_once(" has no effect").map(|(flag, _)| flag.to_owned());
        run.err.lines().filter_map(flag).collect::<Vec<_>>()
    };
    let captures = "--aperture 90 --compensation off --slices 16 --slices-near 4 --background-rotation 20";
    let words = |list: &str| list.split(' ').map(String::from).collect::<Vec<_>>();
    assert_eq!(
        notes(&format!("render -o box.exr {SIZE} --exposure 1 --tone srgb {captures}")),
        words("--exposure --tone --aperture --compensation --slices --slices-near --background-rotation")
    );
    assert_eq!(notes(&format!("render -o box.png {SIZE} --layers N --capture plane --aperture 90")), ["--layers"]);
    assert_eq!(notes(&format!("render -o box.png {SIZE} --capture slices --slices 16")), Vec::<String>::new());
    assert_eq!(
        notes(&format!("reference -o box.exr {SIZE} --spp 2 --rays 64 --weight bounded --no-gradient-limit")),
        words("--rays --weight --no-gradient-limit")
    );
}

#[test]
fn numbers_out_of_range_are_refused_by_their_range() {
    let folder = folder();
    for (arguments, words) in [
        ("render -o box.exr --accuracy -1", "above 0"),
        ("render -o box.exr --contrast -0.5", "from 0"),
        ("reference -o box.exr --time 1e20", "1e9 seconds"),
        ("convergence -o folder --reference-time 1e30", "1e9 seconds"),
        ("render -o box.exr --time 1e30", "1e6 seconds"),
    ] {
        let run = hemicube(folder.path(), arguments);
        assert!(run.code == 2 && run.err.contains(words) && !run.err.contains("panicked"), "{arguments}: {run:?}");
    }
}

#[test]
fn help_has_the_defaults_and_a_short_form() {
    let folder = folder();
    let defaults = hemicube::renderer::Settings::default();
    let long = hemicube(folder.path(), "render --help").out;
    for (flag, value) in [
        ("--accuracy", defaults.cache.accuracy),
        ("--contrast", defaults.cache.contrast),
        ("--min-radius", defaults.cache.min_radius),
        ("--lod-error", defaults.cache.lod_error),
        ("--capture-size", defaults.cache.capture_size as f32),
        ("--light-samples", defaults.lights.area_samples as f32),
    ] {
        let (_, help) = long.split_once(&format!("{flag} <")).unwrap();
        let shown = help.split_once("[default: ").unwrap().1.split(']').next().unwrap();
        assert_eq!(shown, value.to_string(), "{flag}");
    }
    let short = hemicube(folder.path(), "render -h").out;
    assert!(short.lines().count() < 75 && short.contains("--help"), "{} lines\n{short}", short.lines().count());
}

#[test]
fn a_result_holds_what_it_was_made_with() {
    let folder = folder();
    let run = hemicube(folder.path(), &format!("render -o a.exr {SIZE} --seed 7 --accuracy 0.5 --stats a.json"));
    assert!(run.is_clean(), "{run:?}");
    use exr::prelude::*;
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let file = reader.all_attributes().from_file(folder.path().join("a.exr")).unwrap();
    let attributes = &file.layer_data.attributes;
    let hash = format!("scene hash: {:016x}", hemicube::scene::cornell().fingerprint());
    let comments = attributes.comments.as_ref().unwrap().to_string();
    for words in ["scene: cornell", &hash, "seed: 7", "accuracy: 0.5", "size: 32x32", "device: "] {
        assert!(comments.contains(words), "no {words:?}: {comments}");
    }
    assert!(attributes.software_name.as_ref().unwrap().to_string().starts_with("hemicube "));
    // A point in front of the camera has a positive z there.
    let m = attributes.world_to_camera.unwrap();
    let camera = hemicube::scene::cornell().cameras[0].camera_to_world;
    let ahead = (camera * glam::DVec4::new(0.25, 0.5, -2.0, 1.0)).as_vec4().to_array();
    let seen: Vec<f32> = (0..3).map(|k| (0..4).map(|i| ahead[i] * m[4 * i + k]).sum()).collect();
    assert!(seen.iter().zip([0.25, 0.5, 2.0]).all(|(is, should)| (is - should).abs() < 1e-4), "{seen:?}");
    let stats = super::read_json(&folder.path().join("a.json"));
    assert!(stats["command"].to_string().contains("--seed") && stats["made_with"]["seed"] == "7", "{stats}");
}

#[test]
fn other_formats_by_extension_and_completions() {
    let folder = folder();
    for name in ["box.jpg", "box.hdr", "box.JPEG"] {
        let run = hemicube(folder.path(), &format!("render -o {name} {SIZE}"));
        assert!(run.is_clean() && run.err.contains("exposure ") != name.ends_with("hdr"), "{run:?}");
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        assert!(bytes.starts_with(if name.ends_with("hdr") { b"#?RADIANCE" } else { b"\xff\xd8\xff" }), "{name}");
    }
    for shell in ["bash", "zsh", "fish"] {
        let run = hemicube(folder.path(), &format!("completions {shell}"));
        assert!(run.code == 0 && run.out.contains("capture-size"), "{shell}: {}", run.err);
    }
}

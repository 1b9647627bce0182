//! Baked light: files that are read again, and errors against sampling.

use crate::common::gpu;
use crate::common::program::hemicube;
use glam::{Vec3, vec3};
use hemicube::bake::vertices::{VertexIrradiance, VertexMethod};
use hemicube::methods::surface_cache::{ALL_BOUNCES, Solver};
use hemicube::methods::surface_irradiance::{SurfaceIrradiance, SurfaceIrradianceSettings};
use hemicube::renderer::Settings;
use hemicube::scene::build::{Builder, Facing, diffuse};
use hemicube::scene::{Light, Scene, cornell, load};
use serde_json::Value;
use std::f32::consts::PI;

fn irradiance(scene: &Scene) -> SurfaceIrradiance {
    let settings = SurfaceIrradianceSettings {
        direct: true,
        bounces: ALL_BOUNCES,
        tolerance: 1e-3,
        solver: Solver::Accelerated,
        places: None,
        capture_size: 16,
        surface_cells: 1 << 16,
        lights: Settings::default().lights,
    };
    SurfaceIrradiance::new(&gpu(), scene, &settings, &mut |_| {}).unwrap()
}

/// A lamp in the middle of a sphere: E = I/s² directly, ρ/(1 − ρ) times that by reflections, whatever the albedo.
#[test]
fn the_surface_has_direct_and_reflected_light() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.sphere(grey, Vec3::ZERO, 1.0, 24, Facing::In);
    b.light(Light::Point { position: Vec3::ZERO, intensity: vec3(1.0, 2.0, 0.0) });
    let found = irradiance(&b.build());
    let count = found.direct.len() as f64;
    let mean = |sides: &[[[f32; 3]; 2]], c: usize| sides.iter().map(|both| f64::from(both[0][c])).sum::<f64>() / count;
    for (channel, intensity) in [1.0, 2.0, 0.0].into_iter().enumerate() {
        let (direct, reflected) = (mean(&found.direct, channel), mean(&found.reflected, channel));
        assert!((direct - intensity).abs() <= 0.01 * intensity, "{channel}: {direct}");
        assert!((reflected - intensity).abs() <= 0.01 * intensity, "{channel}: {reflected}");
    }
    assert!(found.direct.iter().all(|both| both[1] == [0.0; 3]), "nothing falls on the outside");
}

/// In the Cornell box, whose walls are two triangles each.
#[test]
fn least_squares_err_by_half_as_much_as_samples() {
    let scene = cornell();
    let found = irradiance(&scene);
    let [fit, sampled] = [VertexMethod::LeastSquares, VertexMethod::Sampled]
        .map(|method| VertexIrradiance::new(&scene, &found, method).off);
    eprintln!("least squares: {fit}; samples: {sampled}");
    assert!(fit.rms <= 0.6 * sampled.rms && fit.mean <= 0.6 * sampled.mean, "{fit}; {sampled}");
    assert!((fit.energy - 1.0).abs() <= 0.01, "{fit}");
}

/// The file's document and its bytes.
fn read(bytes: &[u8]) -> (Value, &[u8]) {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), &bytes[28 + length..])
}

fn floats(document: &Value, bytes: &[u8], name: &str) -> Vec<f32> {
    let index = |value: &Value| value.as_u64().unwrap() as usize;
    let accessor = &document["accessors"][index(&document["meshes"][0]["primitives"][0]["attributes"][name])];
    let view = &document["bufferViews"][index(&accessor["bufferView"])];
    let begin = index(&view["byteOffset"]);
    let of_word = |word: &[u8]| f32::from_le_bytes(word.try_into().unwrap());
    bytes[begin..begin + index(&view["byteLength"])].chunks(4).map(of_word).collect()
}

#[test]
fn a_baked_file_is_the_scene_with_its_light() {
    let folder = tempfile::tempdir().unwrap();
    let run = hemicube(folder.path(), "bake vertices -o lit.glb --unlit 1 --surface-cells 20000 --places 300");
    assert!(run.is_clean() && run.out.contains("wrote lit.glb"), "{run:?}");
    let again = load(&folder.path().join("lit.glb")).unwrap();
    let scene = cornell();
    assert_eq!(
        (again.positions.len(), &again.triangles, &again.parts),
        (scene.positions.len(), &scene.triangles, &scene.parts)
    );
    assert!(again.positions.iter().zip(&scene.positions).all(|(a, b)| a.distance(*b) < 1e-6));
    let bytes = std::fs::read(folder.path().join("lit.glb")).unwrap();
    let (document, bytes) = read(&bytes);
    let [light, shown] = ["_IRRADIANCE", "COLOR_0"].map(|name| floats(&document, bytes, name));
    assert_eq!((light.len(), shown.len()), (3 * scene.positions.len(), 4 * scene.positions.len()));
    assert!(light.iter().all(|e| e.is_finite() && *e >= 0.0) && light.iter().any(|e| *e > 0.1));
    let emits = |vertex: u32| {
        let part = scene.parts.iter().find(|part| scene.triangles_of(part).iter().flatten().any(|v| *v == vertex));
        part.is_some_and(|part| scene.emits(part))
    };
    for vertex in (0..scene.positions.len()).filter(|v| !emits(*v as u32)) {
        let (e, c) = (light[3 * vertex + 1], shown[4 * vertex + 1]);
        assert!((c - (2.0 * e / PI).min(1.0)).abs() < 1e-5, "{vertex}: {e} shown as {c}");
    }
}

#[test]
fn what_cannot_be_baked_is_refused_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        ("bake vertices -o lit.gltf", "name it .glb"),
        ("bake vertices -o nowhere/lit.glb", "its folder"),
        ("bake vertices -o lit.glb --light indirect --bounces 0", "leaves no light"),
        ("bake vertices -o lit.glb --unlit 1000", "-100 to 100 stops"),
        ("bake vertices -o lit.glb --places 0", "--places"),
    ] {
        let run = hemicube(folder.path(), arguments);
        assert!(run.code == 2 && run.err.contains(words), "{arguments}: {run:?}");
        assert!(!folder.path().join("lit.glb").exists(), "{arguments} left a file");
    }
}

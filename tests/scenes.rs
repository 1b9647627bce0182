//! The reference scenes load as they are described. `HEMICUBE_SCENES` names their folder (default `../shared/scenes`).

use glam::Vec3;
use hemicube::scene::{Lens, Light, Scene, Wrap, load};
use std::path::PathBuf;
use std::time::Instant;

/// The scene `name/name.gltf`, or none with a loud line where the scenes are absent.
fn scene(name: &str) -> Option<Scene> {
    let folder = std::env::var_os("HEMICUBE_SCENES").map_or_else(|| PathBuf::from("../shared/scenes"), PathBuf::from);
    let path = folder.join(name).join(format!("{name}.gltf"));
    if !path.exists() {
        eprintln!("!!! {} is absent: set HEMICUBE_SCENES; nothing is checked", path.display());
        return None;
    }
    let start = Instant::now();
    let scene = load(&path).unwrap_or_else(|e| panic!("{e}"));
    eprintln!("{name}: {:.1} ms; notes {:?}", start.elapsed().as_secs_f64() * 1e3, scene.notes);
    check_contract(&scene);
    Some(scene)
}

/// What [`Scene`]'s fields promise.
fn check_contract(scene: &Scene) {
    let n = scene.positions.len();
    assert_eq!(scene.normals.len(), n);
    for stream in [scene.tangents.len(), scene.uvs[0].len(), scene.uvs[1].len(), scene.colors.len()] {
        assert!(stream == 0 || stream == n);
    }
    assert!(scene.positions.iter().all(|p| p.is_finite()));
    assert!(scene.normals.iter().all(|n| n.is_normalized()));
    let mut next = 0;
    for part in &scene.parts {
        assert_eq!(part.first_triangle, next);
        assert!(part.triangle_count > 0 && (part.material as usize) < scene.materials.len());
        next += part.triangle_count;
    }
    assert_eq!(next as usize, scene.triangles.len());
    assert!(scene.triangles.iter().flatten().all(|v| (*v as usize) < n));
}

#[test]
fn cornell_box() {
    let Some(scene) = scene("cornell") else { return };
    assert_eq!((scene.name.as_str(), scene.triangles.len(), scene.materials.len()), ("cornell", 32, 4));
    let light = scene.materials.iter().find(|m| m.name == "light").expect("a light");
    assert!((light.emission - Vec3::new(17.0, 12.0, 4.0)).abs().max_element() < 1e-5, "{}", light.emission);
    assert!(!light.double_sided && scene.materials[0].double_sided);
    let camera = &scene.cameras[0];
    assert_eq!(camera.name, "camera");
    assert!(matches!(camera.lens, Lens::Perspective { aspect: Some(a), .. } if a == 1.0));
    assert!(camera.camera_to_world.z_axis.z < -0.999, "looks along +z");
    assert!(scene.uvs[0].is_empty() && scene.notes.is_empty() && scene.origin == glam::DVec3::ZERO);
}

#[test]
fn sponza() {
    let Some(scene) = scene("sponza") else { return };
    assert_eq!((scene.triangles.len(), scene.textures.len()), (66_445, 10));
    assert!(scene.textures.iter().all(|t| t.wrap == [Wrap::Repeat; 2] && !t.nearest));
    let [Light::Directional { direction, irradiance }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert!(direction.y < -0.5, "{direction}");
    assert!((irradiance - Vec3::new(20.0, 19.0, 17.0)).abs().max_element() < 1e-5);
    assert_eq!(scene.uvs[0].len(), scene.positions.len());
}

#[test]
fn living_room() {
    let Some(scene) = scene("living-room") else { return };
    assert_eq!((scene.triangles.len(), scene.textures.len()), (131_809, 4));
    assert!(scene.materials.iter().any(|m| m.emission != Vec3::ZERO));
}

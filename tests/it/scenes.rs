//! The reference scenes load as they are described. `HEMICUBE_SCENES` names their folder (default `../shared/scenes`).

use crate::common::scene_folder;
use glam::Vec3;
use hemicube::scene::{Lens, Light, Scene, Wrap, cornell, load};
use std::time::Instant;

/// The scene `name/name.gltf`; `None`, which is reported, where there are no reference scenes.
fn scene(name: &str) -> Option<Scene> {
    let path = scene_folder(name)?.join(format!("{name}.gltf"));
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
    assert!(scene.uvs[0].is_empty() && scene.origin == glam::DVec3::ZERO);
    assert_eq!(scene.notes, ["extension KHR_materials_specular is ignored"], "its factor 0 says that all is diffuse");
}

#[test]
fn the_built_in_box_is_the_reference_box() {
    let Some(reference) = scene("cornell") else { return };
    let built_in = cornell();
    // Total area of each colour, and of what emits.
    let areas = |scene: &Scene| {
        let mut areas: Vec<([u32; 3], f64)> = Vec::new();
        for triangle in 0..scene.triangles.len() as u32 {
            let point = scene.surface(triangle, glam::Vec2::splat(1.0 / 3.0));
            let color = (point.albedo + point.emission).to_array().map(|x| (x * 1000.0).round() as u32);
            let area = f64::from(scene.area(triangle));
            match areas.iter_mut().find(|(known, _)| *known == color) {
                Some((_, sum)) => *sum += area,
                None => areas.push((color, area)),
            }
        }
        areas.sort_by_key(|(color, _)| *color);
        areas
    };
    let (a, b) = (areas(&built_in), areas(&reference));
    assert_eq!((built_in.triangles.len(), a.len()), (reference.triangles.len(), b.len()));
    for ((color, area), (other_color, other_area)) in a.into_iter().zip(b) {
        assert_eq!(color, other_color);
        assert!((area - other_area).abs() < 1e-6 * area, "{color:?}: {area} {other_area}");
    }
    let difference = built_in.cameras[0].camera_to_world - reference.cameras[0].camera_to_world;
    assert!(difference.to_cols_array().iter().all(|x| x.abs() < 1e-9), "{difference}");
    let yfov = |s: &Scene| if let Lens::Perspective { yfov, .. } = s.cameras[0].lens { yfov } else { 0.0 };
    assert!((yfov(&built_in) - yfov(&reference)).abs() < 1e-6);
}

#[test]
fn sponza() {
    let Some(scene) = scene("sponza") else { return };
    assert_eq!((scene.triangles.len(), scene.textures.len()), (66_445, 10));
    // Summed by a program of its own from the buffers.
    let area: f64 = (0..66_445).map(|t| f64::from(scene.area(t))).sum();
    assert!((area - 7_502.905_72).abs() < 1e-3, "{area}");
    let (low, high) = scene.bounds();
    assert!((low - Vec3::new(-17.402_76, -0.906_689, -7.798_513)).length() < 1e-5, "{low}");
    assert!((high - Vec3::new(17.417_24, 15.653_314, 7.801_49)).length() < 1e-5, "{high}");
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

use super::{Extras, write};
use crate::scene::build::{Builder, diffuse};
use crate::scene::{self, Light, Material, Scene, TextureRef, cornell};
use glam::{Mat3, Vec2, Vec3, vec3};
use serde_json::Value;

fn read(bytes: &[u8]) -> Scene {
    scene::load_from_slice("baked.glb", bytes, &|name| panic!("{name}"), scene::Options::default()).unwrap()
}

fn document(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

fn close(a: &[Vec3], b: &[Vec3]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.distance(*b) < 1e-5)
}

/// A scene with a texture that is moved, a mask, an emitter and a spot.
fn room() -> Scene {
    let mut b = Builder::default();
    let texture = b.texture(2, 2, vec![[255, 0, 0, 255], [0, 255, 0, 0], [0, 0, 255, 255], [9, 8, 7, 255]], true);
    let transform = Mat3::from_translation(Vec2::new(0.25, 0.5))
        * Mat3::from_rotation_z(0.3)
        * Mat3::from_scale(Vec2::new(2.0, -1.5));
    let base_texture = Some(TextureRef { texture, set: 0, transform });
    let floor = b.material(Material { base_texture, alpha_cutoff: Some(0.25), name: "floor".into(), ..diffuse(0.5) });
    let lamp = b.material(Material { emission: vec3(3.0, 2.0, 0.5), double_sided: false, ..diffuse(0.0) });
    b.floor(floor, 0.0, 1.0);
    b.ceiling(lamp, 2.0, 0.2);
    let (cos_inner, cos_outer) = (0.9, 0.8);
    let direction = vec3(0.6, -0.8, 0.0);
    b.light(Light::Spot { position: Vec3::Y, direction, intensity: vec3(1.0, 2.0, 3.0), cos_inner, cos_outer });
    b.light(Light::Directional { direction, irradiance: vec3(0.5, 0.25, 0.0) });
    b.build()
}

#[test]
fn what_is_written_is_read_again() {
    let scene = room();
    let again = read(&write(&scene, &Extras::default()).unwrap());
    assert!(close(&scene.positions, &again.positions) && close(&scene.normals, &again.normals));
    assert_eq!(
        (&scene.triangles, &scene.parts, &scene.textures.len()),
        (&again.triangles, &again.parts, &again.textures.len())
    );
    assert_eq!(scene.textures[0].rgba, again.textures[0].rgba);
    assert!(scene.textures[0].nearest && again.textures[0].nearest);
    let [was, is] = [&scene, &again].map(|scene| scene.materials[0].base_texture.unwrap().transform);
    assert!(was.abs_diff_eq(is, 1e-5), "{was} {is}");
    let [was, is] = [&scene, &again].map(|scene| (scene.materials[0].alpha_cutoff, scene.materials[1].emission));
    assert_eq!(was, is);
    for (was, is) in scene.lights.iter().zip(&again.lights) {
        match (was, is) {
            (Light::Spot { direction: a, intensity: i, .. }, Light::Spot { direction: b, intensity: j, .. })
            | (
                Light::Directional { direction: a, irradiance: i },
                Light::Directional { direction: b, irradiance: j },
            ) => {
                assert!(a.distance(*b) < 1e-5 && i.distance(*j) < 1e-5);
            }
            _ => panic!("{was:?} became {is:?}"),
        }
    }
}

#[test]
fn cameras_stay_where_they_are() {
    let scene = cornell();
    let again = read(&write(&scene, &Extras::default()).unwrap());
    let [was, is] = [&scene, &again].map(|scene| scene.cameras[0].clone());
    assert!(was.camera_to_world.abs_diff_eq(is.camera_to_world, 1e-6), "{was:?} {is:?}");
    assert_eq!(scene.change_to(&again).filter(|what| *what != "materials"), None);
}

#[test]
fn light_is_an_attribute_and_on_demand_a_colour() {
    let scene = room();
    let irradiance: Vec<_> = (0..scene.positions.len()).map(|i| Vec3::splat(i as f32)).collect();
    let extras = Extras { irradiance: Some(irradiance), unlit_stops: Some(0.0) };
    let file = document(&write(&scene, &extras).unwrap());
    let attributes = &file["meshes"][0]["primitives"][0]["attributes"];
    let light = &file["accessors"][attributes["_IRRADIANCE"].as_u64().unwrap() as usize];
    assert_eq!((light["type"].as_str(), light["componentType"].as_u64()), (Some("VEC3"), Some(5126)));
    assert!(attributes["COLOR_0"].is_u64());
    assert!(file["materials"][0]["extensions"]["KHR_materials_unlit"].is_object());
    assert_eq!(write(&scene, &extras).unwrap(), write(&scene, &extras).unwrap(), "the same bits");
}

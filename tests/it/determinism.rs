//! The same input gives the same bits; parts left out change none; the image's size changes no light.

use crate::common::build::{Facing, diffuse};
use crate::common::{Builder, assert_same_bits, draw, look, picture, small};
use glam::{Mat3, Vec3, dvec3, vec3};
use hemicube::image::Picture;
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Light, Material, Scene, TextureRef, cornell, load};

/// A textured room with a sun through its open top and a lamp.
fn textured() -> (Scene, Camera) {
    let mut b = Builder::default();
    let texels = (0..256).map(|i: u32| [(i * 37 % 200 + 40) as u8, (i * 91 % 180 + 50) as u8, 120, 255]).collect();
    let texture = b.texture(16, 16, texels, false);
    let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let wall = b.material(Material { base_texture, ..diffuse(0.9) });
    b.floor(wall, 0.0, 1.0);
    b.quad(wall, vec3(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::Y);
    b.cuboid(wall, vec3(-0.2, 0.0, -0.4), vec3(0.3, 0.5, 0.1), Facing::Out);
    b.light(Light::Directional { direction: vec3(0.4, -1.0, -0.5).normalize(), irradiance: vec3(5.0, 4.0, 3.0) });
    b.light(Light::Point { position: vec3(0.6, 0.8, 0.4), intensity: vec3(0.2, 0.3, 0.5) });
    (b.build(), look(dvec3(0.8, 1.0, 1.6), dvec3(0.0, 0.2, 0.0), 60.0))
}

fn pictures(scene: &Scene, camera: &Camera, settings: &Settings) -> [Picture; 2] {
    [(); 2].map(|()| picture(scene, camera, settings))
}

#[test]
fn two_frames_are_the_same() {
    let scene = cornell();
    let [a, b] = pictures(&scene, &scene.cameras[0], &small(96));
    assert_same_bits(&a, &b, "Cornell box");
    let (scene, camera) = textured();
    let [a, b] = pictures(&scene, &camera, &small(96));
    assert_same_bits(&a, &b, "textured");
}

#[test]
fn two_processes_write_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a.exr", "b.exr"].map(|name| {
        let run = crate::common::program::hemicube(
            folder.path(),
            &format!("render -q -o {name} --width 80 --height 64 --layers all"),
        );
        assert!(run.is_clean(), "{run:?}");
        std::fs::read(folder.path().join(name)).unwrap()
    });
    assert!(files[0] == files[1], "the files differ");
}

#[test]
fn parts_left_out_change_no_pixel() {
    let compare = |what: &str, scene: &Scene, camera: &Camera, settings: Settings| {
        let full = draw(scene, camera, &Settings { full_plan: true, ..settings.clone() });
        let planned = draw(scene, camera, &settings);
        assert!(full.plan.left_out().len() < planned.plan.left_out().len(), "{what}: the full plan leaves less out");
        let (mut planned_picture, mut full_picture) = (planned.picture, full.picture);
        if full.plan.captures != planned.plan.captures {
            // Counts the work done, not light.
            planned_picture.channels.remove("records.Y");
            full_picture.channels.remove("records.Y");
        }
        assert_same_bits(&planned_picture, &full_picture, what);
    };
    let scene = cornell();
    compare("Cornell box", &scene, &scene.cameras[0], small(96));
    compare("Cornell box, direct light", &scene, &scene.cameras[0], Settings { bounces: 0, ..small(64) });
    let (scene, camera) = textured();
    compare("textured", &scene, &camera, small(96));
    let mut dark = scene;
    dark.lights.clear();
    compare("without any light", &dark, &camera, small(48));
}

#[test]
fn doubling_width_and_height_keeps_the_light() {
    let scene = cornell();
    let camera = &scene.cameras[0];
    let mean = |side: u32| {
        let picture = picture(&scene, camera, &Settings { surface_cells: Some(1 << 16), ..small(side) });
        let mask = picture.scalar("mask").unwrap();
        let lit = mask.iter().filter(|m| **m == 1.0).count() as f64;
        ["irradiance", "irradiance_direct", ""].map(|layer| {
            let sum = |plane: &[f32]| plane.iter().zip(mask).map(|(v, m)| f64::from(v * m)).sum::<f64>();
            picture.rgb(layer).unwrap().map(|plane| sum(plane) / lit)
        })
    };
    let (small, large) = (mean(80), mean(160));
    for (layer, (a, b)) in ["irradiance", "irradiance_direct", "image"].into_iter().zip(small.into_iter().zip(large)) {
        for (a, b) in a.into_iter().zip(b) {
            eprintln!("{layer}: {:+.3} %", (b / a - 1.0) * 100.0);
            assert!((b / a - 1.0).abs() < 0.01, "{layer}: {a} becomes {b}");
        }
    }
}

/// A file with many triangles, loaded anew each time, which several threads do and order. A hundred records see all of it: a picture
/// this small, for there are devices that take a second for each.
#[test]
fn sponza_is_the_same_twice() {
    let Some(folder) = crate::common::scene_folder("sponza") else { return };
    let [a, b] = [(); 2].map(|()| {
        let scene = load(&folder.join("sponza.gltf")).unwrap();
        picture(&scene, &scene.cameras[0], &small(12))
    });
    assert_same_bits(&a, &b, "Sponza");
}

//! Pictures of scenes that lack something, and by their extension.

use super::folder;
use crate::common::program::hemicube;

#[test]
fn triangles_without_area_show_the_background() {
    let folder = folder();
    let arguments = "render flat.gltf -o flat.exr --width 16 --height 16 --background 1,2,3 --layers all -v";
    let run = hemicube(folder.path(), arguments);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.err.contains("area"), "no note: {}", run.err);
    let picture = hemicube::image::exr::read(&folder.path().join("flat.exr")).unwrap();
    assert!(picture.non_finite().is_empty());
    let [r, g, b] = picture.rgb("").unwrap();
    assert!((0..256).all(|i| [r[i], g[i], b[i]] == [1.0, 2.0, 3.0]), "{:?}", (r[0], g[0], b[0]));
    assert!(picture.scalar("mask").unwrap().iter().all(|m| *m == 0.0));
    let run = hemicube(folder.path(), "render flat.gltf -o flat.exr --width 16 --height 16");
    assert_eq!(run.code, 0, "{run:?}");
    let picture = hemicube::image::exr::read(&folder.path().join("flat.exr")).unwrap();
    assert!(picture.rgb("").unwrap().iter().all(|c| c.iter().all(|v| *v == 0.0)));
}

#[test]
fn a_scene_without_camera_is_framed_and_says_so() {
    let folder = folder();
    let run =
        hemicube(folder.path(), "render good.gltf -o good.exr --width 16 --height 16 --background 1,1,1 --layers mask");
    assert!(run.code == 0 && run.err.contains("no camera"), "{run:?}");
    let picture = hemicube::image::exr::read(&folder.path().join("good.exr")).unwrap();
    assert!(picture.scalar("mask").unwrap().contains(&1.0), "the triangle is in the picture");
}

#[test]
fn a_picture_by_extension() {
    let folder = folder();
    let run = hemicube(folder.path(), "render -q -o out.png --width 32 --height 24 --exposure 1");
    assert!(run.code == 0 && run.out.is_empty() && run.err.is_empty(), "{run:?}");
    let bytes = std::fs::read(folder.path().join("out.png")).unwrap();
    assert!(bytes.starts_with(b"\x89PNG") && bytes[16..24] == [0, 0, 0, 32, 0, 0, 0, 24]);
    let run = hemicube(folder.path(), "render -q -o OUT.EXR --width 16 --height 16 --layers N,Z");
    assert_eq!(run.code, 0, "{run:?}");
    let picture = hemicube::image::exr::read(&folder.path().join("OUT.EXR")).unwrap();
    assert_eq!(picture.layers(), ["", "N", "Z"]);
}

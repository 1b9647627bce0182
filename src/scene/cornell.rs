//! The built-in Cornell box.

use super::{Limits, Scene, load_from_slice};
use std::io;

/// Written by `tools/make_cornell.py` from the published measurements.
const FILE: &[u8] = include_bytes!("../../assets/cornell.gltf");

/// The Cornell box in metres: 32 triangles, one lamp of radiance (17, 12, 4) W·sr⁻¹·m⁻², one camera.
pub fn cornell() -> Scene {
    let nothing = |_: &str| Err(io::ErrorKind::NotFound.into());
    load_from_slice("cornell.gltf", FILE, &nothing, Limits::default()).expect("the embedded scene is valid")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn it_is_the_published_box() {
        let scene = cornell();
        assert_eq!((scene.name.as_str(), scene.triangles.len(), scene.parts.len()), ("cornell", 32, 4));
        assert!(scene.notes.is_empty(), "{:?}", scene.notes);
        let lamps = scene.emitters();
        assert_eq!(lamps.len(), 2);
        for lamp in &lamps {
            assert!((lamp.radiance - Vec3::new(17.0, 12.0, 4.0)).length() < 1e-5 && !lamp.double_sided);
            assert!((lamp.area - 0.5 * 0.130 * 0.105).abs() < 1e-8);
            assert_eq!(scene.geometric_normal(lamp.triangle), Vec3::NEG_Y);
        }
        let forward = -scene.cameras[0].camera_to_world.z_axis;
        assert!((forward.z - 1.0).abs() < 1e-12, "{forward}");
    }

    #[test]
    fn walls_face_inwards_and_blocks_outwards() {
        let scene = cornell();
        let blocks = [Vec3::new(0.1855, 0.08, 0.169), Vec3::new(0.3685, 0.16, 0.3513)];
        for triangle in 0..scene.triangles.len() as u32 {
            let [a, b, c] = scene.corners(triangle);
            let (centre, normal) = ((a + b + c) / 3.0, scene.geometric_normal(triangle));
            let on_box = centre.y > 0.5 || centre.y == 0.0 || centre.x < 0.01 || centre.x > 0.53 || centre.z > 0.55;
            let inwards = |middle: Vec3| normal.dot(middle - centre) > 0.0;
            let outwards = || !blocks.iter().all(|b| inwards(*b));
            assert!(if on_box { inwards(Vec3::splat(0.27)) } else { outwards() }, "{triangle}: {centre} {normal}");
        }
    }
}

//! Which camera is used, and the size of its image.

use super::{Camera, Lens, Scene, SceneError};
use glam::{DMat4, DVec3};

/// Image size where neither the flags nor the camera say otherwise.
const DEFAULT_SIZE: (u32, u32) = (1280, 720);
/// Largest width and height of an image, in pixels.
pub const LARGEST_SIDE: u32 = 16384;

/// Vertical field of view of a made-up camera, in radians (45°).
const FRAME_YFOV: f64 = std::f64::consts::FRAC_PI_4;

impl Scene {
    /// The camera that `wanted` names, by its name first and then by its index; without a wish the file's first, or
    /// else one that frames the scene, which the second value then says in a line for the user.
    pub fn camera(&self, wanted: Option<&str>) -> Result<(Camera, Option<String>), SceneError> {
        let Some(wanted) = wanted else {
            let note = || "the scene has no camera: the whole scene is framed".to_owned();
            return Ok(self.cameras.first().map_or_else(|| (frame(self), Some(note())), |c| (c.clone(), None)));
        };
        let by_name = self.cameras.iter().find(|c| c.name == wanted);
        let by_index = || wanted.parse::<usize>().ok().and_then(|i| self.cameras.get(i));
        by_name.or_else(by_index).map(|c| (c.clone(), None)).ok_or_else(|| self.no_camera(wanted))
    }

    fn no_camera(&self, wanted: &str) -> SceneError {
        let wanted = super::error::quote(wanted);
        let listed = |(i, c): (usize, &Camera)| match c.name.as_str() {
            "" => format!("{i}"),
            name => format!("{i} \"{}\"", super::error::quote(name)),
        };
        let list: Vec<String> = self.cameras.iter().enumerate().map(listed).collect();
        let what = match list.len() {
            0 => format!("no camera \"{wanted}\": the scene has none; leave the choice out to frame the scene"),
            _ => format!("no camera \"{wanted}\"; there are {}", list.join(", ")),
        };
        SceneError::Camera { file: self.name.clone(), what }
    }
}

/// A camera that sees the whole scene from the front, above and right (three-quarter view), at the default shape and
/// any wider one.
pub fn frame(scene: &Scene) -> Camera {
    let (low, high) = scene.bounds();
    let centre = low.as_dvec3().midpoint(high.as_dvec3());
    // A ball about the box is seen whole where the half angle's sine is radius over distance.
    let radius = 0.5 * (high.as_dvec3() - low.as_dvec3()).length();
    let distance = 1.05 * radius / (0.5 * FRAME_YFOV).sin();
    let back = DVec3::new(0.6, 0.45, 1.0).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let rotation = glam::DMat3::from_cols(right, back.cross(right), back);
    Camera {
        name: String::new(),
        camera_to_world: DMat4::from_mat3_translation(rotation, centre + distance * back),
        lens: Lens::Perspective { yfov: FRAME_YFOV, aspect: None },
    }
}

/// Width and height of the image in pixels. A side that is not given follows from the other by the camera's shape
/// (16:9 where it states none); with neither, the camera's shape fits into 1280 × 720.
pub fn image_size(camera: &Camera, width: Option<u32>, height: Option<u32>) -> (u32, u32) {
    let (Lens::Perspective { aspect, .. } | Lens::Orthographic { aspect, .. }) = camera.lens;
    let aspect = aspect.unwrap_or(f64::from(DEFAULT_SIZE.0) / f64::from(DEFAULT_SIZE.1));
    let side = |pixels: f64| pixels.round().clamp(1.0, f64::from(LARGEST_SIDE)) as u32;
    match (width, height) {
        (Some(w), Some(h)) => (w, h),
        (Some(w), None) => (w, side(f64::from(w) / aspect)),
        (None, Some(h)) => (side(f64::from(h) * aspect), h),
        (None, None) => {
            let height = f64::from(DEFAULT_SIZE.1).min(f64::from(DEFAULT_SIZE.0) / aspect);
            (side(height * aspect), side(height))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn camera(name: &str, aspect: Option<f64>) -> Camera {
        let lens = Lens::Perspective { yfov: 1.0, aspect };
        Camera { name: name.into(), camera_to_world: DMat4::IDENTITY, lens }
    }

    #[test]
    fn a_camera_is_found_by_name_or_index() {
        let scene = Scene { cameras: vec![camera("1", None), camera("top", None)], ..Scene::default() };
        assert_eq!(scene.camera(Some("top")).unwrap().0.name, "top");
        assert_eq!(scene.camera(Some("0")).unwrap().0.name, "1");
        assert_eq!(scene.camera(Some("1")).unwrap().0.name, "1", "a name goes before an index");
        assert_eq!(scene.camera(None).unwrap().0.name, "1");
        let line = scene.camera(Some("side")).unwrap_err().to_string();
        assert!(line.contains("there are 0 \"1\", 1 \"top\""), "{line}");
    }

    #[test]
    fn the_framed_camera_sees_every_corner() {
        let positions = vec![Vec3::new(-3.0, 0.0, 100.0), Vec3::new(5.0, 2.0, 101.0), Vec3::new(0.0, 1.0, 100.5)];
        let scene = Scene { positions, triangles: vec![[0, 1, 2]], ..Scene::default() };
        let (camera, note) = scene.camera(None).unwrap();
        assert!(note.is_some());
        let view = camera.camera_to_world.inverse();
        let limit = (0.5 * FRAME_YFOV).tan();
        for corner in 0..8 {
            let pick = |bit: u32, a: f64, b: f64| if corner & bit == 0 { a } else { b };
            let p = view.transform_point3(DVec3::new(pick(1, -3.0, 5.0), pick(2, 0.0, 2.0), pick(4, 100.0, 101.0)));
            assert!(p.z < 0.0 && p.y.abs() < limit * -p.z && p.x.abs() < limit * -p.z, "{p}");
        }
        assert!((camera.camera_to_world.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_missing_side_follows_the_cameras_shape() {
        let square = camera("", Some(1.0));
        assert_eq!(image_size(&square, None, None), (720, 720));
        assert_eq!(image_size(&square, Some(256), None), (256, 256));
        assert_eq!(image_size(&camera("", Some(2.0)), None, None), (1280, 640));
        let free = camera("", None);
        assert_eq!(image_size(&free, None, None), (1280, 720));
        assert_eq!(image_size(&free, None, Some(90)), (160, 90));
        assert_eq!(image_size(&free, Some(7), Some(9)), (7, 9));
    }
}

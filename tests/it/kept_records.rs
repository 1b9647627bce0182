//! Records that outlive a view.

use crate::common::{gpu, scene_folder, small};
use glam::dvec3;
use hemicube::image::exr;
use hemicube::image::metrics::{mask, measure};
use hemicube::renderer::{Rendered, Renderer, Settings};
use hemicube::scene::{Camera, cornell};

/// Views of the Cornell box, one after the other, with the records of those before.
fn draw(cameras: &[&Camera], settings: &Settings) -> Vec<Rendered> {
    let (device, scene) = (gpu(), cornell());
    let before = device.instance.validation_messages();
    let mut renderer = Renderer::open(&device, &scene, settings, &mut |_, _, _| {}).unwrap();
    let mut view = |camera: &&Camera| renderer.render(camera, &settings.view(), &mut |_, _, _| {}).unwrap();
    let rendered = cameras.iter().map(&mut view).collect();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    rendered
}

fn bits(rendered: &Rendered) -> Vec<u32> {
    let channels = rendered.picture.rgb("irradiance").unwrap();
    channels.iter().flat_map(|channel| channel.iter().map(|e| e.to_bits())).collect()
}

/// The same camera needs no record more, and shows the same.
#[test]
fn a_view_twice_is_the_same_for_nothing() {
    let camera = cornell().cameras[0].clone();
    for contrast in [0.0, 0.15] {
        let mut settings = small(96);
        settings.cache.contrast = contrast;
        let views = draw(&[&camera, &camera], &settings);
        let (first, second) = (&views[0], &views[1]);
        eprintln!("contrast {contrast}: {} records, then {}", first.cache.records, second.cache.records);
        assert!(first.cache.records > 0 && first.cache.reused == 0);
        assert_eq!((second.cache.records, second.cache.reused), (0, first.cache.records));
        assert!(bits(first) == bits(second), "the second view differs");
    }
}

/// A moved camera needs few records more, and such views err on average no more than one of its own, against path-traced irradiance.
#[test]
fn a_moved_view_needs_few_records_more() {
    let Some(folder) = scene_folder("cornell") else { return };
    let reference = exr::read(&folder.join("E_256x256.exr")).unwrap();
    let (truth, keep) = (reference.layer("b1").unwrap(), mask(reference.rgb("mask").unwrap()[0]));
    let error = |rendered: &Rendered| {
        let irradiance = rendered.picture.layer("irradiance").unwrap();
        measure(&irradiance, &truth, reference.width as usize, Some(&keep)).mae
    };
    let camera = cornell().cameras[0].clone();
    let settings = small(256);
    let fresh = draw(&[&camera], &settings).remove(0);
    let offsets = [dvec3(0.1, 0.05, 0.0), dvec3(-0.1, 0.0, 0.1), dvec3(0.05, -0.1, -0.1)];
    let mut sum = 0.0;
    for offset in offsets {
        let mut other = camera.clone();
        other.camera_to_world.w_axis += offset.extend(0.0);
        let again = draw(&[&other, &camera], &settings).remove(1);
        let (again_error, fresh_error) = (error(&again), error(&fresh));
        let [added, all] = [&again, &fresh].map(|r| r.cache.records);
        eprintln!("{added} records more instead of {all}; error {again_error:.4} instead of {fresh_error:.4}");
        assert!(added * 3 < all, "{added} records more instead of {all}");
        assert!(again_error <= 1.1 * fresh_error, "{again_error} instead of {fresh_error}");
        sum += again_error;
    }
    let (mean, fresh_error) = (sum / offsets.len() as f64, error(&fresh));
    assert!(mean <= 1.05 * fresh_error, "{mean} instead of {fresh_error}");
}

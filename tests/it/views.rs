//! A scene that stays on the device: views of it, one after the other, cost what is theirs alone; and devices side by side.

use crate::common::{assert_same_bits, gpu, small};
use glam::DVec3;
use hemicube::methods::captures::CaptureMode;
use hemicube::renderer::{Rendered, Renderer, Settings, render};
use hemicube::scene::{Background, Camera, Scene, cornell};
use hemicube::vk::{Device, DeviceChoice, Instance};

fn moved(camera: &Camera, by: DVec3) -> Camera {
    let mut camera = camera.clone();
    camera.camera_to_world.w_axis += by.extend(0.0);
    camera
}

fn quiet(_: &'static str, _: u64, _: u64) {}

fn ran(rendered: &Rendered, pass: &str) -> bool {
    rendered.passes.iter().any(|p| p.name == pass)
}

/// Views of a kept scene whose records are forgotten are those of a scene that is opened for each, bit by bit; but nothing is uploaded for the second one, nothing
/// built, and the surface is not lit again. With each way to capture, with lamps and with a sky.
#[test]
fn a_second_view_costs_what_is_its_own() {
    let mut under_sky = cornell();
    under_sky.background = Background::Constant(glam::Vec3::ONE);
    for scene in [cornell(), under_sky] {
        for capture in [CaptureMode::Compute, CaptureMode::Hemicube] {
            let mut settings = small(32);
            settings.cache.capture = capture;
            let device = gpu();
            let (view, first) = (settings.view(), &scene.cameras[0]);
            let second = moved(first, DVec3::new(0.1, -0.05, -0.1));
            let mut renderer = Renderer::open(&device, &scene, &settings, &mut quiet).unwrap();
            let before = renderer.render(first, &view, &mut quiet).unwrap();
            assert!(ran(&before, "surface_light"));
            renderer.forget_records();
            let after = renderer.render(&second, &view, &mut quiet).unwrap();
            let own = ["clear", "gbuffer", "shadow", "pixel_light", "resolve", "readback"];
            assert!(own.iter().all(|pass| ran(&after, pass)) && !ran(&after, "surface_light"));
            let memory = [&before, &after].map(|frame| (frame.memory.peak, frame.memory.by_use.clone()));
            assert_eq!(memory[0], memory[1], "what the first view took is what the second takes");
            let built: Vec<_> = after.stages.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(built, ["run passes", "read result"]);
            for (kept, camera) in [(&before, first), (&after, &second)] {
                let fresh = render(&device, &scene, camera, &settings, &mut quiet).unwrap();
                assert_eq!(kept.plan, fresh.plan);
                assert_same_bits(&kept.picture, &fresh.picture, "a view of a kept scene");
            }
        }
    }
}

/// Another size, other layers and another accuracy build a view anew, and nothing of the scene.
#[test]
fn settings_of_a_view_change_no_scene() {
    let (device, scene) = (gpu(), cornell());
    let mut renderer = Renderer::open(&device, &scene, &small(24), &mut quiet).unwrap();
    let camera = &scene.cameras[0];
    renderer.render(camera, &small(24).view(), &mut quiet).unwrap();
    let mut other = Settings { planes: small(1).planes[..1].to_vec(), ..small(40) };
    (other.cache.accuracy, other.cache.contrast) = (0.5, 0.0);
    let kept = renderer.render(camera, &other.view(), &mut quiet).unwrap();
    let fresh = render(&device, &scene, camera, &other, &mut quiet).unwrap();
    assert!(!ran(&kept, "surface_light"));
    assert_eq!(kept.plan, fresh.plan);
    assert_same_bits(&kept.picture, &fresh.picture, "a view by other settings");
}

/// Two scenes on two devices, each from a thread of its own.
#[test]
fn two_threads_render_on_two_devices() {
    let (scene, settings) = (cornell(), small(24));
    let frames = |scene: &Scene| {
        let device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
        let rendered = render(&device, scene, &scene.cameras[0], &settings, &mut quiet).unwrap();
        assert_eq!(device.instance.validation_messages(), 0, "validation messages; they are printed above");
        rendered.picture
    };
    let [a, b] = std::thread::scope(|threads| {
        [threads.spawn(|| frames(&scene)), threads.spawn(|| frames(&scene))].map(|thread| thread.join().unwrap())
    });
    assert_same_bits(&a, &b, "two threads");
    assert_same_bits(&a, &frames(&scene), "two threads and one");
}

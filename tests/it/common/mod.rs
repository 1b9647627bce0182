//! Helpers of all tests: the shared device, with validation on; scenes made in code; closed forms; files from outside.

pub mod closed_forms;
pub mod energy;
pub mod files;
pub mod gltf;
pub mod probes;
pub mod program;

pub use files::{conformance_folder, gltf_files, not_checked, scene_folder};
pub use hemicube::scene::build::{self, Builder, look, look_parallel};

use glam::{DVec3, Vec3, vec3};
use hemicube::image::Picture;
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE};
use hemicube::passes::cluster_tree::TreeSize;
use hemicube::passes::resolve::Plane;
use hemicube::renderer::{Rendered, Settings, render};
use hemicube::scene::{Camera, Scene};
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// The shared device, validated; the holder of the guard records alone. No device is a failure.
pub fn gpu() -> MutexGuard<'static, Arc<Device>> {
    static GPU: OnceLock<Mutex<Arc<Device>>> = OnceLock::new();
    let open = || {
        let instance =
            Instance::new(true).unwrap_or_else(|e| panic!("these tests need Vulkan and its validation: {e}"));
        let device =
            Device::new(instance, &DeviceChoice::Best).unwrap_or_else(|e| panic!("these tests need a device: {e}"));
        eprintln!("device: {} ({})", device.physical.name, device.physical.driver);
        Mutex::new(device)
    };
    GPU.get_or_init(open).lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the shared device can capture `scene` in compute. Mesa lavapipe must; a device whose buffers are too small is
/// reported with the limit. (`memory` tests on every device that such a capture is refused.)
pub fn holds(scene: &Scene) -> bool {
    let misfit = TreeSize::exact(scene.triangles.len()).misfit(&gpu());
    misfit.as_ref().is_none_or(|why| {
        device_lacks(&format!("no captures in compute: {why}"));
        false
    })
}

/// Reports a limit of the shared device that keeps a test from its checks; a failure on llvmpipe, whose limits are known.
pub fn device_lacks(why: &str) {
    assert!(!gpu().physical.name.contains("llvmpipe"), "{why}");
    not_checked(why);
}

/// Renders on the shared device; a validation message fails the test.
pub fn draw(scene: &Scene, camera: &Camera, settings: &Settings) -> Rendered {
    let device = gpu();
    let before = device.instance.validation_messages();
    let rendered = render(&device, scene, camera, settings, &mut |_, _, _| {}).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    rendered
}

/// The picture of [`draw`], every value of it a number and every surface covered.
pub fn picture(scene: &Scene, camera: &Camera, settings: &Settings) -> Picture {
    let rendered = draw(scene, camera, settings);
    check_complete(&rendered);
    rendered.picture
}

/// No NaN or infinite value; where records were made, each pixel that reflects has one.
pub fn check_complete(rendered: &Rendered) {
    let picture = &rendered.picture;
    assert!(picture.non_finite().is_empty(), "NaN or infinite values: {:?}", picture.non_finite());
    let (Some(mask), Some(records)) = (picture.scalar("mask"), picture.scalar("records")) else { return };
    if rendered.plan.captures {
        let bare = mask.iter().zip(records).filter(|(mask, records)| **mask == 1.0 && **records < 1.0).count();
        assert_eq!(bare, 0, "pixels without a record");
    }
}

/// Factors of a light's red, green and blue, so that mixed-up channels show.
pub const TINT: [f64; 3] = [1.0, 2.0, 0.5];

/// A value in that tint.
pub fn tinted(value: f32) -> Vec3 {
    value * vec3(1.0, 2.0, 0.5)
}

/// Whether a point lies above the square of that half width about the origin, or below.
pub fn inside(p: DVec3, half: f64) -> bool {
    p.x.abs() <= half && p.z.abs() <= half
}

/// All layers of a small square image of a small scene.
pub fn small(side: u32) -> Settings {
    Settings {
        width: side,
        height: side,
        planes: Plane::ALL.to_vec(),
        surface_cells: Some(1 << 14),
        ..Settings::default()
    }
}

/// The settings for each way to capture: render passes, and compute.
pub fn each_capture(settings: Settings) -> [Settings; 2] {
    [CaptureMode::Hemicube, CaptureMode::Compute].map(|capture| {
        let mut settings = settings.clone();
        settings.cache.capture = capture;
        settings
    })
}

/// The settings for every kind of capture.
pub fn every_capture(settings: Settings) -> [Settings; 5] {
    let plane = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: true };
    let (compute, disc) = (CaptureMode::Compute, CaptureMode::ComputeHemisphere);
    [CaptureMode::Hemicube, compute, plane, CaptureMode::Hemisphere, disc].map(|capture| {
        let mut settings = settings.clone();
        settings.cache.capture = capture;
        settings
    })
}

/// How far a layer is from a closed form, relative to the closed form's mean.
#[derive(Debug, Clone, Copy, Default)]
pub struct Deviation {
    /// Mean of the absolute error over the mean.
    pub mean: f64,
    /// Largest absolute error over the mean.
    pub max: f64,
    /// Sum over sum.
    pub energy: f64,
    /// Pixels compared.
    pub pixels: usize,
}

/// Compares each channel of `layer` with `colour` times `expected(position, normal)`, where that is something.
pub fn against(
    picture: &Picture,
    layer: &str,
    colour: [f64; 3],
    expected: impl Fn(DVec3, DVec3) -> Option<f64>,
) -> Deviation {
    let [p, n] = ["P", "N"].map(|layer| picture.xyz(layer).unwrap());
    let (values, mask) = (picture.rgb(layer).unwrap(), picture.scalar("mask").unwrap());
    let at = |planes: [&[f32]; 3], i: usize| DVec3::from(planes.map(|plane| f64::from(plane[i])));
    let (mut absolute, mut largest, mut sum, mut wanted, mut pixels) = (0.0, 0.0f64, 0.0, 0.0, 0);
    for i in (0..mask.len()).filter(|i| mask[*i] == 1.0) {
        let Some(value) = expected(at(p, i), at(n, i)) else { continue };
        pixels += 1;
        for (plane, factor) in values.iter().zip(colour) {
            let (is, should) = (f64::from(plane[i]), value * factor);
            absolute += (is - should).abs();
            largest = largest.max((is - should).abs() / factor.max(1e-30));
            sum += is;
            wanted += should;
        }
    }
    assert!(pixels > 0, "no pixel is compared");
    let mean_colour = colour.iter().sum::<f64>();
    let mean = wanted / mean_colour / pixels as f64;
    Deviation { mean: absolute / wanted, max: largest / mean, energy: sum / wanted, pixels }
}

/// Reports `deviation` and fails above the limits on its mean, its maximum and |energy − 1|.
#[track_caller]
pub fn assert_close(what: &str, deviation: Deviation, mean: f64, max: f64, energy: f64) {
    let Deviation { mean: m, max: x, energy: e, pixels } = deviation;
    eprintln!(
        "{what}: mean error {:.3} %, largest {:.3} %, energy {:+.3} % over {pixels} pixels",
        m * 1e2,
        x * 1e2,
        (e - 1.0) * 1e2
    );
    assert!(m <= mean, "{what}: mean error {m} is above {mean}");
    assert!(x <= max, "{what}: largest error {x} is above {max}");
    assert!((e - 1.0).abs() <= energy, "{what}: energy {e} is more than {energy} from 1");
}

/// Fails where the pictures differ in any bit, and says in which channel and by how much.
#[track_caller]
pub fn assert_same_bits(a: &Picture, b: &Picture, what: &str) {
    assert_eq!((a.width, a.height), (b.width, b.height));
    assert!(a.channels.keys().eq(b.channels.keys()), "{what}: other layers");
    let mut wrong = Vec::new();
    for ((name, a), (_, b)) in a.channels.iter().zip(&b.channels) {
        let differ = a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits());
        let (count, largest) = differ.fold((0, 0.0f32), |(n, x), (a, b)| (n + 1, x.max((a - b).abs())));
        if count > 0 {
            wrong.push(format!("{count} pixels of {name} differ, by {largest} at most"));
        }
    }
    assert!(wrong.is_empty(), "{what}: {}", wrong.join("; "));
}

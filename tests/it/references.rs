//! The reference scenes at their references' size, default settings, against path-traced irradiance.
//!
//! `HEMICUBE_SCENES` names their folder (default `../shared/scenes`). A reference is the irradiance at pixel centres, split
//! by the number of reflections: `dir` (0) and `b1` (exactly 1).

use crate::common::{check_complete, draw, scene_folder};
use hemicube::image::metrics::{Metrics, mask, measure};
use hemicube::image::{Picture, exr};
use hemicube::passes::integrate::Gradients;
use hemicube::passes::resolve::Plane;
use hemicube::renderer::Settings;
use hemicube::scene::load;

/// What is promised of a scene.
struct Promise {
    /// Most mean absolute error of the indirect irradiance over its mean.
    mae: f64,
    /// Most that its energy differs from the reference's.
    energy: f64,
}

fn compare(rendered: &Picture, reference: &Picture, [test, truth]: [&str; 2], keep: &[bool]) -> Metrics {
    let width = reference.width as usize;
    measure(&rendered.layer(test).unwrap(), &reference.layer(truth).unwrap(), width, Some(keep))
}

fn check(name: &str, size: [u32; 2], promise: Promise) {
    let Some(folder) = scene_folder(name) else { return };
    let scene = load(&folder.join(format!("{name}.gltf"))).unwrap();
    let [width, height] = size;
    let reference = exr::read(&folder.join(format!("E_{width}x{height}.exr"))).unwrap();
    let planes = vec![Plane::Irradiance, Plane::DirectIrradiance, Plane::Position, Plane::Records, Plane::Mask];
    let settings = Settings { width, height, planes, ..Settings::default() };
    let rendered = draw(&scene, &scene.cameras[0], &settings);
    check_complete(&rendered);
    let picture = &rendered.picture;
    let keep = mask(reference.rgb("mask").unwrap()[0]);
    // At silhouettes the two programs may disagree about which surface a pixel's centre sees.
    let other = keep.iter().zip(mask(picture.scalar("mask").unwrap())).filter(|(a, b)| **a != *b).count();
    assert!(other * 1000 <= keep.len(), "{name}: {other} pixels see something else");

    let indirect = compare(picture, &reference, ["irradiance", "b1"], &keep);
    let direct = compare(picture, &reference, ["irradiance_direct", "dir"], &keep);
    let energy = |m: &Metrics| m.energy.unwrap() - 1.0;
    eprintln!(
        "{name} {width} × {height}: indirect {:.2} % (4 × 4: {:.2} %, p99 {:.1} %), energy {:+.2} %; direct {:.2} %, energy {:+.2} %; {} records",
        indirect.mae * 1e2,
        indirect.block_mae * 1e2,
        indirect.p99 * 1e2,
        energy(&indirect) * 1e2,
        direct.mae * 1e2,
        energy(&direct) * 1e2,
        rendered.cache.records
    );
    assert_eq!(indirect.non_finite_test + direct.non_finite_test, 0);
    assert!(indirect.mae <= promise.mae, "{name}: indirect irradiance is {} off", indirect.mae);
    assert!(energy(&indirect).abs() <= promise.energy, "{name}: indirect energy is {} off", energy(&indirect));
    assert!(direct.mae <= 0.03, "{name}: direct irradiance is {} off", direct.mae);
    assert!(energy(&direct).abs() <= promise.energy, "{name}: direct energy is {} off", energy(&direct));
}

#[test]
fn cornell_box() {
    check("cornell", [256, 256], Promise { mae: 0.02, energy: 0.01 });
}

#[test]
fn sponza() {
    check("sponza", [128, 128], Promise { mae: 0.05, energy: 0.02 });
}

#[test]
fn living_room() {
    check("living-room", [256, 144], Promise { mae: 0.05, energy: 0.02 });
}

/// Gradients against constant irradiance in each zone, with as many records: `tools/equal_records.py` does it for any scene.
#[test]
fn gradients_halve_the_error_at_equal_records() {
    let Some(folder) = scene_folder("cornell") else { return };
    let scene = load(&folder.join("cornell.gltf")).unwrap();
    let reference = exr::read(&folder.join("E_256x256.exr")).unwrap();
    let keep = mask(reference.rgb("mask").unwrap()[0]);
    let run = |with: bool, accuracy: f32| {
        let mut settings = Settings { width: 256, height: 256, planes: vec![Plane::Irradiance], ..Settings::default() };
        settings.cache.gradients = Gradients { rotation: with, translation: with };
        // Without gradients records disagree everywhere: no accuracy would give as few.
        (settings.cache.accuracy, settings.cache.contrast) = (accuracy, 0.0);
        let rendered = draw(&scene, &scene.cameras[0], &settings);
        let error = compare(&rendered.picture, &reference, ["irradiance", "b1"], &keep).mae;
        (rendered.cache.records as f64, error)
    };
    for accuracy in [0.6, 0.3] {
        let (records, with) = run(true, accuracy);
        let (mut low, mut high) = (0.05_f32, 2.0_f32);
        let mut without = (0.0, 0.0);
        // The smaller the accuracy, the more records.
        for _ in 0..12 {
            let middle = (low * high).sqrt();
            without = run(false, middle);
            if (without.0 / records - 1.0).abs() <= 0.01 {
                break;
            }
            if without.0 > records { low = middle } else { high = middle }
        }
        let ratio = without.1 / with;
        eprintln!(
            "{records} records: error {with:.4}, without gradients {:.4} of {}: {ratio:.2} ×",
            without.1, without.0
        );
        assert!((without.0 / records - 1.0).abs() <= 0.02, "no accuracy gives {records} records: {}", without.0);
        assert!(ratio >= 2.0, "{ratio}");
    }
}

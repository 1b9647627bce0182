//! What a frame does and how little of it is for nothing: records beside those that were put one by one, fragments of splats,
//! counts of captures, the device's share of the time, shares of its measured limits.

use crate::common::{assert_same_bits, check_complete, draw, program, small};
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::work::Work;
use hemicube::renderer::{Rendered, Settings};
use hemicube::scene::cornell;
use serde_json::Value;

/// The Cornell box, counted. Records may disagree: those that are put for that are none of coverage's.
fn counted(change: impl FnOnce(&mut Settings)) -> (Rendered, Work) {
    let scene = cornell();
    let mut settings = Settings { counts_work: true, ..small(128) };
    settings.cache.contrast = 0.0;
    change(&mut settings);
    let rendered = draw(&scene, &scene.cameras[0], &settings);
    check_complete(&rendered);
    let work = rendered.cache.work.unwrap();
    (rendered, work)
}

/// A batch is as good as records one by one, each put where all before it left a pixel without.
#[test]
fn rounds_place_as_few_records_as_one_at_a_time() {
    let [together, alone] = [None, Some(1)].map(|batch| counted(|s| s.cache.batch = batch).0.cache.records);
    eprintln!(
        "{together} records in rounds, {alone} one by one: coverage efficiency {:.3}",
        alone as f64 / together as f64
    );
    assert!(together as f64 <= 1.06 * alone as f64, "{together} records in rounds, {alone} one by one");
}

#[test]
fn fragments_of_splats_are_counted_and_few() {
    let (rendered, work) = counted(|_| ());
    let records = rendered.picture.scalar("records").unwrap();
    assert_eq!(records.iter().map(|n| *n as u64).sum::<u64>(), work.weighted_fragments);
    let pixels = records.len() as f64;
    let weightless = 1.0 - work.weighted_fragments as f64 / work.fragments as f64;
    eprintln!("{:.1} fragments a pixel, {:.1} % without weight", work.fragments as f64 / pixels, 100.0 * weightless);
    // A disc fills π/4 of its square; seen at 60° it is half as wide, and half of the sphere about it stands above.
    assert!(work.fragments as f64 / pixels < 8.0 && weightless < 0.72, "{work:?}");

    let mut settings = small(128);
    settings.cache.contrast = 0.0;
    let scene = cornell();
    let plain = draw(&scene, &scene.cameras[0], &settings);
    assert!(plain.cache.work.is_none());
    assert_same_bits(&plain.picture, &rendered.picture, "counting");
}

#[test]
fn what_captures_draw_is_counted() {
    let triangles = cornell().triangles.len() as u64;
    let (rendered, work) = counted(|s| s.cache.capture = CaptureMode::Hemicube);
    assert_eq!(work.triangle_views, rendered.cache.records * triangles * 5);
    assert_eq!(work.texels, rendered.cache.records * 3 * 32 * 32);
    // In compute by octets, some of them not full; a view sees one at least.
    let (rendered, work) = counted(|s| s.cache.capture = CaptureMode::Compute);
    let octets = rendered.cache.records * 5..=rendered.cache.records * 5 * 2 * triangles.div_ceil(8);
    assert!(octets.contains(&(work.triangle_views / 8)) && work.triangle_views.is_multiple_of(8), "{work:?}");
}

/// A culled scene: fewer than all triangles, and with culling off by the count of all.
#[test]
fn what_culling_leaves_is_counted() {
    use crate::common::{
        Builder,
        build::{Facing, diffuse},
        look,
    };
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.sphere(grey, glam::Vec3::ZERO, 1.0, 12, Facing::In);
    b.light(hemicube::scene::Light::Point { position: glam::Vec3::ZERO, intensity: glam::Vec3::ONE });
    let scene = b.build();
    let camera = look(glam::DVec3::Z * 0.5, glam::DVec3::ZERO, 60.0);
    let mut settings = Settings { counts_work: true, ..small(32) };
    settings.cache.capture = CaptureMode::Hemicube;
    let rendered = draw(&scene, &camera, &settings);
    let all = rendered.cache.records * scene.triangles.len() as u64 * 5;
    let drawn = rendered.cache.work.unwrap().triangle_views;
    // Each face sees a sixth of the sphere at least, by clusters that reach beyond.
    assert!(drawn > all / 8 && drawn < all, "{drawn} of {all}");
}

/// Between submissions the device waits for the CPU. Loose, for other programs run too.
#[test]
fn the_device_works_most_of_the_time() {
    let folder = tempfile::tempdir().unwrap();
    let run =
        program::hemicube(folder.path(), "render -o out.exr --width 128 --height 128 --measure --stats stats.json");
    assert!(run.is_clean(), "{run:?}");
    let stats: Value = serde_json::from_slice(&std::fs::read(folder.path().join("stats.json")).unwrap()).unwrap();
    let busy = stats["busy"].as_f64().unwrap();
    eprintln!("the device works {:.1} % of the time", 100.0 * busy);
    assert!(busy > 0.5 && busy <= 1.0, "{busy}");

    let limits = stats["limits"].as_array().unwrap();
    for pass in ["capture", "integrate", "splat"] {
        assert!(limits.iter().any(|l| l["pass"].as_str().unwrap().starts_with(pass)), "{pass}");
    }
    for limit in limits {
        let number = |key: &str| limit[key].as_f64().unwrap();
        let pass = stats["passes"].as_array().unwrap().iter().find(|p| p["name"] == limit["pass"]).unwrap();
        let seconds = pass["total_ms"].as_f64().unwrap() * 1e-3;
        assert!((number("share") * number("limit") * seconds / number("count") - 1.0).abs() < 1e-6, "{limit}");
        assert!(number("share") > 0.0 && number("share") < 10.0, "{limit}");
    }
    assert!(stats["work"]["fragments"].as_u64() > stats["work"]["weighted_fragments"].as_u64());
    assert!(run.out.contains("% of the time that passes run") && run.out.contains("fragments of splats a pixel"));
}

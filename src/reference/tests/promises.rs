//! What holds for whole images: threads, resuming, stop rules, and that the cache agrees with the paths.

use super::scenes::*;
use crate::image::metrics::measure;
use crate::reference::ward::{Gradients, Settings as WardSettings, Weight};
use crate::reference::{Progressive, Settings, StateError, Stop, Tracer, View, path_trace, ward};
use crate::scene::{Scene, cornell};
use glam::Vec3;

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let scene = cornell();
    let traced = |threads| {
        with_threads(threads, || {
            let settings = Settings { bounces: 2, seed: 3, batch: 1 };
            path_trace(&scene, &scene.cameras[0], (24, 20), settings, &Stop { spp: Some(16), ..Stop::default() }).0
        })
    };
    assert_eq!(traced(1), traced(5));
    let cached = |threads| {
        with_threads(threads, || {
            let tracer = Tracer::new(&scene);
            let settings = WardSettings { rays: 64, ..WardSettings::default() };
            ward(&tracer, View::new(&scene.cameras[0], 48, 48), &settings, 4, |_, _| ()).picture
        })
    };
    assert_eq!(cached(1), cached(5));
}

#[test]
fn a_resumed_run_is_the_run() {
    let scene = cornell();
    let tracer = Tracer::new(&scene);
    let settings = Settings { bounces: 1, seed: 3, batch: 4 };
    let new = |settings| Progressive::new(&tracer, View::new(&scene.cameras[0], 16, 16), settings);
    let mut whole = new(settings);
    (0..4).for_each(|_| whole.advance());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");
    let mut first = new(settings);
    (0..2).for_each(|_| first.advance());
    first.save(&file).unwrap();
    let mut second = new(Settings { batch: 32, ..settings });
    second.load(&file).unwrap();
    (0..2).for_each(|_| second.advance());
    assert_eq!(second.spp(), 16);
    assert_eq!(second.picture(), whole.picture());

    let other = new(Settings { seed: 4, ..settings }).load(&file);
    assert!(matches!(other, Err(StateError::Other { .. })));
    let bytes = std::fs::read(&file).unwrap();
    for damage in [&bytes[..bytes.len() - 8], &bytes[..20], b"", b"something else altogether"] {
        std::fs::write(&file, damage).unwrap();
        assert!(matches!(second.load(&file), Err(StateError::Damaged { .. })));
    }
    assert!(matches!(second.load(&folder.path().join("none")), Err(StateError::Read { .. })));
}

#[test]
fn stop_rules_stop() {
    let scene = cornell();
    let tracer = Tracer::new(&scene);
    let run = |stop: Stop| {
        let settings = Settings { bounces: 1, seed: 0, batch: 4 };
        let mut run = Progressive::new(&tracer, View::new(&scene.cameras[0], 16, 16), settings);
        let cost = run.run(&stop, |_| Ok::<(), ()>(())).unwrap();
        (run.spp(), run.relative_error(), cost)
    };
    assert_eq!(run(Stop { spp: Some(10), ..Stop::default() }).0, 12);
    let (spp, error, cost) = run(Stop { relative_error: Some(0.1), ..Stop::default() });
    assert!(error <= 0.1 && spp > 32 && cost.rays > spp * 200, "{spp} {error} {cost:?}");
    let limit = std::time::Duration::from_millis(50);
    assert!(run(Stop { time: Some(limit), ..Stop::default() }).2.wall >= limit);
}

#[test]
fn layers_add_up() {
    let scene = cornell();
    let settings = Settings { bounces: 3, seed: 0, batch: 1 };
    let stop = Stop { spp: Some(8), ..Stop::default() };
    let picture = path_trace(&scene, &scene.cameras[0], (32, 32), settings, &stop).0;
    assert!(picture.non_finite().is_empty(), "{:?}", picture.non_finite());
    let layer = |name: &str| picture.rgb(name).unwrap();
    for c in 0..3 {
        for i in 0..picture.pixels() {
            let of = |name: &str| layer(name)[c][i];
            let close = |a: f32, b: f32| (a - b).abs() <= 1e-5 * a.abs().max(1e-3);
            assert!(close(of(""), of("direct") + of("indirect") + of("emission")));
            assert!(close(of("irradiance"), of("b1") + of("b2") + of("b3plus")));
            assert!(close(of("indirect"), of("albedo") * of("irradiance") / std::f32::consts::PI));
            assert_eq!(of("irradiance_direct"), of("dir"));
        }
    }
}

#[test]
fn the_cache_agrees_with_the_paths() {
    let scene = cornell();
    let camera = &scene.cameras[0];
    let size = (64, 64);
    let settings = Settings { bounces: 1, seed: 0, batch: 1 };
    let truth = path_trace(&scene, camera, size, settings, &Stop { spp: Some(1024), ..Stop::default() }).0;
    let mask: Vec<bool> = truth.scalar("mask").unwrap().iter().map(|m| *m > 0.5).collect();
    let tracer = Tracer::new(&scene);
    let error = |settings: WardSettings| {
        let cached = ward(&tracer, View::new(camera, size.0, size.1), &settings, 4, |_, _| ());
        let test = cached.picture.layer("irradiance").unwrap();
        let reference = truth.layer("irradiance").unwrap();
        let m = measure(&test, &reference, size.0 as usize, Some(&mask));
        println!(
            "{:?} {:?}: {} records, mae {:.4}, energy {:?}",
            settings.weight,
            settings.gradients,
            cached.cache.records.len(),
            m.mae,
            m.energy
        );
        assert!(cached.picture.scalar("records").unwrap().iter().zip(&mask).all(|(n, m)| (*n > 0.0) == *m));
        assert!((m.energy.unwrap() - 1.0).abs() < 0.02, "{:?}", m.energy);
        m.mae
    };
    let base = WardSettings { rays: 512, ..WardSettings::default() };
    assert!(error(base) < 0.045);
    assert!(error(WardSettings { weight: Weight::Bounded, ..base }) < 0.045);
    assert!(error(WardSettings { gradients: Gradients::None, ..base }) > error(base));
    assert!(error(WardSettings { bounces: 1, accuracy: 0.1, ..base }) < error(base));
}

#[test]
fn cached_irradiance_scales_with_powers_of_two() {
    let build = |world: f32| {
        let mut scene = Scene::default();
        let scaled = |t: &[[Vec3; 3]]| t.iter().map(|c| c.map(|p| p * world)).collect::<Vec<_>>();
        let faces = box_faces(Vec3::splat(-1.0), Vec3::splat(1.0));
        add(&mut scene, diffuse(0.6), &scaled(&faces[..5].concat()));
        add(&mut scene, emitter(1.0), &scaled(&faces[5]));
        let lens = crate::scene::Lens::Perspective { yfov: 1.5, aspect: None };
        let eye = glam::DMat4::from_translation(glam::dvec3(0.0, 0.0, 0.9) * f64::from(world));
        let camera = crate::scene::Camera { name: String::new(), camera_to_world: eye, lens };
        let tracer = Tracer::new(&scene);
        let settings = WardSettings { rays: 64, ..WardSettings::default() };
        let mut picture = ward(&tracer, View::new(&camera, 24, 24), &settings, 4, |_, _| ()).picture;
        picture.channels.retain(|name, _| !name.starts_with('P') && name != "Z");
        picture
    };
    assert_eq!(build(1.0), build(2f32.powi(-10)));
    assert_eq!(build(1.0), build(2f32.powi(11)));
}

//! Volumes of light in closed form, without a device.

use super::place::{Adaptive, Common, Measured, adaptive, uniform};
use super::reader::ReadSettings;
use super::{Interpolation, Reader, Volume, file};
use glam::{DVec3, UVec3, dvec3};
use std::convert::Infallible;

mod walls;

const ALL: [Interpolation; 4] =
    [Interpolation::Trilinear, Interpolation::InverseDistance, Interpolation::Gradients, Interpolation::Hermite];

fn common() -> Common {
    let bounds = [dvec3(-1.0, 0.0, 2.0), dvec3(1.0, 1.5, 3.0)];
    Common { bounds, order: 2, bounces: "1".into(), inside: 0.25, moments: false }
}

fn by(interpolation: Interpolation) -> ReadSettings {
    ReadSettings { interpolation, guard: true }
}

/// A field that each of four coefficients has in its own measure.
fn measure(places: &[DVec3], f: impl Fn(DVec3) -> (f64, DVec3)) -> Vec<Measured> {
    let one = |place: &DVec3| {
        let (value, slope) = f(*place);
        let shares = [1.0, 0.3, -0.2, 0.1];
        let rgb = |v: f64| (v * dvec3(1.0, 0.8, 0.5)).as_vec3();
        Measured {
            coefficients: shares.map(|share| rgb(share * value)).to_vec(),
            gradients: shares.map(|share| slope.to_array().map(|d| rgb(share * d))).to_vec(),
            ..Measured::default()
        }
    };
    places.iter().map(one).collect()
}

/// Even light and a small bright place.
fn bump(p: DVec3) -> (f64, DVec3) {
    let offset = p - dvec3(0.4, 0.6, 2.3);
    let value = 2.0 * (-offset.length_squared() / 0.08).exp();
    (1.0 + value, -offset / 0.04 * value)
}

fn linear(p: DVec3) -> (f64, DVec3) {
    (1.0 + p.dot(dvec3(0.3, -0.2, 0.1)), dvec3(0.3, -0.2, 0.1))
}

fn cut() -> Adaptive {
    Adaptive { min_level: 1, max_level: 5, error: 0.004, gradient: 0.02, harmonic: 1.0 }
}

fn of_bump(settings: &Adaptive) -> Volume {
    let mut look = |places: &[DVec3]| Ok::<_, Infallible>(measure(places, bump));
    adaptive(&common(), settings, &mut look).unwrap().0
}

/// Points all over the box, by a sequence of golden ratios (Roberts 2018).
fn points(count: usize) -> impl Iterator<Item = DVec3> {
    let [low, high] = common().bounds;
    let steps = dvec3(0.819_172_513_396_164, 0.671_043_606_703_789, 0.549_700_477_901_970);
    (1..=count).map(move |i| low + (steps * i as f64 - (steps * i as f64).floor()) * (high - low))
}

fn first(volume: &[DVec3]) -> f64 {
    volume[0].x
}

#[test]
fn linear_light_comes_back_whatever_the_way() {
    let mut look = |places: &[DVec3]| Ok::<_, Infallible>(measure(places, linear));
    let (volume, report) = uniform(&common(), UVec3::splat(4), &mut look).unwrap();
    assert_eq!((report.samples, report.cells, report.moved), (64, 27, 0));
    let reader = Reader::new(&volume);
    let rim = volume.lattice.low - volume.bounds[0];
    for way in ALL {
        for point in points(500) {
            let within = point.clamp(volume.lattice.low, volume.lattice.high);
            let read = |point| first(&reader.read(point, by(way)).unwrap());
            let allowed = if way == Interpolation::InverseDistance { 0.2 } else { 1e-6 };
            assert!((read(within) - linear(within).0).abs() < allowed, "{way:?} at {within}");
            // In the rim the light is that of the nearest point of the cells; gradients go on.
            let in_rim = if way == Interpolation::Gradients { 1e-6 } else { allowed + linear(point).1.abs().dot(rim) };
            assert!((read(point) - linear(point).0).abs() < in_rim, "{way:?} at {point}");
        }
    }
}

#[test]
fn a_sample_is_read_where_it_stands() {
    let volume = of_bump(&cut());
    let reader = Reader::new(&volume);
    let corners = super::tree::corners_of(&volume.lattice);
    for way in [Interpolation::Trilinear, Interpolation::InverseDistance, Interpolation::Hermite] {
        for (corner, number) in &corners {
            let read = first(&reader.read(volume.lattice.place(*corner), by(way)).unwrap());
            let held = f64::from(volume.samples[*number as usize].coefficients[0].x);
            assert!((read - held).abs() < 1e-9, "{way:?} at {corner}: {read} {held}");
        }
    }
}

/// Steps of a billionth across the faces of leaves, whose levels differ: what remains is the slope times the step.
#[test]
fn no_light_jumps_at_the_faces_of_cells() {
    let volume = of_bump(&cut());
    let levels: Vec<u32> = volume.lattice.leaves.iter().map(|leaf| leaf.level).collect();
    assert!(levels.contains(&1) && levels.contains(&5), "{levels:?}");
    let reader = Reader::new(&volume);
    let (low, high) = (volume.lattice.low, volume.lattice.high);
    for way in ALL {
        let mut worst = 0.0_f64;
        for (leaf, point) in volume.lattice.leaves.iter().cycle().zip(points(30_000)) {
            let size = volume.lattice.size(leaf.level);
            let corner = low + leaf.at.as_dvec3() * size;
            let within = (point - low) / (high - low);
            for axis in DVec3::AXES {
                let on_face = corner + size * DVec3::select(axis.cmpeq(DVec3::ONE), DVec3::ZERO, within);
                let sides = [-1e-9, 1e-9].map(|step| (on_face + step * axis).clamp(low, high));
                let [a, b] = sides.map(|side| first(&reader.read(side, by(way)).unwrap()));
                worst = worst.max((a - b).abs());
            }
        }
        eprintln!("{way:?}: {worst:.1e}");
        assert!(worst < 1e-6, "{way:?}: a jump of {worst}");
    }
}

/// 10⁵ random steps of 1 mm through every change of level.
#[test]
fn light_walks_without_popping() {
    let volume = of_bump(&cut());
    let reader = Reader::new(&volume);
    let [low, high] = common().bounds;
    let mut at = (low + high) / 2.0;
    let mut levels = [false; 6];
    let wide = volume.lattice.leaves.iter().find(|leaf| leaf.level == 1).unwrap();
    let calm = low + (wide.at.as_dvec3() + 0.5) * volume.lattice.size(1);
    for way in ALL {
        let mut before = first(&reader.read(at, by(way)).unwrap());
        for (i, point) in points(100_000).enumerate() {
            // Towards the bright place every now and then, so that all levels are passed.
            let aim = if i % 10_000 < 5000 { dvec3(0.4, 0.6, 2.3) } else { calm };
            let way_there = (point - (low + high) / 2.0).normalize() + 0.8 * (aim - at).normalize_or_zero();
            at = (at + 1e-3 * way_there.normalize()).clamp(low, high);
            let now = first(&reader.read(at, by(way)).unwrap());
            assert!((now - before).abs() < 0.05, "{way:?}: {before} to {now} at {at}");
            before = now;
            levels[reader.tree.find(&volume.lattice, at).2 as usize] = true;
        }
    }
    assert!(levels.iter().filter(|l| **l).count() >= 4, "{levels:?}");
}

/// An adaptive volume is no worse than a uniform one of the same finest cells, with a third of the samples at most.
#[test]
fn octrees_need_a_third_of_the_samples() {
    let spot = |p: DVec3| {
        let offset = p - dvec3(0.4, 0.6, 2.3);
        let value = 2.0 * (-offset.length_squared() / 0.02).exp();
        (1.0 + value, -offset / 0.01 * value)
    };
    let mut look = |places: &[DVec3]| Ok::<_, Infallible>(measure(places, spot));
    let (fine, _) = uniform(&common(), UVec3::splat(17), &mut look).unwrap();
    let settings = Adaptive { min_level: 2, max_level: 4, error: 1.5e-3, gradient: 1.5e-3, harmonic: 1.0 };
    let (coarse, report) = adaptive(&common(), &settings, &mut look).unwrap();
    let rms = |volume: &Volume| {
        let reader = Reader::new(volume);
        let error = |p| first(&reader.read(p, by(Interpolation::Hermite)).unwrap()) - spot(p).0;
        (points(20_000).map(|p| error(p).powi(2)).sum::<f64>() / 20_000.0).sqrt()
    };
    let (of_fine, of_coarse) = (rms(&fine), rms(&coarse));
    eprintln!("{} samples {of_fine:.2e}; {} samples {of_coarse:.2e}: {report:?}", fine.samples.len(), report.samples);
    assert!(3 * report.samples <= fine.samples.len(), "{}", report.samples);
    assert!(of_coarse <= 1.02 * of_fine);
    let looked = report.levels.iter().all(|l| l.cut <= l.measured && l.measured <= l.cells);
    assert!(looked && report.levels.iter().any(|l| l.by_gradient > 0), "{report:?}");
}

/// Cells that were cut by the least level, in even light, are whole again in the end.
#[test]
fn redundant_samples_are_culled() {
    let mut look = |places: &[DVec3]| Ok::<_, Infallible>(measure(places, linear));
    let settings = Adaptive { min_level: 3, max_level: 4, error: 0.05, gradient: 1e3, harmonic: 1e3 };
    let (volume, report) = adaptive(&common(), &settings, &mut look).unwrap();
    assert_eq!((volume.samples.len(), volume.lattice.leaves.len()), (8, 1));
    assert_eq!((report.culled_samples, report.culled_cells), (729 - 8, 512 - 1));
    let reader = Reader::new(&volume);
    let read = reader.read(dvec3(0.1, 0.7, 2.5), by(Interpolation::Hermite)).unwrap();
    assert!((first(&read) - linear(dvec3(0.1, 0.7, 2.5)).0).abs() < 1e-6);
}

#[test]
fn a_file_comes_back_and_others_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.json");
    let volume = of_bump(&cut());
    file::write(&path, &volume).unwrap();
    assert_eq!(file::read(&path).unwrap(), volume);
    let text = std::fs::read_to_string(&path).unwrap();
    let refused = |text: &str, words: &str| {
        std::fs::write(&path, text).unwrap();
        let error = file::read(&path).unwrap_err().to_string();
        assert!(error.contains(words) && error.lines().count() == 1, "{words}: {error}");
    };
    refused(&text[..text.len() / 2], "not whole");
    refused(&text.replace("\"version\":1", "\"version\":2"), "version 2");
    refused(&text.replace("hemicube volume", "another"), "its format");
    refused(&text.replace("\"order\":2", "\"order\":7"), "order is 7");
    refused(&text.replace("\"order\":2", "\"order\":3"), "9 coefficients");
    refused(&text.replace("\"leaves\":[[", "\"leaves\":[[1,0,0,0,0,1,2,3,4,5,6,7],["), "do not fill");
    refused(&text.replace("\"divisions\":[1,1,1]", "\"divisions\":[0,1,1]"), "no sound bounds");
}

#[test]
fn a_place_outside_is_refused() {
    let volume = of_bump(&cut());
    let error = Reader::new(&volume).read(dvec3(0.0, 2.0, 2.5), by(Interpolation::Hermite)).unwrap_err().to_string();
    assert!(error.contains("[0, 2, 2.5] lies outside of the volume"), "{error}");
}

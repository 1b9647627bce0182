//! Irradiance volumes baked on the device: in closed form, against another renderer, against differences, and behind walls.

mod closed_forms;

use crate::common::build::{Builder, Facing, diffuse};
use crate::common::{gpu, scene_folder};
use glam::{DVec3, UVec3, Vec3, dvec3, vec3};
use hemicube::math::sh;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::sphere_probes::SphereProbeSettings;
use hemicube::methods::volume::{BakeSettings, Gradients, Places, bake, bounds};
use hemicube::passes::read_volume::ReadVolume;
use hemicube::renderer::Settings;
use hemicube::scene::{Background, Scene};
use hemicube::vk::pass::Recorder;
use hemicube::volume::place::{Adaptive, Placement};
use hemicube::volume::reader::ReadSettings;
use hemicube::volume::{Interpolation, Reader, State, Volume};

fn settings(places: Places, gradients: Gradients, capture_size: u32) -> BakeSettings {
    let probes = SphereProbeSettings {
        order: 3,
        capture_size,
        capture: CaptureMode::Auto,
        gradients: false,
        distances: None,
        lights: Settings::default().lights,
        surface_cells: 1 << 16,
    };
    BakeSettings { probes, places, gradients, bounds: [DVec3::ZERO; 2], inside: 0.25, moments: true }
}

/// The volume of a whole scene.
fn baked(scene: &Scene, settings: &BakeSettings) -> (Volume, Placement) {
    baked_in(scene, settings, bounds(scene))
}

/// The volume of a box.
fn baked_in(scene: &Scene, settings: &BakeSettings, bounds: [DVec3; 2]) -> (Volume, Placement) {
    let settings = BakeSettings { bounds, ..*settings };
    let device = gpu();
    let before = device.instance.validation_messages();
    let mut recorder = Recorder::new(&device);
    let found = bake(&device, &mut recorder, scene, &settings, &mut |_, _| {}).unwrap();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    found
}

/// A dark room of 2.2 m has walls of 5 cm, and bright light outside; samples are half a metre apart. Light in the room, 5 cm and more
/// from its walls, is at most 1 % of the light outside; without the guard it is much more.
#[test]
fn walls_of_five_centimetres_keep_light_out() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 2.05);
    let (low, high) = (vec3(-1.13, 0.62, -1.08), vec3(1.07, 2.82, 1.12));
    b.cuboid(grey, low, high, Facing::In);
    b.cuboid(grey, low - 0.05, high + 0.05, Facing::Out);
    b.quad(grey, vec3(0.0, 4.1, 0.0), Vec3::X * 1e-3, Vec3::Z * 1e-3);
    b.background(Background::Constant(vec3(1.0, 2.0, 3.0)));
    let (volume, placement) = baked(&b.build(), &settings(Places::Uniform(UVec3::splat(9)), Gradients::Edges, 32));
    let size = volume.lattice.size(0);
    assert!((size - 0.5).abs().max_element() < 0.01, "{size}");
    eprintln!("{placement:?}");
    let reader = Reader::new(&volume);
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    for interpolation in
        [Interpolation::Trilinear, Interpolation::InverseDistance, Interpolation::Gradients, Interpolation::Hermite]
    {
        let mean = |point, guard| reader.read(point, ReadSettings { interpolation, guard }).unwrap()[0].y;
        let outside = mean(dvec3(-1.7, 1.5, -1.7), true);
        let (mut worst, mut plain, mut sum) = (0.0_f64, 0.0_f64, 0.0);
        let steps = 16;
        for i in 0..steps * steps * steps {
            let t = dvec3((i % steps) as f64, (i / steps % steps) as f64, (i / steps / steps) as f64) + 0.5;
            // 5 cm and more from the walls.
            let point = low + 0.05 + t / steps as f64 * (high - low - 0.1);
            worst = worst.max(mean(point, true).abs() / outside);
            sum += mean(point, true).abs() / outside / (steps * steps * steps) as f64;
            plain = plain.max(mean(point, false).abs() / outside);
        }
        eprintln!(
            "{interpolation:?}: inside {:.4} % at most, {:.5} % in the mean; without the guard {:.1} %",
            1e2 * worst,
            1e2 * sum,
            1e2 * plain
        );
        assert!(worst < 0.01 && plain > 0.1, "{interpolation:?}: {worst} {plain}");
    }
}

/// Samples inside of a solid block are found; those near its surface are moved out, deeper ones are marked.
#[test]
fn samples_inside_of_a_block_are_moved_or_marked() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.cuboid(grey, vec3(-2.0, -2.0, -2.0), vec3(2.0, 2.0, 2.0), Facing::In);
    b.cuboid(grey, vec3(-1.2, -1.2, -1.2), vec3(1.2, 1.2, 1.2), Facing::Out);
    let (volume, placement) = baked(&b.build(), &settings(Places::Uniform(UVec3::splat(5)), Gradients::None, 16));
    // At −1, 0 and 1 along each axis: the middle one is too deep, all others lie 20 cm below the surface.
    assert_eq!((placement.samples, placement.moved, placement.inside), (125, 26, 1), "{placement:?}");
    for sample in &volume.samples {
        let within = sample.position.abs().max_element() < 1.2;
        assert_eq!(within, sample.state == State::Inside, "{sample:?}");
        if sample.state == State::Moved {
            assert!(sample.back_share < 0.25 && sample.position.abs().max_element() < 1.46, "{sample:?}");
        }
    }
    assert!(volume.contains(DVec3::ZERO));
}

/// Gradients of all coefficients from the edges of a sample's own capture agree with differences of six captures, of 128² texels.
#[test]
fn gradients_by_edges_and_by_differences_agree() {
    let scene = hemicube::scene::cornell();
    let by = |gradients| baked(&scene, &settings(Places::Uniform(UVec3::splat(5)), gradients, 128)).0;
    let (edges, differences) = (by(Gradients::Edges), by(Gradients::Differences(0.01)));
    let interior = |v: &&(DVec3, usize)| {
        let t = (v.0 - edges.lattice.low) / (edges.lattice.high - edges.lattice.low);
        t.cmpgt(DVec3::splat(0.14)).all() && t.cmplt(DVec3::splat(0.91)).all()
    };
    let places: Vec<(DVec3, usize)> = edges.samples.iter().map(|s| s.position).zip(0..).collect();
    let (mut off, mut all) = (0.0, 0.0);
    for (_, i) in places.iter().filter(interior) {
        let (a, b) = (&edges.samples[*i], &differences.samples[*i]);
        // Near surfaces the third derivatives, which differences leave out, are large.
        if a.state != State::Free || a.inverse_distance > 1.0 / 0.15 {
            continue;
        }
        for (of_edges, of_differences) in a.gradients.iter().zip(&b.gradients) {
            for axis in 0..3 {
                off += (of_edges[axis] - of_differences[axis]).length_squared();
                all += of_differences[axis].length_squared();
            }
        }
    }
    let share = (off / all).sqrt();
    eprintln!("gradients by edges beside differences: {:.2} %", 1e2 * share);
    assert!(all > 0.0 && share < 0.02, "{share}");
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Volumes of the Cornell box agree with another renderer at 59 points (../shared/scenes/README.md).
#[test]
fn volumes_of_the_cornell_box_are_another_renderers() {
    let Some(folder) = scene_folder("cornell") else { return };
    let scene = hemicube::scene::load(&folder.join("cornell.gltf")).unwrap();
    let file = std::fs::read_to_string(folder.join("volume.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&file).unwrap();
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let octree = Adaptive { min_level: 2, max_level: 4, error: 0.02, gradient: 0.05, harmonic: 1.0 };
    for places in [Places::Uniform(UVec3::splat(9)), Places::Uniform(UVec3::splat(17)), Places::Adaptive(octree)] {
        let mut settings = settings(places, Gradients::Edges, 32);
        settings.probes.order = 5;
        let (volume, placement) = baked(&scene, &settings);
        let reader = Reader::new(&volume);
        for interpolation in
            [Interpolation::Trilinear, Interpolation::InverseDistance, Interpolation::Gradients, Interpolation::Hermite]
        {
            let (mut off, mut sum, mut energy, mut of_sh, mut all_sh) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for point in file["points"].as_array().unwrap() {
                let place = DVec3::from_slice(&numbers(&point["p"]));
                let read = reader.read(place, ReadSettings { interpolation, guard: true }).unwrap();
                for channel in 0..3 {
                    let got: Vec<f64> = read.iter().map(|c| c[channel]).collect();
                    for (axis, expected) in axes.iter().zip(point["one"]["E"].as_array().unwrap()) {
                        let (e, expected) = (sh::irradiance(&got, *axis), numbers(expected)[channel]);
                        off += (e - expected).abs();
                        energy += e;
                        sum += expected;
                    }
                    for (c, expected) in got.iter().zip(point["one"]["sh"].as_array().unwrap()) {
                        let expected = numbers(expected)[channel];
                        of_sh += (c - expected).powi(2);
                        all_sh += expected * expected;
                    }
                }
            }
            eprintln!(
                "{} samples ({} moved, {} inside), {interpolation:?}: irradiance off by {:.2} %, energy {:.4}, harmonics off by {:.2} %",
                placement.samples,
                placement.moved,
                placement.inside,
                1e2 * off / sum,
                energy / sum,
                1e2 * f64::sqrt(of_sh / all_sh)
            );
            if interpolation == Interpolation::Hermite {
                // In 9 samples a side, 7 cm apart, the shadows of the blocks are lost.
                let [e, energies, sh] =
                    if volume.samples.len() < 1000 { [0.05, 0.02, 0.2] } else { [0.015, 0.01, 0.04] };
                assert!(off / sum < e && (energy / sum - 1.0).abs() < energies && f64::sqrt(of_sh / all_sh) < sh);
            }
        }
    }
}

/// The shader gives the values of its twin on the CPU: at several orders, with gradients and without, guarded and not.
#[test]
fn shaders_read_what_the_twin_reads() {
    let scene = hemicube::scene::cornell();
    let octree = Adaptive { min_level: 1, max_level: 3, error: 0.05, gradient: 0.05, harmonic: 1.0 };
    for (places, gradients, order) in [
        (Places::Uniform(UVec3::splat(5)), Gradients::None, 2),
        (Places::Adaptive(octree), Gradients::Edges, 4),
        (Places::Adaptive(octree), Gradients::Edges, 6),
    ] {
        let mut settings = settings(places, gradients, 16);
        settings.probes.order = order;
        settings.moments = order != 6;
        let (volume, _) = baked(&scene, &settings);
        let reader = Reader::new(&volume);
        let [low, high] = volume.bounds;
        let steps = dvec3(0.819_172_513, 0.671_043_607, 0.549_700_478);
        let places: Vec<DVec3> =
            (1..500).map(|i| low + (steps * f64::from(i) - (steps * f64::from(i)).floor()) * (high - low)).collect();
        for interpolation in [Interpolation::Trilinear, Interpolation::InverseDistance, Interpolation::Gradients] {
            for guard in [true, false] {
                let device = gpu();
                let before = device.instance.validation_messages();
                let read = ReadSettings { interpolation, guard };
                let mut pass = ReadVolume::new(&device, &volume, read, 500).unwrap();
                pass.set_places(&places).unwrap();
                let mut recorder = Recorder::new(&device);
                recorder
                    .submit(|recording| {
                        recording.pass("read_volume", |c| {
                            pass.record(c);
                            Ok(())
                        })?;
                        recording.pass("readback", |c| {
                            pass.record_readback(c);
                            Ok(())
                        })
                    })
                    .unwrap();
                assert_eq!(device.instance.validation_messages() - before, 0, "validation messages");
                let (mut worst, mut most) = (0.0_f64, 0.0_f64);
                for (got, place) in pass.read().iter().zip(&places) {
                    let expected = reader.read(*place, read).unwrap();
                    assert_eq!(got.len(), expected.len());
                    for (a, b) in got.iter().zip(expected) {
                        worst = worst.max((a.as_dvec3() - b).abs().max_element());
                        most = most.max(b.abs().max_element());
                    }
                }
                eprintln!("order {order}, {interpolation:?}, guard {guard}: {worst:.1e} of {most:.2}");
                assert!(worst < 2e-3 * most, "order {order}, {interpolation:?}, {guard}: {worst}");
            }
        }
    }
}

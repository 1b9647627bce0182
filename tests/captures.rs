//! Every kind of capture on the device, through the real passes, against closed forms.

#![allow(clippy::unwrap_used)] // the helpers belong to tests, which the lint cannot see

mod common;

use common::build::{Builder, Facing, diffuse};
use common::closed_forms::{parallelogram, polygon};
use common::{check_complete, draw, gpu, look, small};
use glam::{DVec3, Mat3, Vec3, dvec3, vec3, vec4};
use hemicube::image::metrics::measure as measure_image;
use hemicube::math::capture::{Projection, seen_by_plane};
use hemicube::math::form_factor;
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE};
use hemicube::methods::probes::{Irradiance, Place, Probe, ProbeSettings, Probes};
use hemicube::passes::integrate::Gradients;
use hemicube::renderer::{RenderError, Rendered, Settings, render};
use hemicube::scene::{Background, EnvironmentMap, Light, Material, Scene, SideLimit, TextureRef, cornell};
use hemicube::vk::pass::Recorder;
use hemicube::vk::{self, Device, DeviceChoice, Instance};
use std::f64::consts::PI;
use std::sync::Arc;

const PLANE: CaptureMode = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: true };
const BARE_PLANE: CaptureMode = CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: false };
const WHOLE: [CaptureMode; 5] =
    [CaptureMode::Hemicube, CaptureMode::Compute, PLANE, CaptureMode::Hemisphere, CaptureMode::ComputeHemisphere];

fn measure(scene: &Scene, capture: CaptureMode, capture_size: u32, places: &[Place]) -> Vec<Probe> {
    measure_on(&gpu(), scene, capture, capture_size, places)
}

fn measure_on(
    device: &Arc<Device>,
    scene: &Scene,
    capture: CaptureMode,
    capture_size: u32,
    places: &[Place],
) -> Vec<Probe> {
    let before = device.instance.validation_messages();
    let gradients = Gradients { rotation: true, translation: true };
    let lights = Settings::default().lights;
    let settings = ProbeSettings { capture, capture_size, gradients, lights, surface_cells: 1 << 15 };
    let mut recorder = Recorder::new(device);
    let probes = Probes::new(device, &mut recorder, scene, &settings).unwrap();
    let measured = probes.measure(&mut recorder, places, |_| {}).unwrap();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    measured
}

/// Places at one point of a floor, turned evenly.
fn turned(position: Vec3, count: u32) -> Vec<Place> {
    let turn = |i: u32| i as f32 * 2.399_963; // the golden angle
    (0..count).map(|i| Place { position, normal: Vec3::Y, geometric: Vec3::Y, turn: turn(i) }).collect()
}

fn mean(probes: &[Probe], of: impl Fn(&Probe) -> f32) -> f64 {
    probes.iter().map(|p| f64::from(of(p))).sum::<f64>() / probes.len() as f64
}

/// Nothing but a sky of radiance 1: E = π at every size, to the rounding of as many single-precision weights; the plane
/// without compensation sees its form factor. Nothing changes when the place turns or moves.
#[test]
fn a_furnace_is_exact_at_every_size() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, -1.0, 1.0);
    b.background(Background::Constant(Vec3::ONE));
    let scene = b.build();
    for size in [8, 12, 64, 256] {
        for (capture, share) in WHOLE
            .map(|kind| (kind, 1.0))
            .into_iter()
            .chain([(BARE_PLANE, seen_by_plane((PLANE_APERTURE / 2.0).to_radians().tan()))])
        {
            for probe in measure(&scene, capture, size, &turned(Vec3::ZERO, 2)) {
                let sky = probe.sky.unwrap();
                let e = f64::from(sky.value.y) / PI;
                assert!((e / share - 1.0).abs() < 3e-6, "{capture:?} {size}: {e} of π, not {share}");
                let slope = sky.rotation[1].length().max(sky.translation[1].length());
                assert!(slope < 1e-5, "{capture:?} {size}: gradients {sky:?}");
                assert_eq!(probe.reflected.value, Vec3::ZERO);
                assert_eq!(probe.inverse_distance, 0.0);
            }
        }
    }
    assert!((seen_by_plane(2.0) - 0.831).abs() < 5e-4);
}

/// Inside a sphere that a lamp at its middle lights: E₁ = ρI/s² everywhere, and with cosine weights 1/R = 1/s, for the
/// distance is 2s·cosθ. Gradients are 0.
#[test]
fn the_integrating_sphere_by_every_kind() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 2.0, 96, Facing::In);
    b.light(Light::Point { position: Vec3::ZERO, intensity: Vec3::splat(3.0) });
    let scene = b.build();
    for capture in WHOLE {
        let probes = measure(&scene, capture, 32, &turned(vec3(0.0, -2.0 * 0.9995, 0.0), 16));
        let e = mean(&probes, |p| p.reflected.value.y) / (0.8 * 3.0 / 4.0);
        let r = mean(&probes, |p| p.inverse_distance) * 2.0;
        let slope = mean(&probes, |p| p.reflected.translation[1].length() + p.reflected.rotation[1].length()) / 0.6;
        eprintln!("{capture:?}: E {e:.4}, 1/R {r:.4} of the closed forms, gradients {slope:.4}");
        // 1/d grows without bound towards the horizon: texels that are wide there miss some of it, and a plane's border
        // stands for things whose distances it does not know.
        let of_r = match capture {
            CaptureMode::Plane { .. } => 0.25,
            CaptureMode::Hemisphere | CaptureMode::ComputeHemisphere => 0.08,
            _ => 0.02,
        };
        assert!((e - 1.0).abs() < 0.001 && (r - 1.0).abs() < of_r, "{capture:?}: {e} {r}");
        assert!(slope < 0.03, "{capture:?}: {slope}");
    }
}

/// The rectangle x ∈ [.3, 1.5], z ∈ [−.9, .7], y = 1, which a sun from below makes shine with radiance 1.
fn rectangle() -> (Scene, [DVec3; 4]) {
    let mut b = Builder::default();
    shining_rectangle(&mut b);
    (b.build(), parallelogram(dvec3(0.3, 1.0, -0.9), DVec3::X * 1.2, DVec3::Z * 1.6))
}

fn shining_rectangle(b: &mut Builder) {
    let white = b.material(diffuse(1.0));
    b.quad(white, vec3(0.3, 1.0, -0.9), Vec3::X * 1.2, Vec3::Z * 1.6);
    b.light(Light::Directional { direction: Vec3::Y, irradiance: Vec3::splat(std::f32::consts::PI) });
}

/// Root mean square deviation over turns of E, ∇_r E and ∇_t E from the closed form and its central differences.
fn deviations(scene: &Scene, corners: &[DVec3; 4], capture: CaptureMode, size: u32) -> [f64; 3] {
    let at = |p: DVec3, n: DVec3| polygon(p, n.normalize(), corners);
    let e = at(DVec3::ZERO, DVec3::Y);
    let step = 1e-4;
    let central = |plus: f64, minus: f64| (plus - minus) / (2.0 * step);
    let moved = [DVec3::X, DVec3::Z].map(|d| central(at(step * d, DVec3::Y), at(-step * d, DVec3::Y)));
    let tilted = [DVec3::X, DVec3::Z]
        .map(|d| central(at(DVec3::ZERO, DVec3::Y + step * d), at(DVec3::ZERO, DVec3::Y - step * d)));
    let probes = measure(scene, capture, size, &turned(Vec3::ZERO, 96));
    let rms = |of: &dyn Fn(&Probe) -> f64| (probes.iter().map(of).sum::<f64>() / probes.len() as f64).sqrt();
    let off =
        |v: Vec3, expected: [f64; 2]| (f64::from(v.x) - expected[0]).powi(2) + (f64::from(v.z) - expected[1]).powi(2);
    [
        rms(&|p| (f64::from(p.reflected.value.y) / e - 1.0).powi(2)),
        // E changes by (n × n′)·∇_r E = (n′ − n)·(∇_r E × n).
        rms(&|p| off(p.reflected.rotation[1].cross(Vec3::Y), tilted)) / tilted[0].hypot(tilted[1]),
        rms(&|p| off(p.reflected.translation[1], moved)) / moved[0].hypot(moved[1]),
    ]
}

/// A texel's centre decides what it sees, so that a light's side is off by a random part of a texel along each of the
/// texels it crosses: with h the texel's width the error falls between h (a side along the rows) and h^(3/2) (any other).
#[test]
fn a_rectangle_converges_by_every_kind() {
    let (scene, corners) = rectangle();
    let fine = scene.tessellated(&SideLimit::even(0.04));
    for capture in WHOLE {
        let scene = if capture == CaptureMode::Hemisphere { &fine } else { &scene };
        let errors = [16, 32, 64].map(|size| deviations(scene, &corners, capture, size));
        for (what, name) in ["E", "∇_r E", "∇_t E"].into_iter().enumerate() {
            let [coarse, middle, good] = errors.map(|e| e[what]);
            let order = (coarse / good).log(4.0);
            eprintln!("{capture:?}: {name} {coarse:.4}, {middle:.4}, {good:.4}: order {order:.2}");
            // A plane's texels are twice as wide.
            let scale = if capture == PLANE { 2.0 } else { 1.0 };
            assert!(good < 0.03 * scale, "{capture:?}: {name} {good} at 64²");
            assert!(order > 0.8, "{capture:?}: {name} falls as h^{order}");
        }
    }
}

/// Beside a wall of height 1, down to a millionth of the scene's size, where positions have three bits left:
/// E = ½πL(1 − x/√(x² + 1)). Half of what is seen lies in front of any near plane that the scene's size would give.
#[test]
fn records_beside_a_wall_see_it() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(1.0));
    b.quad(grey, vec3(0.0, 0.0, 20.0), Vec3::NEG_Z * 40.0, Vec3::Y);
    b.light(Light::Directional { direction: Vec3::NEG_X, irradiance: Vec3::ONE });
    let scene = b.build();
    for capture in [CaptureMode::Hemicube, CaptureMode::Compute, PLANE] {
        for share in [1e-2f32, 1e-4, 1e-6] {
            let x = 20.0 * share;
            let probes = measure(&scene, capture, 32, &turned(vec3(x, 0.0, 0.0), 64));
            let e = mean(&probes, |p| p.reflected.value.y) * PI / form_factor::wall(f64::from(x), 1.0);
            eprintln!("{capture:?}: at {share:e} of the scene E is {e:.4} of the closed form");
            // By turns a centre on the wall's own plane falls to either side.
            assert!((e - 1.0).abs() < 0.02, "{capture:?}, {share:e}: {e}");
        }
    }
}

/// A black sheet behind the shining rectangle, farther by a 13,000th: of no texel is it seen in place of the nearer one, from
/// within the scene, where depths of 19 octaves are told apart.
#[test]
fn the_nearer_of_two_sheets_is_seen() {
    let sheets = |behind: bool| {
        let mut b = Builder::default();
        // First, so that of equals it is drawn.
        let black = b.material(diffuse(0.0));
        b.quad(black, vec3(-0.3, -0.5, 0.1), Vec3::X * 1e-3, Vec3::Z * 1e-3);
        if behind {
            b.quad(black, vec3(0.3, 1.0, -0.9) * (1.0 + 1.0 / 13e3), Vec3::X * 1.2, Vec3::Z * 1.6);
        }
        shining_rectangle(&mut b);
        measure(&b.build(), CaptureMode::Compute, 64, &turned(Vec3::ZERO, 16))
    };
    for (one, two) in sheets(false).iter().zip(&sheets(true)) {
        let [one, two] = [one, two].map(|p| p.reflected.value.y);
        assert!((two / one - 1.0).abs() < 1e-5, "{one} becomes {two}");
    }
}

/// A screen with square holes, the sky behind it: E = π − Σ over what is closed.
#[test]
fn alpha_masks_are_seen_through_by_every_kind() {
    let mut b = Builder::default();
    let texels = (0..64).map(|i| if (i + i / 8) % 2 == 0 { [255; 4] } else { [255, 255, 255, 0] }).collect();
    let texture = b.texture(8, 8, texels, true);
    let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let grid = b.material(Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.5) });
    b.floor(grid, 1.0, 1.0);
    b.background(Background::Constant(Vec3::ONE));
    let scene = b.build();
    let side = 0.25;
    let closed = |i: usize| {
        let corner = dvec3((i % 8) as f64 * side - 1.0, 1.0, (i / 8) as f64 * side - 1.0);
        polygon(DVec3::ZERO, DVec3::Y, &parallelogram(corner, DVec3::X * side, DVec3::Z * side))
    };
    let expected = PI - (0..64).filter(|i| (i + i / 8) % 2 == 0).map(closed).sum::<f64>();
    let fine = scene.tessellated(&SideLimit::even(0.1));
    for capture in WHOLE {
        let scene = if capture == CaptureMode::Hemisphere { &fine } else { &scene };
        let e = mean(&measure(scene, capture, 64, &turned(Vec3::ZERO, 32)), |p| p.sky.unwrap().value.y) / expected;
        eprintln!("{capture:?}: {e:.4} of the closed form through a mask");
        assert!((e - 1.0).abs() < 0.01, "{capture:?}: {e}");
    }
}

/// Whole frames at the smallest and largest sizes; compute gives way where a face outgrows shared memory, and says so.
#[test]
fn every_size_renders_and_the_plan_says_by_what() {
    let scene = cornell();
    for capture in WHOLE {
        for size in [8, 128, 256] {
            let mut settings = small(6);
            (settings.cache.capture, settings.cache.capture_size) = (capture, size);
            let rendered = draw(&scene, &scene.cameras[0], &settings);
            check_complete(&rendered);
            let left_out = |pass| rendered.plan.left_out.iter().find(|l| l.pass == pass).map(|l| l.why.clone());
            let ran = |pass| rendered.passes.iter().any(|p| p.name == pass);
            assert!(ran("capture") != ran("capture_compute"));
            let is_curved = capture.projection() == Projection::Hemisphere && ran("capture");
            assert_eq!(left_out("tessellate").is_none(), is_curved);
            if matches!(capture, CaptureMode::Compute | CaptureMode::ComputeHemisphere) {
                let fits = size * size * 4 + 8 <= gpu().capabilities.limits.max_compute_shared_memory_size;
                assert_eq!(ran("capture_compute"), fits);
                assert!(fits || left_out("capture_compute").unwrap().contains("shared memory"));
            }
        }
    }
    for (size, aperture) in [(6, 90.0), (258, 90.0), (9, 90.0), (32, 9.0), (32, 171.0), (32, f64::NAN)] {
        let mut settings = small(12);
        settings.cache.capture = CaptureMode::Plane { aperture, compensated: true };
        settings.cache.capture_size = size;
        assert!(settings.check(&gpu()).is_err(), "{size} {aperture}");
    }
}

/// Leaves of every size and tilt over a floor, round by a filtered mask: of 12 texels, so that bits follow it.
fn leaves(b: &mut Builder) {
    let inside = |i: i32| {
        let (x, y) = (f64::from(i % 12) - 5.5, f64::from(i / 12) - 5.5);
        (6.0 - x.hypot(y)).clamp(0.0, 1.0)
    };
    let texels = (0..144).map(|i| [90, 180, 60, (255.0 * inside(i)) as u8]).collect();
    let texture = b.texture(12, 12, texels, false);
    let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let leaf = b.material(Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.9) });
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    for _ in 0..300 {
        let mut vector = || vec3(random() - 0.5, random() - 0.5, random() - 0.5);
        let (along, across) = (vector(), vector());
        let across = across.reject_from(along).normalize() * 0.4;
        let place = vector() * vec3(4.0, 1.5, 4.0) + Vec3::Y;
        b.quad(leaf, place - along.normalize() * 0.2 - 0.5 * across, along.normalize() * 0.4, across);
    }
}

/// Bits stand for a mask within half a texel of its texture at the mask's border, to either side: over many leaves nothing
/// is lost or gained, and a place's E differs by less than the few hemicube texels that a border sweeps.
#[test]
fn masks_in_compute_are_those_of_render_passes() {
    let mut b = Builder::default();
    leaves(&mut b);
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 4.0);
    b.background(Background::Constant(Vec3::ONE));
    let scene = b.build();
    let places: Vec<_> =
        (0..64).flat_map(|i| turned(vec3((i % 8) as f32 - 3.5, 0.0, (i / 8) as f32 - 3.5) * 0.4, 1)).collect();
    let [render, compute] =
        [CaptureMode::Hemicube, CaptureMode::Compute].map(|capture| measure(&scene, capture, 32, &places));
    let sky = |p: &Probe| p.sky.unwrap().value.y;
    let (a, b) = (mean(&render, sky), mean(&compute, sky));
    let off = |(r, c): (&Probe, &Probe)| f64::from((sky(r) - sky(c)).powi(2));
    let rms = (render.iter().zip(&compute).map(off).sum::<f64>() / places.len() as f64).sqrt() / a;
    eprintln!("through leaves: E {:.4} of that by render passes, {rms:.4} rms", b / a);
    assert!((0.2..0.8).contains(&(a / PI)), "leaves cover a good part: {a}");
    assert!((b / a - 1.0).abs() < 0.005 && rms < 0.02, "{a} {b} {rms}");
}

/// Devices that set triangles up before they are clipped have the vertex stage cut them, in the G-buffer, shadow maps and
/// captures. The same picture, but for pixels and texels whose centre lies within rounding of an edge: a room whose walls go
/// on behind every eye, with a texture, a mask and a light.
#[test]
fn triangles_cut_by_the_vertex_stage_make_the_same_picture() {
    let mut b = Builder::default();
    let texels = |a: [u8; 4], c: [u8; 4]| (0..64).map(|i| if (i + i / 8) % 2 == 0 { a } else { c }).collect::<Vec<_>>();
    let colours = b.texture(8, 8, texels([220, 180, 60, 255], [60, 90, 200, 255]), false);
    let holes = b.texture(8, 8, texels([255; 4], [255, 255, 255, 0]), true);
    let map = |texture| Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    let tiles = b.material(Material { base_texture: map(colours), ..diffuse(0.8) });
    let grid = b.material(Material { base_texture: map(holes), alpha_cutoff: Some(0.5), ..diffuse(0.6) });
    b.cuboid(tiles, vec3(-3.0, 0.0, -3.0), vec3(3.0, 3.0, 3.0), Facing::In);
    b.floor(grid, 0.5, 3.0);
    b.light(Light::Point { position: vec3(1.0, 2.0, 0.5), intensity: Vec3::splat(3.0) });
    let scene = b.build();
    let mut settings = small(32);
    (settings.cache.capture, settings.cache.capture_size, settings.cache.accuracy) = (CaptureMode::Hemicube, 16, 0.6);
    let [whole, cut] = [true, false].map(|clips| {
        let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
        Arc::get_mut(&mut device).unwrap().capabilities.clips_before_setup = clips;
        let camera = look(dvec3(2.5, 1.2, 2.5), dvec3(0.0, 0.8, 0.0), 80.0);
        let rendered = render(&device, &scene, &camera, &settings, &mut |_, _, _| {}).unwrap();
        assert_eq!(device.instance.validation_messages(), 0, "validation messages; they are printed above");
        check_complete(&rendered);
        rendered.picture
    });
    // Which of two places a record takes may hang on a pixel's last digit: the number of records is not compared.
    for (name, values) in whole.channels.iter().filter(|(name, _)| *name != "records.Y") {
        let scale = values.iter().fold(0.0f32, |most, v| most.max(v.abs()));
        let off = values.iter().zip(&cut.channels[name]).filter(|(a, b)| (*a - *b).abs() > 0.01 * scale).count();
        eprintln!("{name}: {off} of {} pixels differ by more than 1 % of the most, {scale}", values.len());
        assert!(off * 100 <= values.len(), "{name}: {off} pixels");
    }
}

/// A device without subgroups that talk.
fn by_workgroups() -> Arc<Device> {
    let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    Arc::get_mut(&mut device).unwrap().capabilities.subgroup = None;
    device
}

/// A device that cannot ballot in subgroups captures by whole workgroups, which list octets in another order: only where
/// two surfaces are equally far may they see the other one. Of a sphere's 130,000 triangles, as many as one subgroup
/// draws, more are seen than are listed at once.
#[test]
fn workgroups_capture_what_subgroups_do() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 2.0, 181, Facing::In);
    b.light(Light::Point { position: vec3(0.5, 0.3, 0.0), intensity: Vec3::splat(3.0) });
    let scene = b.build();
    let device = by_workgroups();
    let places = turned(vec3(0.0, -1.0, 0.0), 8);
    for capture in [CaptureMode::Compute, CaptureMode::ComputeHemisphere] {
        let usual = measure(&scene, capture, 32, &places);
        for (a, b) in usual.iter().zip(measure_on(&device, &scene, capture, 32, &places)) {
            let (a, b) = (a.reflected.value.y, b.reflected.value.y);
            assert!((a / b - 1.0).abs() < 1e-4, "{capture:?}: {a} {b}");
        }
    }
}

/// Subgroups sum the faces that they draw, edges within faces too; workgroups write texels, which are summed afterwards. All
/// sums are the same but for the order in which they add up: of surfaces that nowhere touch, so that no two are equally far,
/// and of a sky.
#[test]
fn sums_of_faces_are_those_of_their_texels() {
    let mut b = Builder::default();
    let red = Material { base_color: vec4(0.8, 0.2, 0.1, 1.0), ..diffuse(0.5) };
    let [grey, red] = [diffuse(0.5), red].map(|m| b.material(m));
    b.floor(grey, 0.0, 4.0);
    b.quad(red, vec3(1.5, 0.1, 4.0), Vec3::NEG_Z * 8.0, Vec3::Y * 2.0);
    for i in 0..12 {
        let low = vec3((i % 4) as f32 * 0.6 - 1.3, 0.1 + i as f32 * 0.1, (i / 4) as f32 * 0.7 - 0.9);
        b.cuboid(red, low, low + vec3(0.2, 0.05, 0.3), Facing::Out);
    }
    b.light(Light::Point { position: vec3(0.5, 1.0, 0.0), intensity: vec3(3.0, 2.0, 1.0) });
    let rgb = (0..32).map(|i| [(i % 8) as f32, 1.0, (i / 8) as f32]).collect();
    b.background(Background::Map(EnvironmentMap { width: 8, height: 4, rgb }));
    let scene = b.build();
    let places: Vec<_> =
        (0..8).flat_map(|i| turned(vec3(i as f32 * 0.3 - 1.0, 0.0, i as f32 * 0.2 - 0.8), 2)).collect();
    let device = by_workgroups();
    for size in [8, 16, 32, 64] {
        let summed = measure(&scene, CaptureMode::Compute, size, &places);
        let texels = measure_on(&device, &scene, CaptureMode::Compute, size, &places);
        for (a, b) in summed.iter().zip(&texels) {
            assert!((a.inverse_distance / b.inverse_distance - 1.0).abs() < 1e-5);
            for (a, b) in [(a.reflected, b.reflected), (a.sky.unwrap(), b.sky.unwrap())] {
                let of = |i: &Irradiance| [[i.value; 1].as_slice(), &i.rotation, &i.translation].concat();
                let most = of(&b).iter().map(|v| v.abs().max_element()).fold(0.0, f32::max);
                let off = of(&a).iter().zip(of(&b)).map(|(a, b)| (*a - b).abs().max_element()).fold(0.0, f32::max);
                assert!(off < 2e-5 * most, "{size}: {a:?} {b:?}");
            }
        }
    }
}

/// Sheets over each other, the lowest last: every one of them is drawn all over the view before the next hides it. llvmpipe
/// ends a shader's loops before that is done; then nobody is shown what is missing.
#[test]
fn what_outlasts_the_loops_of_a_device_is_told() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 4.0);
    for i in 0..600 {
        b.quad(grey, vec3(-4.0, 3.0 - 2.0 * i as f32 / 600.0, -4.0), Vec3::X * 8.0, Vec3::Z * 8.0);
    }
    b.light(Light::Point { position: vec3(0.0, 0.5, 0.0), intensity: Vec3::splat(10.0) });
    let scene = b.build();
    let camera = look(dvec3(2.0, 0.6, 2.0), dvec3(0.0, 0.0, 0.0), 80.0);
    let by = |capture| {
        let mut settings = small(8);
        (settings.cache.capture, settings.cache.capture_size) = (capture, 32);
        render(&gpu(), &scene, &camera, &settings, &mut |_, _, _| {})
    };
    let hemicubes = by(CaptureMode::Hemicube).unwrap();
    let whole = hemicubes.picture.layer("irradiance").unwrap();
    let off = |rendered: Rendered| {
        let m = measure_image(&rendered.picture.layer("irradiance").unwrap(), &whole, 8, None);
        eprintln!("{:.2} % off", m.mae * 1e2);
        m.mae
    };
    let ended = match by(CaptureMode::Compute) {
        Err(RenderError::Vulkan(vk::Error::LoopsEnded)) => true,
        // A device that ends no loops.
        rendered => {
            assert!(off(rendered.unwrap()) < 0.01);
            false
        }
    };
    let auto = by(CaptureMode::Auto).unwrap();
    let words = "ended the loops of captures in compute";
    let why = auto.plan.left_out.iter().find(|left| left.pass == "capture_compute").map(|left| &left.why);
    assert_eq!(why.is_some_and(|why| why.contains(words)), ended, "{why:?}");
    assert_eq!(auto.warnings.len(), usize::from(ended));
    assert!(auto.warnings.iter().all(|warning| warning.contains(words)), "{:?}", auto.warnings);
    assert!(hemicubes.warnings.is_empty());
    assert!(off(auto) < 0.01);
}

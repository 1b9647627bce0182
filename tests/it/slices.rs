//! Voxel slices for what is far, through the real passes: against closed forms, and against captures that draw all.

use crate::common::build::{Builder, Facing, diffuse, tessellated};
use crate::common::probes::{self, measure_on, turned};
use crate::common::{check_complete, device_lacks, draw, gpu, small};
use glam::{Mat3, Vec3, vec3};
use hemicube::image::metrics::measure as measure_image;
use hemicube::methods::Ground;
use hemicube::methods::captures::{CaptureMode, CaptureSettings, Captures};
use hemicube::methods::probes::{ProbeError, ProbeSettings, Probes};
use hemicube::passes::cluster_tree::Detail;
use hemicube::passes::geometry::{CellBudget, Geometry, SurfaceSize};
use hemicube::passes::integrate::{Gradients, Integrate, Limits, Radius};
use hemicube::renderer::{RenderError, render};
use hemicube::scene::{Background, Camera, EnvironmentMap, Light, Material, Scene, SideLimit, TextureRef, cornell};
use hemicube::vk::gpu_types::{Frame, Payload, Record};
use hemicube::vk::pass::Recorder;
use hemicube::vk::{Buffer, Device, DeviceChoice, Instance, Memory};
use std::f32::consts::PI;
use std::sync::Arc;

/// Texels a side.
const SIZE: u32 = 32;
/// Of a frame.
const SIDE: u32 = 32;
const GRADIENTS: Gradients = Gradients { rotation: true, translation: true };

fn slices(across: u32, near: f32) -> CaptureMode {
    CaptureMode::Slices { across, near }
}

/// Whether the device's texel buffers hold the slices of these tests, 16 values a voxel; reported where they do not.
/// (`slices_that_do_not_fit_are_refused` runs on every device.)
fn has_room() -> bool {
    let most = gpu().capabilities.limits.max_texel_buffer_elements;
    let fits = most >= 1 << 20;
    if !fits {
        device_lacks(&format!("texel buffers of the device hold {most} values, too few for slices"));
    }
    fits
}

/// What records see of surfaces that all have the radiance 1, to both sides.
fn furnace(device: &Arc<Device>, scene: &Scene, mode: CaptureMode, places: &[[Vec3; 2]]) -> Vec<Payload> {
    let before = device.instance.validation_messages();
    let geometry = Geometry::new(device, scene, &CellBudget::even(1 << 12), Some(Detail::Exact)).unwrap();
    geometry.cell_radiance.upload(&vec![1.0f32; 6 * geometry.cell_count as usize]).unwrap();
    let ground = Ground { scene, geometry: &geometry, textures: None };
    let settings = CaptureSettings { mode, size: SIZE, lod_error: 0.0, shared: false };
    let captures = Captures::new(device, &ground, true, settings, (None, true), None).unwrap();
    let count = places.len();
    let new = |bytes: usize, memory| Buffer::new(device, "records", (count * bytes) as u64, memory).unwrap();
    let records = new(size_of::<Record>(), Memory::Device);
    let [payloads, results] = [Memory::Device, Memory::Readback].map(|memory| new(size_of::<Payload>(), memory));
    let limits = Limits { scene_radius: 1.0 };
    let (both, quantities) = ((&records, &payloads), (GRADIENTS, Radius::Harmonic));
    let integrate = Integrate::new(device, &geometry, &captures.captured(), both, None, quantities, limits).unwrap();
    let frame = |[p, n]: &[Vec3; 2]| {
        let tangent = n.any_orthonormal_vector();
        let origin = *p + 1e-5 * *n;
        Frame {
            origin: origin.extend(1e-6).to_array(),
            tangent: tangent.extend(1.0).to_array(),
            bitangent: n.cross(tangent).extend(1.0).to_array(),
            normal: n.extend(1.0).to_array(),
            horizon: n.extend(-n.dot(origin)).to_array(),
        }
    };
    let record = |[p, n]: &[Vec3; 2]| Record {
        position: p.extend(0.0).to_array(),
        normal: n.extend(0.0).to_array(),
        geometric: n.extend(1.0).to_array(),
    };
    captures.frames().upload(&places.iter().map(frame).collect::<Vec<_>>()).unwrap();
    records.upload(&places.iter().map(record).collect::<Vec<_>>()).unwrap();
    let mut recorder = Recorder::new(device);
    recorder
        .submit(|recording| {
            captures.prepare(recording)?;
            captures.record(recording, &ground, count as u32)?;
            recording.pass("integrate", |c| {
                integrate.record(c, count as u32);
                Ok(())
            })?;
            recording.pass("readback", |c| {
                c.copy_buffer(&payloads, &results, results.size);
                Ok(())
            })
        })
        .unwrap();
    captures.check(&mut recorder).unwrap();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    results.read(count)
}

/// Largest error of E, and largest slope over the surface or as it turns, as shares of π.
fn errors(payloads: &[Payload]) -> [f32; 2] {
    let most = |of: fn(&Payload) -> f32| payloads.iter().map(of).fold(0.0, f32::max);
    let length = |v: [f32; 4]| Vec3::from_slice(&v).length() / PI;
    [
        most(|p| (p.irradiance[1] / PI - 1.0).abs()),
        payloads.iter().map(|p| length(p.translation[1]).max(length(p.rotation[1]))).fold(0.0, f32::max),
    ]
}

/// A closed room whose walls shine alike, cut so small that most of it is seen as slices. Its walls are the scene's bounds, where
/// voxels are met in their middles and covered whole: E = π to the rounding of some thousand single-precision weights,
/// whatever the shape of voxels. With a box within, whose edges lie in voxels that it fills in part, what passes them sees a wall behind.
#[test]
fn a_closed_room_that_shines_alike_is_a_furnace() {
    if !has_room() {
        return;
    }
    let device = gpu();
    for within in [false, true] {
        let mut b = Builder::default();
        let white = b.material(diffuse(0.5));
        b.cuboid(white, Vec3::ZERO, vec3(4.0, 2.3, 3.1), Facing::In);
        if within {
            b.cuboid(white, vec3(1.0, 0.0, 1.0), vec3(1.7, 0.9, 1.3), Facing::Out);
        }
        let scene = tessellated(&b.build(), 5);
        let places =
            [[vec3(0.3, 0.0, 0.4), Vec3::Y], [vec3(4.0, 1.1, 0.1), Vec3::NEG_X], [vec3(2.0, 2.3, 2.9), Vec3::NEG_Y]];
        for (across, near) in [(8, 2.0), (32, 2.0), (32, 8.0), (50, 5.0)] {
            let seen = furnace(&device, &scene, slices(across, near), &places);
            let [e, slope] = errors(&seen);
            eprintln!("box within: {within}, {across} {near}: E off by {e:.1e}, slopes {slope:.1e}");
            assert!(e < 1e-5 && slope < 1e-5, "{across} {near}: {e} {slope}");
        }
    }
}

/// A sphere that shines alike lies obliquely to the voxels: where it passes from one slice to the next, what sides of three axes
/// cover comes to a whole on average, and not for each line. Of a plane at 45° that goes through voxels' corners half of the lines
/// across it pass between the middles of their sides, of one through their middles none; of all planes a seventh of the lines.
/// However fine the voxels are, E falls short of π by so much at most of what is not drawn.
#[test]
fn what_is_oblique_leaks_a_seventh_at_most() {
    if !has_room() {
        return;
    }
    let device = gpu();
    let mut b = Builder::default();
    let white = b.material(diffuse(0.5));
    b.sphere(white, Vec3::ZERO, 1.0, 96, Facing::In);
    let scene = b.build();
    let directions = [Vec3::Y, vec3(0.6, 0.8, 0.0), vec3(-0.5, 0.5, 0.5f32.sqrt())];
    let places = directions.map(|d| [0.999 * d, -d]);
    for across in [8, 16, 32, 64] {
        let seen = furnace(&device, &scene, slices(across, across as f32 / 4.0), &places);
        let short = seen.iter().map(|p| 1.0 - p.irradiance[1] / PI).sum::<f32>() / 3.0;
        eprintln!("{across}: E short by {short:.4}");
        assert!((-1e-5..1.0 / 7.0).contains(&short), "{across}: {short}");
    }
}

fn frame_of(scene: &Scene, camera: &Camera, capture: CaptureMode) -> hemicube::renderer::Rendered {
    let mut settings = small(SIDE);
    settings.cache.capture = capture;
    let rendered = draw(scene, camera, &settings);
    check_complete(&rendered);
    rendered
}

/// The built-in box, cut so small that what is far of a record is not drawn with what is near, and outlines are not followed.
fn cut_cornell() -> (Scene, Camera) {
    let scene = cornell();
    let camera = scene.camera(None).unwrap().0;
    (tessellated(&scene, 4), camera)
}

/// Where all is nearer than what is to be seen as slices, the same records come out as without them, to the rounding of another
/// program: of two surfaces that are equally far, as at the edges of the box, either may be seen. Where slices are seen, the same
/// bits twice.
#[test]
fn what_is_near_is_drawn_as_it_is() {
    if !has_room() {
        return;
    }
    let (scene, camera) = cut_cornell();
    // A line across the box is no longer than twice its longest side.
    let [all, near, far, again] = [CaptureMode::Compute, slices(16, 32.0), slices(16, 4.0), slices(16, 4.0)]
        .map(|c| frame_of(&scene, &camera, c));
    assert_eq!(near.cache.records, all.cache.records);
    let [all, near, far, again] = [&all, &near, &far, &again].map(|r| r.picture.layer("irradiance").unwrap());
    let off = |layer| measure_image(layer, &all, SIDE as usize, None).mae;
    eprintln!("near: {:.1e} off, far: {:.1e}", off(&near), off(&far));
    assert!(off(&near) < 1e-4 && off(&far) > 1e-2);
    assert!(far.channels == again.channels, "bits of two runs");
}

/// A frame errs by no more than a voxel is to the box, and by less the finer they are, at the same distance from which on they
/// are seen: outlines may be a voxel off, at a quarter of the box and more.
#[test]
fn a_frame_errs_less_with_finer_voxels() {
    if !has_room() {
        return;
    }
    let (scene, camera) = cut_cornell();
    let whole = frame_of(&scene, &camera, CaptureMode::Compute);
    let whole = whole.picture.layer("irradiance").unwrap();
    let errors = [8, 16, 32].map(|across| {
        let rendered = frame_of(&scene, &camera, slices(across, across as f32 / 4.0));
        let m = measure_image(&rendered.picture.layer("irradiance").unwrap(), &whole, SIDE as usize, None);
        eprintln!("{across}: mean error {:.2} %", 1e2 * m.mae);
        assert!(m.mae < 1.0 / f64::from(across), "{across}: {}", m.mae);
        m.mae
    });
    assert!(errors.windows(2).all(|pair| pair[1] < 0.9 * pair[0]) && errors[2] < 0.4 * errors[0], "{errors:?}");
}

/// A wall of one sheet that the sun shines on from behind: the side that is seen is dark, and nothing shines through it.
#[test]
fn sides_of_a_thin_wall_are_told_apart() {
    if !has_room() {
        return;
    }
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    let mut floor = |x: f32| b.quad(white, vec3(x, 0.0, 4.0), Vec3::X * 4.0, Vec3::NEG_Z * 8.0);
    floor(-4.0);
    floor(0.0);
    b.quad(white, vec3(0.0, 0.0, 4.0), Vec3::NEG_Z * 8.0, Vec3::Y * 2.0);
    b.light(Light::Directional { direction: vec3(-1.0, -1e-3, 0.0).normalize(), irradiance: Vec3::splat(1e3) });
    let scene = tessellated(&b.build(), 5);
    let device = gpu();
    let [dark, lit] = [-2.6, 2.6]
        .map(|x| measure_on(&device, &scene, &probes::settings(slices(32, 8.0), SIZE), &turned(vec3(x, 0.0, 0.3), 4)));
    let exact =
        measure_on(&device, &scene, &probes::settings(CaptureMode::Compute, SIZE), &turned(vec3(2.6, 0.0, 0.3), 4));
    for ((dark, lit), exact) in dark.iter().zip(&lit).zip(&exact) {
        let [dark, lit, exact] = [dark, lit, exact].map(|p| p.reflected.value.y);
        eprintln!("dark side {dark:.1e}, lit side {lit:.3}, drawn {exact:.3}");
        assert_eq!(dark, 0.0);
        // The sheet passes through the middles of voxels, where it is met.
        assert!((lit / exact - 1.0).abs() < 1e-3, "{lit} {exact}");
    }
}

/// Under a sky of radiance 1: all of it where nothing is above, and between a canopy's holes, each hardly wider than a voxel, as
/// much as is drawn.
#[test]
fn the_sky_is_seen_beside_voxels_and_through_them() {
    if !has_room() {
        return;
    }
    let canopy = |present: Option<bool>| {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 4.0);
        let there = |i: u32| present.unwrap_or((i + i / 20).is_multiple_of(2));
        let texels = (0..20 * 20).map(|i| [255, 255, 255, if there(i) { 255 } else { 0 }]).collect();
        let texture = b.texture(20, 20, texels, true);
        let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
        let masked = b.material(Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.8) });
        b.floor(masked, 3.0, 2.9);
        b.background(Background::Constant(Vec3::ONE));
        b.build().tessellated(&SideLimit::even(0.3))
    };
    let device = gpu();
    let places = turned(vec3(0.1, 0.0, -0.2), 16);
    let sky = |scene: &Scene, capture| {
        let probes = measure_on(&device, scene, &probes::settings(capture, SIZE), &places);
        probes.iter().map(|p| p.sky.unwrap().value.y).sum::<f32>() / (16.0 * PI)
    };
    let [open, closed, holes] = [Some(false), Some(true), None].map(canopy);
    let of = |scene: &Scene| [slices(32, 8.0), CaptureMode::Compute].map(|capture| sky(scene, capture));
    let ([all, _], [none, whole], [half, drawn]) = (of(&open), of(&closed), of(&holes));
    eprintln!("open {all}, closed {none} drawn {whole}, with holes {half} drawn {drawn}");
    assert!((all - 1.0).abs() < 3e-6, "{all}");
    // Of the canopy's edge, and of holes, half a voxel is an eighth of the height off.
    assert!((none - whole).abs() < 0.02, "{none} {whole}");
    assert!((half - drawn).abs() < 0.02 && half > none + 0.2, "{half} {drawn}");
}

/// Whole workgroups, and a sky's map, see what subgroups do.
#[test]
fn workgroups_see_the_slices_that_subgroups_do() {
    if !has_room() {
        return;
    }
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.floor(white, 0.0, 4.0);
    b.cuboid(white, vec3(2.0, 0.0, -1.0), vec3(3.0, 1.5, 1.0), Facing::Out);
    b.light(Light::Point { position: vec3(0.5, 1.3, 0.0), intensity: Vec3::splat(3.0) });
    let rgb = (0..32).map(|i| [(i % 8) as f32, 1.0, (i / 8) as f32]).collect();
    b.background(Background::Map(EnvironmentMap { width: 8, height: 4, rgb }));
    let scene = tessellated(&b.build(), 4);
    let mut device = device();
    Arc::get_mut(&mut device).unwrap().capabilities.subgroup = None;
    let places = turned(vec3(-1.0, 0.0, 0.2), 4);
    let [usual, whole] =
        [&*gpu(), &device].map(|device| measure_on(device, &scene, &probes::settings(slices(32, 6.0), SIZE), &places));
    for (a, b) in usual.iter().zip(&whole) {
        assert!((a.inverse_distance / b.inverse_distance - 1.0).abs() < 1e-4);
        for (a, b) in [(a.reflected, b.reflected), (a.sky.unwrap(), b.sky.unwrap())] {
            assert!((a.value / b.value - 1.0).abs().max_element() < 1e-4, "{a:?} {b:?}");
            let off = (a.translation[0] - b.translation[0]).length();
            assert!(off < 1e-3 * b.value.x, "{a:?} {b:?}");
        }
    }
}

fn device() -> Arc<Device> {
    Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap()
}

/// Slices that nobody asks for are not built; those that are stand in the plan, and take the memory that is foretold.
#[test]
fn slices_stand_in_the_plan() {
    if !has_room() {
        return;
    }
    let (scene, camera) = cut_cornell();
    let rendered = frame_of(&scene, &camera, CaptureMode::Compute);
    assert!(rendered.plan.left_out().iter().any(|left| left.pass == "slices" && left.why.contains("--capture slices")));
    assert!(rendered.passes.iter().all(|pass| pass.name != "slices"));
    let mut settings = small(SIDE);
    settings.cache.capture = slices(16, 4.0);
    let device = device();
    let rendered = render(&device, &scene, &camera, &settings, &mut |_, _, _| {}).unwrap();
    assert!(rendered.plan.run().contains(&"slices"));
    assert_eq!(rendered.passes.iter().filter(|pass| pass.name == "slices").count(), 1);
    let size = SurfaceSize::about(&scene, &rendered.plan.surface_cells, rendered.plan.detail());
    let needs = hemicube::renderer::memory_needs(&device, &scene, &size, &rendered.plan, &settings);
    for used_for in ["slices", "slice samples"] {
        let foretold = needs.iter().find(|need| need.used_for == used_for).unwrap().bytes;
        assert_eq!(foretold, rendered.memory.by_use[used_for], "{used_for}");
    }
}

/// What the device cannot hold, or makes no sense, is refused by name before anything is allocated.
#[test]
fn slices_that_do_not_fit_are_refused() {
    let (scene, camera) = cut_cornell();
    let mut device = device();
    Arc::get_mut(&mut device).unwrap().capabilities.limits.max_texel_buffer_elements = 1 << 17;
    let refused = |across, near| {
        let mut settings = small(8);
        settings.cache.capture = slices(across, near);
        let error = render(&device, &scene, &camera, &settings, &mut |_, _, _| {}).err().unwrap();
        assert_eq!(device.memory().peak, 0, "memory was taken");
        (matches!(error, RenderError::Slices(_)), error.to_string())
    };
    let (by_device, text) = refused(64, 8.0);
    assert!(
        by_device && text.contains("--capture slices") && text.contains("voxels") && text.contains("--slices"),
        "{text}"
    );
    for (across, near, name) in [(3, 8.0, "--slices 3"), (129, 8.0, "--slices 129"), (32, 1.0, "--slices-near 1")] {
        let (by_device, text) = refused(across, near);
        assert!(!by_device && text.contains(name), "{text}");
    }
    let capture = slices(64, 8.0);
    let settings = ProbeSettings { surface_cells: 1 << 10, ..probes::settings(capture, SIZE) };
    let probes = Probes::new(&device, &mut Recorder::new(&device), &scene, &settings);
    assert!(matches!(probes.err(), Some(ProbeError::Slices(_))));
}

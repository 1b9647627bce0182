//! What a device cannot do is done otherwise, with the same picture.

use super::WHOLE;
use crate::common::build::{Builder, Facing, diffuse};
use crate::common::{check_complete, draw, gpu, look, small};
use glam::{Mat3, Vec3, dvec3, vec3};
use hemicube::image::metrics::measure as measure_image;
use hemicube::math::capture::Projection;
use hemicube::methods::captures::CaptureMode;
use hemicube::renderer::{Part, RenderError, Rendered, TooLarge, render};
use hemicube::scene::{Light, Material, Scene, TextureRef, cornell};
use hemicube::vk::{self, Device, DeviceChoice, Instance};
use std::sync::Arc;

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
            let left_out = |pass| rendered.plan.left_out().iter().find(|l| l.pass == pass).map(|l| l.why.clone());
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

/// Devices that set triangles up before they are clipped have the vertex stage cut them, in the G-buffer, shadow maps and
/// captures. The same picture, but for pixels and texels whose centre lies within rounding of an edge: a room whose walls go
/// on behind every eye, with a texture, a mask and a light.
///
/// An edge passes some N texels of a capture's N², of which corners that are rounded to 2⁻ᵇ of a texel move that share to its
/// other side: a record's light is off by about 2⁻ᵇ/N for each edge that it sees, to either side. Room and screen show it a dozen,
/// which makes three times that.
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
    let rounding = 0.5f32.powi(gpu().capabilities.limits.sub_pixel_precision_bits as i32) / 16.0;
    // Which of two places a record takes may hang on a pixel's last digit: the number of records is not compared.
    for (name, values) in whole.channels.iter().filter(|(name, _)| *name != "records.Y") {
        let both = || values.iter().zip(&cut.channels[name]);
        let scale = values.iter().fold(0.0f32, |most, v| most.max(v.abs()));
        let off = both().filter(|(a, b)| (*a - *b).abs() > 0.01 * scale).count();
        let difference = both().map(|(a, b)| (a - b).abs()).sum::<f32>()
            / values.iter().map(|v| v.abs()).sum::<f32>().max(f32::MIN_POSITIVE);
        eprintln!("{name}: {difference:.1e} off, {off} of {} pixels by more than 1 % of the most", values.len());
        if ["P", "N", "Z", "albedo", "mask", "direct", "irradiance_direct"].contains(&name.split('.').next().unwrap()) {
            assert!(off * 100 <= values.len(), "{name}: {off} pixels");
        } else {
            assert!(difference <= 3.0 * rounding, "{name}: {difference}, above 3 · {rounding}");
        }
    }
}

/// Sheets over each other, the lowest last: every one of them is drawn all over the view before the next hides it. llvmpipe
/// ends a shader's loops before that is done; then nobody is shown what is missing. Of 600 sheets a whole workgroup draws each
/// view instead, of 2,400 it cannot either, and render passes do.
#[test]
fn what_outlasts_the_loops_of_a_device_is_told() {
    let by_workgroups = "whole workgroups drew the frame anew";
    let [few, many] = [600, 2400].map(sheets);
    let whole = by(CaptureMode::Hemicube, &few).unwrap();
    let auto = by(CaptureMode::Auto, &few).unwrap();
    let compute = match by(CaptureMode::Compute, &few) {
        // A device that holds no tree of them, cut as they are where they are long: that is known from the start.
        Err(RenderError::Memory(error)) => {
            eprintln!("!!! {error}; WHAT OUTLASTS LOOPS IS NOT CHECKED");
            assert!(
                why_not_in_compute(&auto).is_some_and(|why| why.contains(TOO_FEW_TEXELS)) && off(&auto, &whole) < 0.01
            );
            return;
        }
        rendered => rendered.unwrap(),
    };
    let ends = gpu().is_cpu() && gpu().capabilities.subgroup.is_some();
    for rendered in [&compute, &auto] {
        assert!(off(rendered, &whole) < 0.01);
        let told = rendered.warnings.iter().filter(|warning| warning.contains(by_workgroups)).count();
        assert_eq!([told, rendered.warnings.len()], [usize::from(ends); 2], "{:?}", rendered.warnings);
        let times = |pass| rendered.passes.iter().filter(|p| p.name == pass).count();
        assert_eq!([times("gbuffer"), times("resolve")], [1; 2], "the records alone are made anew");
        assert!(rendered.plan.run().contains(&"capture_compute") || !gpu().is_cpu());
    }
    let whole = by(CaptureMode::Hemicube, &many).unwrap();
    assert!(whole.warnings.is_empty());
    let loops = "ended the loops of captures in compute";
    let (words, warned) = match by(CaptureMode::Compute, &many) {
        Err(RenderError::Vulkan(vk::Error::LoopsEnded { shared: true })) => (Some(loops), 1),
        // A device that holds no tree of them: that is known from the start.
        Err(RenderError::Memory(TooLarge::One { used_for: "capture corners", .. })) => (Some(TOO_FEW_TEXELS), 0),
        // One that ends no loops.
        rendered => {
            assert!(off(&rendered.unwrap(), &whole) < 0.01);
            (None, 0)
        }
    };
    let auto = by(CaptureMode::Auto, &many).unwrap();
    let why = why_not_in_compute(&auto);
    if gpu().is_cpu() {
        assert!(why.is_some() == words.is_some() && why.unwrap_or("").contains(words.unwrap_or("")), "{why:?}");
    }
    assert_eq!(auto.warnings.iter().filter(|warning| warning.contains("render passes drew")).count(), warned);
    assert!(off(&auto, &whole) < 0.01);
}

const TOO_FEW_TEXELS: &str = "a texel buffer of the device holds";

fn why_not_in_compute(rendered: &Rendered) -> Option<&str> {
    rendered.plan.why_not(Part::CaptureCompute)
}

fn sheets(count: u32) -> Scene {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 4.0);
    for i in 0..count {
        b.quad(grey, vec3(-4.0, 3.0 - 2.0 * i as f32 / count as f32, -4.0), Vec3::X * 8.0, Vec3::Z * 8.0);
    }
    b.light(Light::Point { position: vec3(0.0, 0.5, 0.0), intensity: Vec3::splat(10.0) });
    b.build()
}

fn by(capture: CaptureMode, scene: &Scene) -> Result<Rendered, RenderError> {
    let mut settings = small(8);
    (settings.cache.capture, settings.cache.capture_size) = (capture, 32);
    let camera = look(dvec3(2.0, 0.6, 2.0), dvec3(0.0, 0.0, 0.0), 80.0);
    render(&gpu(), scene, &camera, &settings, &mut |_, _, _| {})
}

fn off(rendered: &Rendered, whole: &Rendered) -> f64 {
    let [a, b] = [rendered, whole].map(|r| r.picture.layer("irradiance").unwrap());
    let m = measure_image(&a, &b, 8, None);
    eprintln!("{:.2} % off", m.mae * 1e2);
    m.mae
}

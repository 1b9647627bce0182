//! What a device does at most, measured by the renderer's own passes on a scene that suits each.
//!
//! A sphere seen from its centre: every texel of a capture sees it, every pixel of the image is its own surface, and
//! nothing is hidden or culled. What a real scene needs of a pass, divided by these rates, is the least time it can take.

use super::Ground;
use super::captures::{CaptureMode, CaptureSettings, Captures};
use crate::math::capture::Projection;
use crate::passes::capture::{Capture, CaptureDesc, FramesBy};
use crate::passes::capture_compute::CaptureCompute;
use crate::passes::cluster_tree::Detail;
use crate::passes::counter::Counter;
use crate::passes::gathered::{Gathered, Kinds};
use crate::passes::gbuffer::GBuffer;
use crate::passes::geometry::{CellBudget, Geometry};
use crate::passes::integrate::{Captured, CapturedBy, Gradients, Integrate, Limits, Radius};
use crate::passes::splat::{Contribution, Outputs, Source, Splat, View, Weight};
use crate::passes::views::Views;
use crate::scene::Scene;
use crate::scene::build::{Builder, Facing, diffuse};
use crate::vk::gpu_types::{Frame, Kept, KeptPayload, Payload, Record};
use crate::vk::pass::{Recorder, Recording};
use crate::vk::{Buffer, Device, Memory, Result};
use glam::{Mat4, Vec3, Vec4};
use std::sync::Arc;

/// Rings of the sphere, of twice as many quads each: 4 n (n − 1) triangles, 19,320.
const RINGS: u32 = 70;
/// Rings of a sphere that is next to nothing but texels: 24 triangles.
const FEW_RINGS: u32 = 3;
/// Texels a side of a hemicube, as in the default settings.
const CAPTURE_SIZE: u32 = 32;
/// Hemicubes of a batch.
const CAPTURES: u32 = 16;
/// Hemicubes of a batch in compute.
const CAPTURES_IN_COMPUTE: u32 = 64;
/// Pixels a side of the image that splats cover.
const IMAGE: u32 = 512;
/// Splats, each over the whole image.
const SPLATS: u32 = 64;
/// Radius of their zones: so large that no part of the sphere is in front of a record's plane, and all of it within.
const ZONE: f32 = 100.0;
/// Passes between whose timestamps nothing happens.
const EMPTY_PASSES: u32 = 256;
/// Runs of each pass: the first one compiles on some drivers, and the fastest of the rest counts.
const RUNS: usize = 4;

/// Rates of a device. Zero where its queue has no timestamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Triangles times views that a capture's render pass draws in a second, 32 × 32 texels a view.
    pub triangle_views: f64,
    /// Fragments in a second that a splat reads the G-buffer for, weighs and blends into RGBA32F.
    pub blended_fragments: f64,
    /// Texels of captures in a second that are looked up, weighed and summed, gradients included.
    pub integrated_texels: f64,
    /// Captures in compute, where they fit the device.
    pub compute: Option<ComputeRates>,
    /// What one pair of timestamps with its barriers costs, in milliseconds.
    pub timestamp_ms: f64,
}

/// Rates of captures in compute, 32 × 32 texels a view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ComputeRates {
    /// Triangles times views that are drawn in a second where triangles are as small as texels.
    pub triangle_views: f64,
    /// Texels that are cleared, drawn, looked up and, where subgroups do so, summed in a second where triangles are few.
    pub texels: f64,
    /// As [`Rates::integrated_texels`], but for what the capture does itself: the look-up, and most sums where it sums.
    pub integrated_texels: f64,
}

impl Rates {
    /// Measures `device`: well below a second on a GPU, a few seconds on a CPU.
    pub fn measure(device: &Arc<Device>) -> Result<Self> {
        let scene = sphere(RINGS);
        let geometry = Geometry::new(device, &scene, &CellBudget::even(1), None)?;
        let ground = Ground { scene: &scene, geometry: &geometry, textures: None };
        let mut stopwatch = Stopwatch { recorder: Recorder::new(device) };
        let (triangle_views, integrated_texels) = captures(device, &ground, &mut stopwatch)?;
        Ok(Self {
            triangle_views,
            blended_fragments: splats(device, &ground, &mut stopwatch)?,
            integrated_texels,
            compute: compute(device, &mut stopwatch)?,
            timestamp_ms: stopwatch.empty_pass()?,
        })
    }
}

/// Times passes.
struct Stopwatch {
    recorder: Recorder,
}

impl Stopwatch {
    /// Least time of the last pass that `record` records, in seconds; none without timestamps.
    fn seconds(&mut self, mut record: impl FnMut(&mut Recording<'_>) -> Result<()>) -> Result<Option<f64>> {
        let mut least: Option<f64> = None;
        for run in 0..RUNS {
            self.recorder.submit(&mut record)?;
            let gpu = self.recorder.passes.last().and_then(|pass| pass.gpu).filter(|_| run > 0);
            let seconds = gpu.map(|span| (span.end_ms - span.begin_ms) * 1e-3);
            least = seconds.map(|s| least.map_or(s, |l| l.min(s))).or(least);
        }
        Ok(least.filter(|s| *s > 0.0))
    }

    fn empty_pass(&mut self) -> Result<f64> {
        self.recorder.submit(|recording| {
            for _ in 0..EMPTY_PASSES {
                recording.pass("nothing", |_| Ok(()))?;
            }
            Ok(())
        })?;
        let whole = self.recorder.submissions.last().map_or(0.0, |span| span.end_ms - span.begin_ms);
        Ok(whole / f64::from(EMPTY_PASSES))
    }
}

/// Rates of captures in compute; none where they do not fit the device.
fn compute(device: &Arc<Device>, stopwatch: &mut Stopwatch) -> Result<Option<ComputeRates>> {
    if CaptureCompute::misfit(device, &sphere(RINGS), Projection::Hemicube, CAPTURE_SIZE).is_some() {
        return Ok(None);
    }
    let [fine, coarse] = [RINGS, FEW_RINGS].map(|rings| compute_on(device, &sphere(rings), stopwatch));
    let (fine, coarse) = (fine?, coarse?);
    Ok(Some(ComputeRates { texels: coarse.texels, ..fine }))
}

fn compute_on(device: &Arc<Device>, scene: &Scene, stopwatch: &mut Stopwatch) -> Result<ComputeRates> {
    let geometry = Geometry::new(device, scene, &CellBudget::even(1), Some(Detail::Exact))?;
    let ground = Ground { scene, geometry: &geometry, textures: None };
    let drawn = Counter::new(device)?;
    let settings = CaptureSettings { mode: CaptureMode::Compute, size: CAPTURE_SIZE, lod_error: 0.0, shared: false };
    let captures = Captures::new(device, &ground, true, settings, (None, true), Some(&drawn))?;
    let count = captures.capacity.min(CAPTURES_IN_COMPUTE);
    captures.frames().upload(&vec![upwards(); count as usize])?;
    let seconds = stopwatch.seconds(|recording| {
        recording.pass("clear", |c| {
            drawn.record_clear(c);
            Ok(())
        })?;
        captures.record(recording, &ground, count)
    })?;
    // What was counted is asked for apart: the last pass of a submission is the one that is timed.
    stopwatch.recorder.submit(|recording| {
        recording.pass("readback", |c| {
            drawn.record_readback(c);
            Ok(())
        })
    })?;
    let texels = f64::from(captures.texels) * f64::from(count);
    let integrated = integrated(device, &geometry, &captures.captured(), count, stopwatch)?;
    Ok(ComputeRates {
        triangle_views: rate(drawn.read() as f64, seconds),
        texels: rate(texels, seconds),
        integrated_texels: rate(texels, integrated),
    })
}

fn rate(work: f64, seconds: Option<f64>) -> f64 {
    seconds.map_or(0.0, |seconds| work / seconds)
}

/// Triangle views and integrated texels in a second.
fn captures(device: &Arc<Device>, ground: &Ground<'_>, stopwatch: &mut Stopwatch) -> Result<(f64, f64)> {
    let views = Views::Hemicube;
    let desc = CaptureDesc {
        name: "capture",
        views,
        size: CAPTURE_SIZE,
        capacity: CAPTURES,
        keeps_depth: false,
        culled: false,
        frames: FramesBy::on(device),
    };
    let capture = Capture::new(device, ground.scene, ground.geometry, None, desc)?;
    let count = capture.desc.capacity;
    capture.frames.upload(&vec![upwards(); count as usize])?;
    let seconds = stopwatch.seconds(|recording| {
        recording.pass("capture", |c| {
            capture.record(c, ground.geometry, None, count);
            Ok(())
        })
    })?;
    let drawn = f64::from(ground.geometry.triangle_count) * f64::from(views.count() * count);
    let triangle_views = rate(drawn, seconds);

    let projection = Projection::Hemicube;
    let texels = projection.table(CAPTURE_SIZE).texels.len() as u64 * u64::from(count);
    let gathered = Gathered::plain(device, texels, Kinds { sky: false, planes: true })?;
    let captured =
        Captured { by: CapturedBy::Render(&capture, None), gathered: &gathered, projection, size: CAPTURE_SIZE };
    let seconds = integrated(device, ground.geometry, &captured, count, stopwatch)?;
    Ok((triangle_views, rate(texels as f64, seconds)))
}

/// Least time to integrate `count` captures, in seconds.
fn integrated(
    device: &Arc<Device>,
    geometry: &Geometry,
    captured: &Captured<'_>,
    count: u32,
    stopwatch: &mut Stopwatch,
) -> Result<Option<f64>> {
    let records = Buffer::new(device, "records", u64::from(count) * size_of::<Record>() as u64, Memory::Device)?;
    let payloads = Buffer::new(device, "records", u64::from(count) * size_of::<Payload>() as u64, Memory::Device)?;
    let quantities = (Gradients { rotation: true, translation: true }, Radius::Hessian);
    let limits = Limits { scene_radius: 1.0 };
    let integrate = Integrate::new(device, geometry, captured, (&records, &payloads), None, quantities, limits)?;
    stopwatch.seconds(|recording| {
        recording.pass("integrate", |c| {
            integrate.record(c, count);
            Ok(())
        })
    })
}

/// Blended fragments in a second.
fn splats(device: &Arc<Device>, ground: &Ground<'_>, stopwatch: &mut Stopwatch) -> Result<f64> {
    let gbuffer = GBuffer::new(device, ground.scene, ground.geometry, None, [IMAGE; 2], false)?;
    let place = Kept { position: [0.0, 0.0, 0.0, ZONE], normal: [0.0, 0.0, 1.0, 0.0], tangent: [1.0, 0.0, 0.0, 0.0] };
    let records = Buffer::with_data(device, "records", &vec![place; SPLATS as usize])?;
    let payloads = Buffer::with_data(device, "records", &vec![KeptPayload::default(); SPLATS as usize])?;
    let zones = Buffer::with_data(device, "records", &vec![ZONE; SPLATS as usize])?;
    let source = Source { records: &records, payloads: &payloads, horizons: &records, zones: &zones };
    let outputs = Outputs { sky: false, tally: false, fragments: false };
    let contribution = Contribution { gradients: true, weight: Weight::Bounded, horizon: None };
    let splat = Splat::new(device, &gbuffer.targets, &source, outputs, contribution)?;
    let set = splat.set(&gbuffer.targets, &source)?;
    // From the centre along −z, 90° wide, reversed depth.
    let near = 1e-3;
    let world_to_clip = Mat4::from_cols(Vec4::X, Vec4::NEG_Y, Vec4::new(0.0, 0.0, 0.0, -1.0), Vec4::Z * near);
    let view = View {
        world_to_view: Mat4::IDENTITY.to_cols_array(),
        scale: [1.0, -1.0, 0.0, 1.0],
        accuracy: 0.3,
        normal_limit: 2.0,
        share: 1.0,
    };
    let seconds = stopwatch.seconds(|recording| {
        recording.pass("gbuffer", |c| {
            gbuffer.record(c, ground.scene, ground.geometry, None, world_to_clip, Vec4::W);
            splat.record_clear(c);
            Ok(())
        })?;
        recording.pass("splat", |c| {
            splat.record(c, &view, &set, 0..SPLATS, 0);
            Ok(())
        })
    })?;
    Ok(rate(f64::from(IMAGE * IMAGE) * f64::from(SPLATS), seconds))
}

/// A hemicube at the centre.
fn upwards() -> Frame {
    Frame {
        origin: [0.0, 0.0, 0.0, 1e-6],
        tangent: [1.0, 0.0, 0.0, 1.0],
        bitangent: [0.0, 1.0, 0.0, 1.0],
        normal: [0.0, 0.0, 1.0, 1.0],
        horizon: [0.0, 0.0, 1.0, 0.0],
    }
}

/// The unit sphere, facing in.
fn sphere(rings: u32) -> Scene {
    let mut builder = Builder::default();
    let grey = builder.material(diffuse(0.5));
    builder.sphere(grey, Vec3::ZERO, 1.0, rings, Facing::In);
    builder.build()
}

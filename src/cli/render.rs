//! `hemicube render`: one image with indirect light.

mod report;

use super::common::{DeviceArgs, ImageArgs, SceneArgs, TalkArgs, check_output};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use hemicube::image::tone::{Look, ToneMap};
use hemicube::image::{LayerSet, exr, png};
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE, SLICES, SLICES_NEAR};
use hemicube::passes::integrate::{Gradients, Radius};
use hemicube::passes::resolve::Plane;
use hemicube::passes::splat::Weight;
use hemicube::renderer::{Rendered, Settings, render};
use hemicube::report::progress::{Progress, Stage};
use hemicube::scene::image_size;
use hemicube::scene::{Camera, Scene};
use hemicube::vk::Device;
use report::Report;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Render one image with indirect light by irradiance-cache splatting
///
/// Draws a G-buffer, lights the surfaces once, then places irradiance records in rounds from coarse to fine: each is
/// captured as a multi-view hemicube, integrated and splatted over the pixels it is valid for, until every visible pixel
/// is covered. A table of all passes with their GPU times ends the run.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Image to write: .exr (linear floats, with layers) or .png (tone-mapped)
    #[arg(short, long, value_name = "OUT.exr|OUT.png")]
    output: PathBuf,
    #[command(flatten)]
    image: ImageArgs,
    /// Layers of the EXR besides R,G,B: direct, indirect, irradiance, irradiance_direct, albedo, emission, N, P, Z,
    /// records, mask, or all
    #[arg(
        long,
        value_name = "LIST|all",
        default_value = "direct,indirect,irradiance,albedo,N,P,Z",
        help_heading = "Image"
    )]
    layers: LayerSet,
    /// Exposure of a PNG in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_hyphen_values = true, help_heading = "Image")]
    exposure: f32,
    /// Tone mapping of a PNG: agx, srgb (clamped) or reinhard
    #[arg(long, value_name = "NAME", default_value = "agx", help_heading = "Image")]
    tone: ToneMap,
    /// Reflections on the way: 0 is direct light only, 1 one bounce of indirect light
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Light")]
    bounces: u32,
    /// Samples of all emissive triangles together, one for each at least; the noise of soft shadows falls with their number
    #[arg(long, value_name = "N", help_heading = "Light")]
    light_samples: Option<u32>,
    /// Cells that the surfaces are cut into to hold their lit radiance, about, finer near the camera; each triangle
    /// has at least one
    #[arg(long, value_name = "N", help_heading = "Light")]
    surface_cells: Option<u32>,
    /// Ward's a: a record reaches a times the harmonic mean distance of what it sees. Smaller: more records, less error
    #[arg(long, value_name = "A", help_heading = "Irradiance cache")]
    accuracy: Option<f32>,
    /// How records look at the scene
    #[arg(long, value_enum, default_value = "auto", help_heading = "Irradiance cache")]
    capture: CaptureArg,
    /// Texels a side of a capture (a hemicube's top), even, 8 to 256
    #[arg(long, value_name = "N", help_heading = "Irradiance cache")]
    capture_size: Option<u32>,
    /// Most that distant triangles may be wrong by in captures in compute, in texels of a hemicube: where a scene has many
    /// triangles, coarser ones stand for them at a distance, and cast the sky's shadows on surface cells. 0: all are drawn
    #[arg(long, value_name = "TEXELS", help_heading = "Irradiance cache")]
    lod_error: Option<f32>,
    /// Full angle that --capture plane sees along each axis, in degrees, 10 to 170; 126.87 is twice as wide as it is far
    #[arg(long, value_name = "DEGREES", default_value_t = PLANE_APERTURE, help_heading = "Irradiance cache")]
    aperture: f64,
    /// Whether texels at the border of --capture plane stand for what it does not see; without it that is black
    #[arg(long, value_enum, default_value = "on", help_heading = "Irradiance cache")]
    compensation: CompensationArg,
    /// Voxels along the scene's longest side for --capture slices, 4 to 128
    #[arg(long, value_name = "N", default_value_t = SLICES, help_heading = "Irradiance cache")]
    slices: u32,
    /// How many voxels away --capture slices still draws triangles as they are, 2 to 1000
    #[arg(long, value_name = "VOXELS", default_value_t = SLICES_NEAR, help_heading = "Irradiance cache")]
    slices_near: f32,
    /// Cut triangles so that no side is longer than this share of the scene's diagonal; --capture hemisphere, which draws
    /// curved sides straight, does so by itself
    #[arg(long, value_name = "SHARE", help_heading = "Irradiance cache")]
    tessellate: Option<f32>,
    /// Irradiance gradients that records are extrapolated with
    #[arg(long, value_enum, default_value = "both", help_heading = "Irradiance cache")]
    gradients: GradientsArg,
    /// What R is, of which a record's zone of influence has the share a
    #[arg(long, value_enum, default_value = "hessian", help_heading = "Irradiance cache")]
    radius: RadiusArg,
    /// Weight of a record at a point
    #[arg(long, value_enum, default_value = "bounded", help_heading = "Irradiance cache")]
    weight: WeightArg,
    /// Smallest radius of a record's zone of influence as a share of the image's height; never below two pixels
    #[arg(long, value_name = "SHARE", help_heading = "Irradiance cache")]
    min_radius: Option<f32>,
    /// Largest radius of a record's zone of influence as a share of the image's height
    #[arg(long, value_name = "SHARE", help_heading = "Irradiance cache")]
    max_radius: Option<f32>,
    /// Sum of weights from which a pixel counts as covered
    #[arg(long, value_name = "W", help_heading = "Irradiance cache")]
    coverage: Option<f32>,
    /// New records are put where those of a pixel disagree by more than this, relative to their mean: removes dark or bright
    /// spots beside edges of the light. Captures of N texels a side, below 32, are asked for 32/N times as much, for they err by as
    /// much themselves. 0: they may disagree
    #[arg(long, value_name = "C", help_heading = "Irradiance cache")]
    contrast: Option<f32>,
    /// Most records between two looks for pixels that need one; fewer make fewer records in more time. Default: all that a
    /// round's lattice of pixels needs
    #[arg(long, value_name = "N", help_heading = "Irradiance cache", hide_short_help = true)]
    batch: Option<u32>,
    /// √(1 − cos) between normals at which a record's weight has fallen to zero
    #[arg(long, value_name = "X", help_heading = "Irradiance cache", hide_short_help = true)]
    normal_limit: Option<f32>,
    /// Whether a new record reaches further beyond an older one than that reaches itself
    #[arg(long, value_enum, default_value = "clamp", help_heading = "Irradiance cache")]
    neighbours: NeighboursArg,
    /// Where something stands between a record and a point, by the distances that the record's hemicube has seen
    #[arg(long, value_enum, default_value = "reject", help_heading = "Irradiance cache")]
    hidden: HiddenArg,
    /// Seed of the hemicubes' random turns
    #[arg(long, default_value_t = 0, help_heading = "Irradiance cache")]
    seed: u32,
    /// Build and run every part, needed or not (to check that leaving parts out changes no pixel)
    #[arg(long, hide_short_help = true, help_heading = "Device")]
    full_plan: bool,
    /// Measure what the device does at most, as `hemicube info --measure` does, and show what capturing, integrating and
    /// splatting did as a share of that
    #[arg(long, help_heading = "Report")]
    measure: bool,
    /// Write statistics as JSON: plan, records, times of all passes, memory
    #[arg(long, value_name = "FILE.json", help_heading = "Report")]
    stats: Option<PathBuf>,
    /// Write a Chrome trace of all passes and CPU stages; opens in Perfetto
    #[arg(long, value_name = "FILE.json", help_heading = "Report")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

const HELP: &str = "\
Units: a light of intensity I gives I·cosθ/d²; an emissive texel of value L is radiance L; nothing is scaled. Surfaces are
Lambertian and two-sided (metalness and roughness are not used); emitters shine from their front, from both sides if the
material is double-sided, and do not reflect.

Examples:
  hemicube render -o cornell.exr
  hemicube render sponza.gltf -o sponza.png --exposure 1
  hemicube render sponza.gltf -o sponza.exr --width 640 --height 360 --accuracy 0.2 --stats sponza.json
  hemicube render room.glb -o room.exr --background sky.exr --layers all --trace room.trace.json

A draft, in half to a sixth of the time, with three times the error: --accuracy 1 --capture-size 16 --contrast 0 --surface-cells 60000
--min-radius .06 --max-radius .1

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device, or device lost.";

/// `--capture`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CaptureArg {
    /// In compute on a CPU device where that fits, else by render passes
    Auto,
    /// Multi-view hemicubes by render passes
    Hemicube,
    /// One perspective view along the normal, of --aperture
    Plane,
    /// One view projected onto the disc below the hemisphere; wants triangles that are small as seen from everywhere
    Hemisphere,
    /// Hemicubes rasterised in compute, in shared memory
    Compute,
    /// The hemisphere's projection rasterised in compute; triangles stay as they are
    ComputeHemisphere,
    /// Hemicubes in compute of what is near; what is far is seen as slices of voxels (--slices, --slices-near)
    Slices,
}

/// `--compensation`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CompensationArg {
    /// The texels at the border stand for what lies between them and the horizon
    On,
    /// What is not seen is black
    Off,
}

/// `--gradients`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GradientsArg {
    /// Constant irradiance in each zone
    None,
    /// By the normal's turn
    Rotation,
    /// By the point's move
    Translation,
    /// Both
    Both,
}

/// `--radius`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RadiusArg {
    /// Harmonic mean distance of what the record sees, limited by its gradient (Ward 1988)
    Harmonic,
    /// Where the second derivatives of the irradiance make extrapolation wrong; harmonic without a translation gradient
    Hessian,
}

/// `--weight`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WeightArg {
    /// Bounded, zero at the zone's border (Tabellion and Lamorlette 2004)
    Bounded,
    /// Ward, Rubinstein and Clear 1988
    Ward,
}

/// `--neighbours`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NeighboursArg {
    /// It does not: what shortens one zone is near the other (Křivánek et al. 2006)
    Clamp,
    /// It may
    Free,
}

/// `--hidden`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum HiddenArg {
    /// The record does not light the point: no light passes thin walls
    Reject,
    /// It does, if place and normal fit
    Allow,
}

/// Runs the subcommand.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let started = Instant::now();
    let picture_kind = Kind::of(&args.output)?;
    for path in [Some(&args.output), args.stats.as_ref(), args.trace.as_ref()].into_iter().flatten() {
        check_output(path)?;
    }
    let scene = args.scene.load()?;
    let (camera, note) = args.scene.camera(&scene)?;
    let settings = args.settings(&camera, picture_kind);
    let loaded = started.elapsed();
    let device = args.device.open()?;
    settings.check(&device)?;
    let mut report = Report::new(args.talk, started, &device);
    report.stage("load scene", loaded);
    report.stage("open device", started.elapsed() - loaded);
    report.scene(&scene, &camera, note.as_deref(), &settings);
    let rendered = run_with_progress(&device, &scene, &camera, &settings, args.talk)?;
    report.check(&rendered);
    let writing = Instant::now();
    match picture_kind {
        Kind::Exr => exr::write(&args.output, &rendered.picture, &[])?,
        Kind::Png => png::write(&args.output, &rendered.picture, "", Look { tone: args.tone, stops: args.exposure })?,
    }
    report.rendered(&rendered, writing.elapsed());
    if args.measure {
        report.measure()?;
    }
    report.finish(&scene, &rendered, &args.output, args.stats.as_deref(), args.trace.as_deref())?;
    Ok(ExitCode::SUCCESS)
}

fn run_with_progress(
    device: &std::sync::Arc<Device>,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    talk: TalkArgs,
) -> Result<Rendered> {
    let progress = Progress::new(talk.quiet);
    let mut stage: Option<(&'static str, Stage)> = None;
    let rendered = render(device, scene, camera, settings, &mut |name, done, all| {
        if stage.as_ref().is_none_or(|(current, _)| *current != name) {
            stage = Some((name, progress.stage(name, all)));
        }
        if let Some((_, stage)) = &stage {
            stage.advance(done.saturating_sub(stage.done()));
        }
    })?;
    Ok(rendered)
}

/// Kind of the output file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Exr,
    Png,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => bail!("cannot tell the format of {}: name it .exr or .png", path.display()),
        }
    }
}

impl RenderArgs {
    fn settings(&self, camera: &Camera, kind: Kind) -> Settings {
        let (width, height) = image_size(camera, self.image.width, self.image.height);
        let mut settings =
            Settings { width, height, bounces: self.bounces, full_plan: self.full_plan, ..Settings::default() };
        let set = |to: &mut f32, from: Option<f32>| *to = from.unwrap_or(*to);
        let set_u32 = |to: &mut u32, from: Option<u32>| *to = from.unwrap_or(*to);
        let cache = &mut settings.cache;
        set(&mut cache.accuracy, self.accuracy);
        set(&mut cache.lod_error, self.lod_error);
        set(&mut cache.min_radius, self.min_radius);
        set(&mut cache.max_radius, self.max_radius);
        set(&mut cache.covered, self.coverage);
        set(&mut cache.contrast, self.contrast);
        set(&mut cache.normal_limit, self.normal_limit);
        set_u32(&mut cache.capture_size, self.capture_size);
        cache.capture = match self.capture {
            CaptureArg::Auto => CaptureMode::Auto,
            CaptureArg::Hemicube => CaptureMode::Hemicube,
            CaptureArg::Compute => CaptureMode::Compute,
            CaptureArg::ComputeHemisphere => CaptureMode::ComputeHemisphere,
            CaptureArg::Slices => CaptureMode::Slices { across: self.slices, near: self.slices_near },
            CaptureArg::Plane => {
                CaptureMode::Plane { aperture: self.aperture, compensated: self.compensation == CompensationArg::On }
            }
            CaptureArg::Hemisphere => CaptureMode::Hemisphere,
        };
        cache.seed = self.seed;
        cache.batch = self.batch;
        let has = |kind| self.gradients == kind || self.gradients == GradientsArg::Both;
        cache.gradients =
            Gradients { rotation: has(GradientsArg::Rotation), translation: has(GradientsArg::Translation) };
        cache.radius = match self.radius {
            RadiusArg::Harmonic => Radius::Harmonic,
            RadiusArg::Hessian => Radius::Hessian,
        };
        cache.weight = match self.weight {
            WeightArg::Bounded => Weight::Bounded,
            WeightArg::Ward => Weight::Ward,
        };
        cache.clamped = self.neighbours == NeighboursArg::Clamp;
        cache.hidden = self.hidden == HiddenArg::Reject;
        set_u32(&mut settings.lights.area_samples, self.light_samples);
        settings.surface_cells = self.surface_cells;
        settings.tessellation = self.tessellate;
        settings.counts_work = self.measure;
        settings.planes = match kind {
            Kind::Exr => Plane::ALL.into_iter().filter(|p| self.layers.contains(layer_name(*p))).collect(),
            Kind::Png => vec![Plane::Final],
        };
        settings
    }
}

/// Name of a plane in `--layers`.
fn layer_name(plane: Plane) -> &'static str {
    match plane {
        Plane::Final => "",
        Plane::Direct => "direct",
        Plane::Indirect => "indirect",
        Plane::Irradiance => "irradiance",
        Plane::DirectIrradiance => "irradiance_direct",
        Plane::Albedo => "albedo",
        Plane::Emission => "emission",
        Plane::Normal => "N",
        Plane::Position => "P",
        Plane::Depth => "Z",
        Plane::Records => "records",
        Plane::Mask => "mask",
    }
}

//! The flags of `hemicube render`.

use super::cache::CacheArgs;
use super::choices::{CompensationArg, HiddenArg, NeighboursArg, RadiusArg, SolverArg};
use super::path::PathArgs;
use crate::cli::choices::{CaptureArg, GradientsArg, WeightArg};
use crate::cli::common::{DeviceArgs, ImageArgs, SceneArgs, TalkArgs, parse_seconds};
use crate::cli::reference::parse_bounces;
use clap::Args;
use hemicube::image::LayerSet;
use hemicube::image::tone::{Exposure, ToneMap};
use hemicube::renderer::Settings;
use std::path::PathBuf;

/// Render an image, or the frames of a camera's path, with indirect light by irradiance-cache splatting
///
/// Draws a G-buffer, lights the surfaces once, then places irradiance records in rounds from coarse to fine: each is
/// captured as a multi-view hemicube, integrated and splatted over the pixels it is valid for, until every visible pixel
/// is covered. A table of all passes with their GPU times ends the run.
#[derive(Args, Debug)]
#[command(after_help = SHORT_HELP, after_long_help = HELP)]
pub struct RenderArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// Image to write: .exr (linear floats, with layers), .hdr (linear, colour alone), .png or .jpg (tone-mapped)
    #[arg(short, long, value_name = "OUT.exr|hdr|png|jpg", required_unless_present = "y4m")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) path: PathArgs,
    #[command(flatten)]
    pub(super) image: ImageArgs,
    /// Layers of the EXR besides R,G,B: direct, indirect, irradiance, irradiance_direct, albedo, emission, N, P, Z,
    /// records, mask, or all
    /// [default: direct,indirect,irradiance,albedo,N,P,Z]
    #[arg(long, value_name = "LIST|all", help_heading = "Image")]
    pub(super) layers: Option<LayerSet>,
    /// Exposure of a PNG or JPEG in stops, -100 to 100; auto, the default, brings the mean of the logarithms to middle grey
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true, help_heading = "Image")]
    pub(super) exposure: Option<Exposure>,
    /// Tone mapping of a PNG or JPEG: agx, srgb (clamped) or reinhard
    /// [default: agx]
    #[arg(long, value_name = "NAME", help_heading = "Image")]
    pub(super) tone: Option<ToneMap>,
    /// Draw the samples of this volume (`hemicube bake volume`) over the image, as white balls in their own light; samples inside
    /// of geometry are red
    #[arg(long, value_name = "VOLUME.json", conflicts_with = "frames", help_heading = "Image", hide_short_help = true)]
    pub(super) show_probes: Option<PathBuf>,
    /// Bounces of indirect light: 0 for direct light only, all for as many as carry light
    ///
    /// Bounces beyond the first are gathered at sparse places on the surfaces, each captured once.
    #[arg(long, value_name = "N|all", default_value = "1", value_parser = parse_bounces, help_heading = "Light")]
    pub(super) bounces: u32,
    /// Share of the light that --bounces all may leave out
    #[arg(long, default_value_t = Settings::default().bounce_tolerance, value_name = "SHARE", help_heading = "Light", hide_short_help = true)]
    pub(super) bounce_tolerance: f32,
    /// Solver of --bounces all
    #[arg(long, value_enum, default_value = "accelerated", help_heading = "Light", hide_short_help = true)]
    pub(super) bounce_solver: SolverArg,
    /// Approximate number of places that gather the bounces beyond the first; without it one per hundred surface cells, 1024 to 3072
    #[arg(long, value_name = "N", help_heading = "Light", hide_short_help = true)]
    pub(super) places: Option<u32>,
    /// Light samples over all emissive triangles, at least one per triangle; more samples give smoother soft shadows
    #[arg(long, default_value_t = Settings::default().lights.area_samples, value_name = "N", help_heading = "Light")]
    pub(super) light_samples: u32,
    /// Approximate number of surface cells that store lit radiance, finer near small triangles and near the file's cameras; each
    /// triangle has at least one
    #[arg(long, value_name = "N", help_heading = "Light", hide_short_help = true)]
    pub(super) surface_cells: Option<u32>,
    /// Ward's a: a record reaches a times R (--radius). Smaller: more records, less error
    #[arg(long, default_value_t = Settings::default().cache.accuracy, allow_negative_numbers = true, value_name = "A", help_heading = "Irradiance cache")]
    pub(super) accuracy: f32,
    /// How a record captures the scene
    #[arg(long, value_enum, default_value = "auto", help_heading = "Irradiance cache")]
    pub(super) capture: CaptureArg,
    /// Width of a capture (of a hemicube's top face) in texels: even, 8 to 256
    #[arg(long, default_value_t = Settings::default().cache.capture_size, value_name = "N", help_heading = "Irradiance cache")]
    pub(super) capture_size: u32,
    /// Largest geometric error of simplified distant triangles in compute captures, in texels of a hemicube. It applies to
    /// scenes of many triangles, whose flat surfaces and sky shadows are simplified too. 0 draws the full mesh
    #[arg(long, default_value_t = Settings::default().cache.lod_error, allow_negative_numbers = true, value_name = "TEXELS", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) lod_error: f32,
    /// Field of view of --capture plane along each axis, in degrees, 10 to 170
    /// [default: 126.87]
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "DEGREES",
        help_heading = "Irradiance cache",
        hide_short_help = true
    )]
    pub(super) aperture: Option<f64>,
    /// Fill the directions outside --capture plane with the texels at its border; without this they are black
    /// [default: on]
    #[arg(long, value_enum, help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) compensation: Option<CompensationArg>,
    /// Voxels along the scene's longest side for --capture slices, 4 to 128
    /// [default: 32]
    #[arg(long, value_name = "N", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) slices: Option<u32>,
    /// Distance in voxels up to which --capture slices draws triangles, 2 to 1000
    /// [default: 8]
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "VOXELS",
        help_heading = "Irradiance cache",
        hide_short_help = true
    )]
    pub(super) slices_near: Option<f32>,
    /// Subdivide triangles until no edge is longer than this share of the scene's diagonal; --capture hemisphere, which
    /// draws curved edges straight, does this by default
    #[arg(long, value_name = "SHARE", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) tessellate: Option<f32>,
    /// Irradiance gradients used to extrapolate from a record
    #[arg(long, value_enum, default_value = "both", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) gradients: GradientsArg,
    /// Definition of the radius R; a record's zone of influence has the radius a·R (--accuracy)
    #[arg(long, value_enum, default_value = "hessian", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) radius: RadiusArg,
    /// Weight of a record at a point
    #[arg(long, value_enum, default_value = "bounded", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) weight: WeightArg,
    /// Smallest radius of a record's zone of influence as a share of the image's height; never below two pixels
    #[arg(long, default_value_t = Settings::default().cache.min_radius, allow_negative_numbers = true, value_name = "SHARE", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) min_radius: f32,
    /// Largest radius of a record's zone of influence as a share of the image's height
    #[arg(long, default_value_t = Settings::default().cache.max_radius, allow_negative_numbers = true, value_name = "SHARE", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) max_radius: f32,
    /// Smallest sum of weights of a covered pixel
    #[arg(long, default_value_t = Settings::default().cache.covered, allow_negative_numbers = true, value_name = "W", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) coverage: f32,
    /// Place new records where the records of a pixel differ by more than this, relative to their mean. This removes dark and
    /// bright spots at the edges of light. Below 32 texels (N), the limit is 32/N times as large, since the error of captures is
    /// larger by that factor. 0 turns it off
    #[arg(long, default_value_t = Settings::default().cache.contrast, allow_negative_numbers = true, value_name = "C", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) contrast: f32,
    /// Maximum records placed before uncovered pixels are searched again; a smaller number gives fewer records in more time.
    /// Default: all that the round's lattice of pixels needs
    #[arg(long, value_name = "N", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) batch: Option<u32>,
    /// Angle between normals, as √(1 − cos), at which a record's weight is zero
    #[arg(long, default_value_t = Settings::default().cache.normal_limit, allow_negative_numbers = true, value_name = "X", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) normal_limit: f32,
    /// Whether neighbouring records limit a new record's radius
    #[arg(long, value_enum, default_value = "clamp", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) neighbours: NeighboursArg,
    /// Points hidden from a record, by the distances in the record's hemicube
    #[arg(long, value_enum, default_value = "reject", help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) hidden: HiddenArg,
    /// Seed of the captures' random rotations
    #[arg(long, default_value_t = 0, help_heading = "Irradiance cache", hide_short_help = true)]
    pub(super) seed: u32,
    #[command(flatten)]
    pub(super) cache: CacheArgs,
    /// Place no more records after so many seconds of the run
    ///
    /// The picture is complete, of the records that there are, and gets better with more time. Of a sequence no more frames are begun
    /// (--resume goes on).
    #[arg(long, value_name = "S", value_parser = parse_seconds, help_heading = "Irradiance cache")]
    pub(super) time_limit: Option<f64>,
    /// Build and run every pass, needed or not (to check that leaving passes out changes no pixel)
    #[arg(long, hide_short_help = true, help_heading = "Device")]
    pub(super) full_plan: bool,
    /// Measure the device's peak rates, as `hemicube info --measure` does, and print the rates of capture, integration and
    /// splatting as a share of them
    #[arg(long, help_heading = "Report")]
    pub(super) measure: bool,
    /// Write statistics as JSON: plan, records, times of all passes, memory
    #[arg(long, value_name = "FILE.json", help_heading = "Report")]
    pub(super) stats: Option<PathBuf>,
    /// Write a Chrome trace of all passes and CPU stages; opens in Perfetto
    #[arg(long, value_name = "FILE.json", help_heading = "Report")]
    pub(super) trace: Option<PathBuf>,
    #[command(flatten)]
    pub(super) device: DeviceArgs,
    #[command(flatten)]
    pub(super) talk: TalkArgs,
}

const SHORT_HELP: &str = "--help explains every flag, with units, examples and exit codes.";

const HELP: &str = "\
Units: a light of intensity I gives I·cosθ/d²; an emissive texel of value L is radiance L; nothing is scaled. Surfaces are
Lambertian and two-sided (metalness and roughness are not used); emitters shine from their front, from both sides if the
material is double-sided, and reflect by their base colour.

Examples:
  hemicube render -o cornell.exr
  hemicube render sponza.gltf -o sponza.png --exposure 1
  hemicube render sponza.gltf -o sponza.exr --width 640 --height 360 --accuracy 0.2 --stats sponza.json
  hemicube render room.glb -o room.png --bounces all
  hemicube render room.glb -o room.exr --background sky.exr --layers all --trace room.trace.json
  hemicube render walk.glb -o walk.%04d.png --frames 0-239 --fps 24
  hemicube render sponza.gltf -o turn.png --frames 0-59 --orbit 90 --stats turn.json
  hemicube render sponza.gltf --frames 0-95 --walk walk.json --y4m | ffmpeg -i - walk.mp4
  hemicube render sponza.gltf -o walk.png --frames 0-95 --walk walk.json --cache sponza.records
    walk.json: {\"keys\": [{\"time\": 0, \"eye\": [-10, 1.7, -0.5], \"target\": [0, 2, 0]},
                        {\"time\": 4, \"eye\": [4, 1.7, -0.3], \"target\": [12, 4, 0]}]}

A draft, in half to a sixth of the time, with three times the error: --accuracy 1 --capture-size 16 --contrast 0 --surface-cells 60000
--min-radius .06 --max-radius .1

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device, or device lost.";

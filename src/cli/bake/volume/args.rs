//! The flags of `hemicube bake volume`, and their checks.

use crate::cli::common::{DeviceArgs, SceneArgs, TalkArgs, check_output};
use crate::cli::probe::{check_capture_size, check_order};
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use glam::{DVec3, UVec3};
use hemicube::volume::export::Engine;
use std::path::PathBuf;

/// Most samples along a side of a uniform grid.
const MOST: u32 = 129;

/// Bake an irradiance volume: spherical harmonics of the light at points in space, for objects that move
///
/// The command captures the six faces of a cube at each sample and projects the radiance onto spherical harmonics, with gradients.
/// Samples stand on a uniform grid, or in an octree that is finer where light changes. A volume holds light that surfaces have
/// reflected once, and the background's own light. The direct light of lamps and emitters is left out, because engines add it by
/// themselves. A sample inside of geometry is moved out where a way out is near, and marked where none is.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct VolumeArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// File to write: .json; for Bevy .ktx2, for Godot .tres
    #[arg(short, long, value_name = "OUT.json|OUT.ktx2|OUT.tres")]
    pub(super) output: PathBuf,
    /// Write an engine's own format: a uniform grid in the engine's units, order and axes. `hemicube probe --volume` reads only the
    /// format without this flag
    #[arg(long = "for", value_enum, value_name = "ENGINE")]
    pub(super) engine: Option<EngineArg>,
    /// Samples along each side of the box, 2 to 129: one number, or three for x, y and z. Default: 9
    #[arg(long, value_name = "N|X,Y,Z", value_parser = counts, conflicts_with = "adaptive", help_heading = "Samples")]
    pub(super) uniform: Option<UVec3>,
    /// Place samples where light changes: an octree between --min-level and --max-level
    #[arg(long, help_heading = "Samples")]
    pub(super) adaptive: bool,
    /// Level of the coarsest cells: level L cuts each side of the box into 2^L cells
    #[arg(long, value_name = "L", default_value_t = 2, requires = "adaptive", help_heading = "Samples")]
    pub(super) min_level: u32,
    /// Level of the finest cells, 7 at most
    #[arg(long, value_name = "L", default_value_t = 4, requires = "adaptive", help_heading = "Samples")]
    pub(super) max_level: u32,
    /// Largest error of a cell before it is cut: of the irradiance interpolated at its middle, as a share of the volume's mean
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, requires = "adaptive", help_heading = "Samples")]
    pub(super) error: f64,
    /// Measure the error of a cell if a gradient changes the irradiance across it by more than this share of the mean
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, requires = "adaptive", help_heading = "Samples")]
    pub(super) gradient_test: f64,
    /// Measure the error of a cell if it is longer than this many harmonic mean distances at a corner
    #[arg(long, value_name = "RATIO", default_value_t = 1.0, requires = "adaptive", help_heading = "Samples")]
    pub(super) harmonic_mean_test: f64,
    /// Box to fill, by two opposite corners in the scene's coordinates; default: the bounds of the scene
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_parser = corners, allow_hyphen_values = true, help_heading = "Samples")]
    pub(super) bounds: Option<[DVec3; 2]>,
    /// Share of the sphere around a sample from which on backs of triangles mean that it is inside of geometry
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, help_heading = "Samples")]
    pub(super) inside: f32,
    /// Order of the harmonics, 2 to 6: a sample has ORDER² coefficients
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(super) order: u32,
    /// Texels a side of each of the six faces: even, 8 to 128
    #[arg(long, value_name = "TEXELS", default_value_t = 32)]
    pub(super) capture_size: u32,
    /// How the gradients of the coefficients are computed. Without gradients a sample takes a quarter of the memory, and
    /// interpolation is trilinear
    #[arg(long, value_enum, default_value = "edges")]
    pub(super) gradients: GradientsArg,
    /// Distance of the captures of --gradients differences; default: a hundredth of the box's shortest side
    #[arg(long, value_name = "LENGTH")]
    pub(super) gradient_step: Option<f64>,
    /// Leave out the moments of the distances, by which `hemicube probe --volume` keeps light from passing through walls
    #[arg(long)]
    pub(super) no_moments: bool,
    /// Write times, memory, and the counts of the placement as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(super) stats: Option<PathBuf>,
    #[command(flatten)]
    pub(super) device: DeviceArgs,
    #[command(flatten)]
    pub(super) talk: TalkArgs,
}

/// `--gradients`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GradientsArg {
    /// No gradients
    None,
    /// From the edges between the texels of the sample's own capture
    Edges,
    /// By central differences of six more captures around each sample
    Differences,
}

/// `--for`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineArg {
    /// Bevy's IrradianceVolume: a 3D texture, .ktx2
    Bevy,
    /// Coefficients for three.js' LightProbe, .json
    Three,
    /// Godot's LightmapGIData with light probes: a resource, .tres
    Godot,
    /// Coefficients for Unity's SphericalHarmonicsL2, x flipped as glTFast flips it, .json
    Unity,
}

impl From<EngineArg> for Engine {
    fn from(arg: EngineArg) -> Self {
        match arg {
            EngineArg::Bevy => Self::Bevy,
            EngineArg::Three => Self::Three,
            EngineArg::Godot => Self::Godot,
            EngineArg::Unity => Self::Unity,
        }
    }
}

const HELP: &str = "\
The file holds for each sample its position, its coefficients with their gradients, and the distances that it sees; and the
cells, whose corners are the samples. Coefficients are radiance, W/(sr m²): real, orthonormal harmonics without the
Condon-Shortley sign, in the order 1; y, z, x; xy, yz, 3z²-1, xz, x²-y²; … of the scene's axes. The guide (cargo doc,
guide::volumes, or src/guide/volumes.md) describes every field, the cells, and each engine's format.
`hemicube probe --volume` reads the file.

A sample is taken for inside of geometry by the backs of triangles that it sees, so triangles should face outwards.
Where a scene's do not, --inside 1 turns that off.

Examples:
  hemicube bake volume -o cornell.json                              # 9³ samples in the built-in Cornell box
  hemicube bake volume hall.glb -o hall.json --uniform 33,9,17 --order 4
  hemicube bake volume yard.glb -o yard.json --box -4,0,-4,4,3,4    # a part of the scene
  hemicube bake volume hall.glb -o hall.json --adaptive --max-level 5 --error 0.02 --stats hall-stats.json
  hemicube bake volume hall.glb -o hall.ktx2 --for bevy --uniform 16

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device or device lost.";

/// One number for all sides, or three.
fn counts(text: &str) -> Result<UVec3, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let counts = match numbers.as_deref() {
        Some([n]) => UVec3::splat(*n),
        Some([x, y, z]) => UVec3::new(*x, *y, *z),
        _ => return Err("one whole number is wanted, or three: X,Y,Z".into()),
    };
    let fits = counts.to_array().iter().all(|n| (2..=MOST).contains(n));
    if fits { Ok(counts) } else { Err(format!("a side has 2 to {MOST} samples")) }
}

/// The lowest and the highest corner of a box.
fn corners(text: &str) -> Result<[DVec3; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let Some([a, b, c, d, e, f]) = numbers.as_deref() else { return Err("six numbers are wanted: X,Y,Z,X,Y,Z".into()) };
    let (one, other) = (DVec3::new(*a, *b, *c), DVec3::new(*d, *e, *f));
    let (low, high) = (one.min(other), one.max(other));
    let is_box = low.is_finite() && high.is_finite() && low.cmplt(high).all();
    if is_box { Ok([low, high]) } else { Err("the corners must differ along x, y and z".into()) }
}

impl VolumeArgs {
    /// Refuses what clap cannot, before anything is loaded.
    pub(super) fn check(&self) -> Result<()> {
        let wanted = self.engine.map_or("json", |engine| Engine::from(engine).extension());
        let fits = self.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
        let path = self.output.display();
        ensure!(fits, "{path}: this volume is a .{wanted} file; --for bevy writes .ktx2, --for godot .tres");
        check_order(self.order)?;
        check_capture_size(self.capture_size)?;
        let (low, high) = (self.min_level, self.max_level);
        ensure!(low <= high && high <= 7, "--min-level {low} --max-level {high}: levels rise from 0 to 7 at most");
        above_zero("--error", self.error)?;
        above_zero("--gradient-test", self.gradient_test)?;
        above_zero("--harmonic-mean-test", self.harmonic_mean_test)?;
        self.gradient_step.map_or(Ok(()), |step| above_zero("--gradient-step", step))?;
        let share = self.inside;
        ensure!((0.0..=1.0).contains(&share), "--inside {share}: a share lies between 0 and 1");
        [Some(&self.output), self.stats.as_ref()].into_iter().flatten().try_for_each(|path| check_output(path))
    }

    /// The box to fill. One that lies farther from the scene than the scene is long is taken for a mistake of units or axes.
    pub(super) fn bounds(&self, scene: [DVec3; 2]) -> Result<[DVec3; 2]> {
        let Some([low, high]) = self.bounds else { return Ok(scene) };
        let reach = (scene[1] - scene[0]).max_element();
        let near = low.cmpge(scene[0] - reach).all() && high.cmple(scene[1] + reach).all();
        near.then_some([low, high]).with_context(|| {
            format!(
                "--box from {low} to {high} lies far outside of the scene, whose bounds are {} to {}",
                scene[0], scene[1]
            )
        })
    }
}

fn above_zero(name: &str, value: f64) -> Result<()> {
    ensure!(value.is_finite() && value > 0.0, "{name} {value}: a number above 0 is wanted");
    Ok(())
}

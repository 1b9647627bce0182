//! `hemicube probe`: light at points in space, captured there or interpolated in a volume.

pub mod points;

use super::common::{DeviceArgs, SceneArgs, TalkArgs, check_output};
use super::say::{remark, say};
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use glam::{DVec3, Vec3};
use hemicube::math::sh;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::ProbeError;
use hemicube::methods::sphere_probes::{SphereProbeSettings, SteadyProbes};
use hemicube::renderer::Settings;
use hemicube::report::progress::Progress;
use hemicube::scene::Scene;
use hemicube::vk::Device;
use hemicube::vk::pass::Recorder;
use hemicube::volume::reader::ReadSettings;
use hemicube::volume::{Interpolation, Reader, file};
use points::{Light, Output};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Least order of the harmonics that irradiance is computed from: the clamped cosine has no degree 5, and 1 % of its energy above 4.
pub const ORDER_OF_IRRADIANCE: u32 = 5;

/// Measure light at points in space, as spherical harmonics, or interpolate it in a volume
///
/// With a scene, the command captures the six faces of a cube at each point and projects the radiance onto spherical harmonics. With
/// --volume, it interpolates between the samples of `hemicube bake volume`. The result is light that surfaces have reflected once,
/// and the background's own light. The direct light of lamps and emitters is left out; add it by the lights themselves.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct ProbeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The points, in the scene's coordinates: a JSON file {"points": [[x, y, z], …]}
    #[arg(long, value_name = "FILE.json")]
    points: PathBuf,
    /// File to write, JSON
    #[arg(short, long, value_name = "FILE.json")]
    output: PathBuf,
    /// Order of the harmonics, 2 to 6: its square is the number of coefficients; default: 3, or the volume's
    #[arg(long, value_name = "N")]
    order: Option<u32>,
    /// Texels a side of each of the six faces: even, 8 to 128
    #[arg(long, value_name = "TEXELS", default_value_t = 32)]
    capture_size: u32,
    /// Soften the harmonics of a point with negative irradiance, as little as ends that; the strength is in the result
    #[arg(long)]
    window: bool,
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

/// How a volume is read.
#[derive(Args, Debug)]
#[command(next_help_heading = "Volume")]
struct VolumeArgs {
    /// Volume to interpolate, instead of a scene to capture
    #[arg(long, value_name = "FILE.json", conflicts_with = "scene")]
    volume: Option<PathBuf>,
    /// Interpolation between samples. Without gradients in the file, gradients and hermite are trilinear
    #[arg(long, value_enum, default_value = "hermite", requires = "volume")]
    interpolation: InterpolationArg,
    /// Do not hide samples behind walls
    #[arg(long, requires = "volume")]
    no_leak_guard: bool,
}

/// [`Interpolation`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum InterpolationArg {
    /// Trilinear
    Trilinear,
    /// Trilinear weights over the distance
    InverseDistance,
    /// Samples extrapolated by their gradients, then trilinear
    Gradients,
    /// Cubic by values and gradients
    Hermite,
}

impl From<InterpolationArg> for Interpolation {
    fn from(arg: InterpolationArg) -> Self {
        match arg {
            InterpolationArg::Trilinear => Self::Trilinear,
            InterpolationArg::InverseDistance => Self::InverseDistance,
            InterpolationArg::Gradients => Self::Gradients,
            InterpolationArg::Hermite => Self::Hermite,
        }
    }
}

const HELP: &str = "\
Result: {\"points\": [{\"sh\": [[r, g, b], …], \"irradiance\": [+x, -x, +y, -y, +z, -z]}, …]}, in the order of the points.
  sh          radiance, W/(sr m²): real, orthonormal spherical harmonics without the Condon-Shortley sign, in the order
              1; y, z, x; xy, yz, 3z²-1, xz, x²-y²; … of the scene's axes. A constant radiance L gives sqrt(4 pi) L
              and zeros.
  irradiance  W/m², an [r, g, b] each, on surfaces that face along the six directions; the radiance of a white one is
              irradiance / pi. Of a scene it is computed from harmonics of order 5 at least, of a volume from the volume's.
  window      with --window: degree l is divided by 1 + window l²(l+1)²; 0 where nothing was negative.

Example:
  echo '{\"points\": [[0.2, 0.3, 0.2], [0.4, 0.3, 0.2]]}' > points.json
  hemicube probe --points points.json -o light.json          # in the built-in Cornell box
  hemicube probe room.glb --points points.json -o light.json --order 4 --background sky.exr
  hemicube bake volume room.glb -o room.json && hemicube probe --volume room.json --points points.json -o light.json

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device or device lost.";

/// Runs the subcommand.
pub fn run(args: &ProbeArgs) -> Result<ExitCode> {
    let begun = Instant::now();
    args.check()?;
    let places = points::read(&args.points)?;
    check_output(&args.output)?;
    let (name, lights, order) = match &args.volume.volume {
        Some(path) => args.read(path, &places)?,
        None => args.capture(&places)?,
    };
    let strengths = points::write(&args.output, &lights, Output { order, window: args.window })?;
    if !args.talk.quiet {
        let seconds = begun.elapsed().as_secs_f64();
        say!("{name}: {} points, order {order}, {seconds:.1} s; wrote {}", places.len(), args.output.display());
        if args.window {
            let strongest = strengths.iter().copied().fold(0.0, f64::max);
            let softened = strengths.iter().filter(|strength| **strength > 0.0).count();
            say!("{softened} points softened against negative irradiance, by {strongest:.4} at most");
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl ProbeArgs {
    fn check(&self) -> Result<()> {
        if let Some(order) = self.order {
            check_order(order)?;
        }
        check_capture_size(self.capture_size)
    }

    /// Captures the points. Returns the scene's name, the light, and the order to write.
    fn capture(&self, points: &[DVec3]) -> Result<(String, Vec<Light>, u32)> {
        let scene = self.scene.load()?;
        if self.talk.verbose {
            scene.notes.iter().for_each(|note| remark!("note: {note}"));
        }
        let places = points::within(&scene, points)?;
        let device = self.device.open()?;
        let order = self.order.unwrap_or(3);
        let lights = measure(&device, &scene, self, order, &places)?;
        Ok((scene.name, lights, order))
    }

    /// Interpolates at the points. Returns the volume's name, the light, and the order to write.
    fn read(&self, path: &Path, points: &[DVec3]) -> Result<(String, Vec<Light>, u32)> {
        let volume = file::read(path)?;
        let order = self.order.unwrap_or(volume.order);
        ensure!(order <= volume.order, "--order {order}: {} has order {}", path.display(), volume.order);
        let reader = Reader::new(&volume);
        let settings =
            ReadSettings { interpolation: self.volume.interpolation.into(), guard: !self.volume.no_leak_guard };
        let read = |(at, point): (usize, &DVec3)| {
            let coefficients = reader.read(*point, settings).with_context(|| format!("points[{at}]"))?;
            Ok(Light { coefficients, irradiance: None, error: None })
        };
        let lights = points.iter().enumerate().map(read).collect::<Result<Vec<Light>>>()?;
        Ok((path.display().to_string(), lights, order))
    }
}

/// Refuses orders out of range.
pub fn check_order(order: u32) -> Result<()> {
    let fits = (2..=sh::MAX_ORDER).contains(&order);
    ensure!(fits, "--order {order}: the harmonics' order is from 2 to {}", sh::MAX_ORDER);
    Ok(())
}

/// Refuses sizes of captures out of range.
pub fn check_capture_size(size: u32) -> Result<()> {
    let valid = (8..=128).contains(&size) && size.is_multiple_of(2);
    ensure!(valid, "--capture-size {size}: a capture has an even number of texels a side, from 8 to 128");
    Ok(())
}

/// A device's error by itself, so that the exit code is a device's.
pub fn plain(error: ProbeError) -> anyhow::Error {
    match error {
        ProbeError::Vulkan(error) => error.into(),
        error => error.into(),
    }
}

fn measure(device: &Arc<Device>, scene: &Scene, args: &ProbeArgs, order: u32, places: &[Vec3]) -> Result<Vec<Light>> {
    let settings = SphereProbeSettings {
        order: order.max(ORDER_OF_IRRADIANCE),
        capture_size: args.capture_size,
        capture: CaptureMode::Auto,
        gradients: false,
        distances: None,
        lights: Settings::default().lights,
        surface_cells: SphereProbeSettings::usual_cells(scene),
    };
    let mut recorder = Recorder::new(device);
    let mut probes = SteadyProbes::new(device, &mut recorder, scene, &settings).map_err(plain)?;
    let stage = Progress::new(args.talk.quiet).stage("probes", places.len() as u64);
    let found = probes.measure(&mut recorder, places, &mut |count| stage.advance(count as u64)).map_err(plain)?;
    let light = |coefficients: &Vec<Vec3>| Light {
        coefficients: coefficients.iter().map(|c| c.as_dvec3()).collect(),
        irradiance: None,
        error: None,
    };
    Ok(found.iter().map(|found| light(&found.projected.coefficients)).collect())
}

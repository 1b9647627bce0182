//! `hemicube probe`: light at points in space.

use super::common::{DeviceArgs, SceneArgs, TalkArgs, check_output};
use super::say::{remark, say};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use glam::{DVec3, Vec3};
use hemicube::image::write::write_atomic;
use hemicube::math::sh;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::ProbeError;
use hemicube::methods::sphere_probes::{SphereProbeSettings, SphereProbes};
use hemicube::methods::gather::Gathering;
use hemicube::passes::project::Projected;
use hemicube::renderer::Settings;
use hemicube::report::progress::Progress;
use hemicube::scene::Scene;
use hemicube::vk::pass::Recorder;
use hemicube::vk::{Device, Error as VulkanError};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Irradiance is by harmonics of this order at least: the clamped cosine has no degree 5, and 1 % of its energy above 4.
const ORDER_OF_IRRADIANCE: u32 = 5;

/// Measure light at points in space, as spherical harmonics
///
/// Captures the six faces of a cube at each point and projects what they see onto spherical harmonics. What is measured is light that
/// surfaces have reflected once, and the background's own light. The direct light of lamps and emitters is left out: whoever
/// uses the result adds it by the lights themselves.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct ProbeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Points to measure at, in the scene's coordinates: a JSON file {"points": [[x, y, z], …]}
    #[arg(long, value_name = "FILE.json")]
    points: PathBuf,
    /// Where the result goes, a JSON file
    #[arg(short, long, value_name = "FILE.json")]
    output: PathBuf,
    /// Order of the harmonics, 2 to 6: its square is the number of coefficients
    #[arg(long, value_name = "N", default_value_t = 3)]
    order: u32,
    /// Texels a side of each of the six faces: even, 8 to 128
    #[arg(long, value_name = "TEXELS", default_value_t = 32)]
    capture_size: u32,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

const HELP: &str = "\
Result: {\"points\": [{\"sh\": [[r, g, b], …], \"irradiance\": [+x, -x, +y, -y, +z, -z]}, …]}, in the order of the points.
  sh          radiance, W/(sr m²): real, orthonormal spherical harmonics without the Condon-Shortley sign, in the order
              1; y, z, x; xy, yz, 3z²-1, xz, x²-y²; … of the scene's axes. A constant radiance L gives sqrt(4 pi) L
              and zeros.
  irradiance  W/m², an [r, g, b] each, on surfaces that face along the six directions. A white surface there reflects
              irradiance / pi.

Example:
  echo '{\"points\": [[0.2, 0.3, 0.2], [0.4, 0.3, 0.2]]}' > points.json
  hemicube probe --points points.json -o light.json          # in the built-in Cornell box
  hemicube probe room.glb --points points.json -o light.json --order 4 --background sky.exr

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device or device lost.";

/// Runs the subcommand.
pub fn run(args: &ProbeArgs) -> Result<ExitCode> {
    let begun = Instant::now();
    args.check()?;
    let points = read_points(&args.points)?;
    check_output(&args.output)?;
    let scene = args.scene.load()?;
    if args.talk.verbose {
        scene.notes.iter().for_each(|note| remark!("note: {note}"));
    }
    let places = within(&scene, &points)?;
    let device = args.device.open()?;
    let found = measure(&device, &scene, args, &places)?;
    let count = sh::count(args.order);
    let result = json!({"points": found.iter().map(|probe| described(&probe.projected, count)).collect::<Vec<_>>()});
    write_atomic(&args.output, |sink| writeln!(sink, "{result}"))?;
    if !args.talk.quiet {
        let (name, seconds) = (&scene.name, begun.elapsed().as_secs_f64());
        say!("{name}: {} points, order {}, {seconds:.1} s; wrote {}", places.len(), args.order, args.output.display());
    }
    Ok(ExitCode::SUCCESS)
}

impl ProbeArgs {
    fn check(&self) -> Result<()> {
        let (order, size) = (self.order, self.capture_size);
        ensure!(
            (2..=sh::MAX_ORDER).contains(&order),
            "--order {order}: the harmonics' order is from 2 to {}",
            sh::MAX_ORDER
        );
        let valid = (8..=128).contains(&size) && size.is_multiple_of(2);
        ensure!(valid, "--capture-size {size}: a capture has an even number of texels a side, from 8 to 128");
        Ok(())
    }
}

/// The file's points.
fn read_points(path: &Path) -> Result<Vec<DVec3>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read the points {}", path.display()))?;
    points_of(&text).with_context(|| path.display().to_string())
}

fn points_of(text: &str) -> Result<Vec<DVec3>> {
    const SHAPE: &str = "points are written {\"points\": [[x, y, z], …]}";
    let file: Value = serde_json::from_str(text).context("this is not JSON")?;
    let Some(points) = file["points"].as_array() else { bail!("there is no list \"points\"; {SHAPE}") };
    ensure!(!points.is_empty(), "the list \"points\" is empty; give one point at least");
    let point = |(at, value): (usize, &Value)| {
        let numbers: Option<Vec<f64>> = value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
        let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        three.map(DVec3::from).with_context(|| format!("points[{at}] is {value}, not three numbers; {SHAPE}"))
    };
    points.iter().enumerate().map(point).collect()
}

/// The points relative to the scene's origin. Beyond twice the scene's bounds they are taken for a mistake of units or axes.
fn within(scene: &Scene, points: &[DVec3]) -> Result<Vec<Vec3>> {
    let (low, high) = scene.bounds();
    let reach = (high - low).max_element();
    let place = |(at, point): (usize, &DVec3)| {
        let place = (*point - scene.origin).as_vec3();
        let inside = place.cmpge(low - reach).all() && place.cmple(high + reach).all();
        ensure!(
            inside,
            "points[{at}] = [{}, {}, {}] lies outside of the scene, whose bounds are {} to {}",
            point.x,
            point.y,
            point.z,
            scene.origin + low.as_dvec3(),
            scene.origin + high.as_dvec3()
        );
        Ok(place)
    };
    points.iter().enumerate().map(place).collect()
}

/// Measures by the way that the device is faster by; where its driver ends the loops of captures in compute, by render passes.
fn measure(device: &Arc<Device>, scene: &Scene, args: &ProbeArgs, places: &[Vec3]) -> Result<Vec<Gathering>> {
    let settings = SphereProbeSettings {
        order: args.order.max(ORDER_OF_IRRADIANCE),
        capture_size: args.capture_size,
        capture: CaptureMode::Auto,
        gradients: false,
        distances: false,
        lights: Settings::default().lights,
        surface_cells: SphereProbeSettings::usual_cells(scene),
    };
    let by = |capture| {
        let stage = Progress::new(args.talk.quiet).stage("probes", places.len() as u64);
        let mut recorder = Recorder::new(device);
        let probes = SphereProbes::new(device, &mut recorder, scene, &SphereProbeSettings { capture, ..settings })?;
        probes.measure(&mut recorder, places, |count| stage.advance(count as u64))
    };
    let found = match by(CaptureMode::Auto) {
        Err(ProbeError::Vulkan(VulkanError::LoopsEnded { .. })) => by(CaptureMode::Hemicube),
        found => found,
    };
    found.map_err(|error| match error {
        ProbeError::Vulkan(error) => error.into(),
        error => error.into(),
    })
}

/// A point of the result, with its first `count` coefficients.
fn described(probe: &Projected, count: usize) -> Value {
    let channel = |c: usize| probe.coefficients.iter().map(|v| f64::from(v[c])).collect::<Vec<_>>();
    let channels = [0, 1, 2].map(channel);
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let irradiance: Vec<[f32; 3]> =
        axes.map(|axis| channels.each_ref().map(|channel| sh::irradiance(channel, axis).max(0.0) as f32)).collect();
    let sh: Vec<[f32; 3]> = probe.coefficients[..count].iter().map(Vec3::to_array).collect();
    json!({"sh": sh, "irradiance": irradiance})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_and_what_is_wrong_is_named() {
        assert_eq!(points_of("{\"points\": [[1, 2.5, -3]]}").unwrap(), [DVec3::new(1.0, 2.5, -3.0)]);
        for (text, words) in [
            ("{\"points\": [", "not JSON"),
            ("[[1, 2, 3]]", "no list \"points\""),
            ("{\"points\": []}", "empty"),
            ("{\"points\": [[1, 2, 3], [1, 2]]}", "points[1] is [1,2]"),
            ("{\"points\": [[1, 2, \"3\"]]}", "not three numbers"),
        ] {
            let error = points_of(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    #[test]
    fn points_outside_are_refused_by_number() {
        let scene = hemicube::scene::cornell();
        let inside = scene.origin + DVec3::splat(0.2);
        assert_eq!(within(&scene, &[inside]).unwrap().len(), 1);
        let error = within(&scene, &[inside, DVec3::splat(50.0)]).unwrap_err().to_string();
        assert!(error.contains("points[1] = [50, 50, 50]") && error.contains("bounds"), "{error}");
    }
}

//! `hemicube bake vertices`: irradiance as an attribute of the vertices.

use crate::cli::common::{DeviceArgs, SceneArgs, TalkArgs, check_output};
use crate::cli::reference::parse_bounces;
use crate::cli::say::{remark, say};
use anyhow::{Result, bail, ensure};
use clap::{Args, ValueEnum};
use hemicube::bake::glb::{self, Extras};
use hemicube::bake::vertices::{VertexIrradiance, VertexMethod};
use hemicube::image::write::write_atomic;
use hemicube::methods::probes::ProbeError;
use hemicube::methods::surface_irradiance::{SurfaceIrradiance, SurfaceIrradianceSettings};
use hemicube::renderer::Settings;
use hemicube::report::progress::Progress;
use hemicube::scene::Scene;
use hemicube::vk::Device;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Surface cells for each triangle, about, and the fewest and the most of a scene.
const CELLS_OF_TRIANGLE: u64 = 16;
const CELLS: [u64; 2] = [1 << 17, 1 << 21];
/// Texels a side of the captures of places.
const CAPTURE_SIZE: u32 = 24;
/// Stages that the computation goes through.
const STAGES: u64 = 5;

/// Bake the light that reaches each vertex into a GLB file, as the attribute `_IRRADIANCE`
///
/// Direct light and light of all reflections are computed over the whole surface, without a camera. Values at the vertices are
/// chosen by least squares, so that what is interpolated over the triangles comes closest to that light: a vertex that happens to
/// lie in a shadow's edge does not darken its surroundings.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct VerticesArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the scene goes, with its light: a GLB file
    #[arg(short, long, value_name = "OUT.glb")]
    output: PathBuf,
    /// What is baked: all light, or reflected light alone, for programs that add lamps by themselves
    #[arg(long, value_enum, default_value = "all", help_heading = "Light")]
    light: LightArg,
    /// Reflections on the way: 0 for direct light alone, all for as many as carry light
    #[arg(long, value_name = "N|all", default_value = "all", value_parser = parse_bounces, help_heading = "Light")]
    bounces: u32,
    /// Light samples over all emissive triangles, at least one per triangle
    #[arg(long, default_value_t = Settings::default().lights.area_samples, value_name = "N", help_heading = "Light")]
    light_samples: u32,
    /// Approximate number of places that gather reflected light, 1 to 1048576; default: one per hundred surface cells, 1024 to 3072
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 20), help_heading = "Light")]
    places: Option<u32>,
    /// Approximate number of surface cells that the light is computed on, 1 to 8388608; default: sixteen per triangle, 131072 to 2097152
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 23), help_heading = "Light")]
    surface_cells: Option<u32>,
    /// How vertices get their values
    #[arg(long, value_enum, default_value = "least-squares")]
    fit: FitArg,
    /// Show the light in any viewer: write COLOR_0 = irradiance/pi times 2^STOPS, at most 1, and unlit materials
    #[arg(long, value_name = "STOPS", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
    unlit: Option<f32>,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

const HELP: &str = "\
The file holds the scene as it is rendered: one mesh in world space with a primitive per material, instances and poses applied,
textures embedded; cameras and punctual lights too. A background is not part of glTF.
  _IRRADIANCE  float VEC3 per vertex, W/m² (linear Rec.709): a white surface reflects the radiance _IRRADIANCE / pi. It is that of
               the front; of a double-sided material, that of the side that has more light on it.

In three.js: geometry.attributes._irradiance; in Blender: the attribute _IRRADIANCE of the mesh.

Examples:
  hemicube bake vertices room.glb -o lit.glb
  hemicube bake vertices room.glb -o shown.glb --unlit 1
  hemicube bake vertices room.glb -o indirect.glb --light indirect --places 8000

Exit codes: 0 done; 2 bad usage or input; 3 no suitable device or device lost.";

/// What is baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LightArg {
    /// Direct and reflected light
    All,
    /// Light that surfaces have reflected
    Indirect,
}

/// [`VertexMethod`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FitArg {
    /// Least squares over the triangles
    LeastSquares,
    /// The light at the vertex itself
    Sampled,
}

/// Runs the subcommand.
pub fn run(args: &VerticesArgs) -> Result<ExitCode> {
    let begun = Instant::now();
    args.check()?;
    let scene = args.scene.load()?;
    if !args.talk.quiet {
        let shown = if args.talk.verbose { scene.notes.len() } else { scene.notes.len().min(6) };
        scene.notes[..shown].iter().for_each(|note| remark!("note: {note}"));
        if scene.is_dark() {
            remark!("warning: the scene has no light, so that every value is 0: --default-light adds a soft sky");
        }
    }
    ensure!(
        !scene.triangles.is_empty(),
        "{}: the scene has no triangles, so that there is nothing to bake",
        scene.name
    );
    let device = args.device.open()?;
    let found = args.irradiance(&device, &scene)?;
    let method = match args.fit {
        FitArg::LeastSquares => VertexMethod::LeastSquares,
        FitArg::Sampled => VertexMethod::Sampled,
    };
    let fit = VertexIrradiance::new(&scene, &found, method);
    if let Some(warning) = found.bounced.warning().filter(|_| !args.talk.quiet) {
        remark!("warning: {warning}");
    }
    let VertexIrradiance { values, unknowns, off, .. } = fit;
    let bytes = glb::write(&scene, &Extras { irradiance: Some(values), unlit_stops: args.unlit })?;
    write_atomic(&args.output, |sink| sink.write_all(&bytes))?;
    if !args.talk.quiet {
        let (name, vertices, seconds) = (&scene.name, scene.positions.len(), begun.elapsed().as_secs_f64());
        say!("{name}: {vertices} vertices, {unknowns} values; between them {off}");
        say!("{} places, {seconds:.1} s; wrote {}", found.bounced.places, args.output.display());
    }
    Ok(ExitCode::SUCCESS)
}

impl VerticesArgs {
    fn check(&self) -> Result<()> {
        let is_glb = self.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
        ensure!(is_glb, "cannot write {}: name it .glb", self.output.display());
        check_output(&self.output)?;
        if let Some(stops) = self.unlit {
            ensure!(stops.abs() <= 100.0, "--unlit {stops}: an exposure is from -100 to 100 stops");
        }
        if self.light == LightArg::Indirect && self.bounces == 0 {
            bail!("--light indirect with --bounces 0 leaves no light: ask for --bounces 1 or more");
        }
        Ok(())
    }

    fn irradiance(&self, device: &Arc<Device>, scene: &Scene) -> Result<SurfaceIrradiance> {
        let defaults = Settings::default();
        let usual = (CELLS_OF_TRIANGLE * scene.triangles.len() as u64).clamp(CELLS[0], CELLS[1]) as u32;
        let mut settings = SurfaceIrradianceSettings {
            direct: self.light == LightArg::All,
            bounces: self.bounces,
            tolerance: defaults.bounce_tolerance,
            solver: defaults.bounce_solver,
            places: self.places,
            capture_size: CAPTURE_SIZE,
            surface_cells: self.surface_cells.unwrap_or(usual),
            lights: defaults.lights,
        };
        settings.lights.area_samples = self.light_samples;
        let stage = Progress::new(self.talk.quiet).stage("light", STAGES);
        let mut done = 0;
        let found = SurfaceIrradiance::new(device, scene, &settings, &mut |now| {
            stage.advance(now - done);
            done = now;
        });
        found.map_err(|error| match error {
            ProbeError::Vulkan(error) => error.into(),
            error => error.into(),
        })
    }
}

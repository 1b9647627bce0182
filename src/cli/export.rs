//! `hemicube export`: a scene as plain arrays, for other programs.

mod describe;

use super::common::{ImageArgs, SceneArgs};
use super::say::{remark, say};
use anyhow::{Context, Result, ensure};
use clap::Args;
use hemicube::image::write::write_atomic;
use hemicube::reference::{Tracer, View};
use hemicube::scene::{self, Background, Camera, Scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Height of the image where nothing says its size.
const HEIGHT: u32 = 256;

/// Write a scene as plain arrays, for other programs
///
/// What hemicube reads from a glTF file (compressed or not, instances, transforms, tangents) becomes one list of
/// triangles in world space, relative to `origin`, and the surface that each pixel's centre sees comes with it, so that
/// another renderer can be asked for the irradiance at the very same points. tools/peers reads it.
#[derive(Args, Debug)]
#[command(after_long_help = HELP)]
pub struct ExportArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    image: ImageArgs,
    /// Folder to write; made if it is missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages")]
    quiet: bool,
}

const HELP: &str = "\
The folder gets scene.json, which names every other file with its kind: rows of little-endian numbers without a head.
  positions normals tangents uv0 uv1 colors   32-bit floats, a row a vertex; only the streams that the scene needs
  triangles                                   32-bit indices, three a row, grouped by material as `parts` says
  pixels                                      64-bit floats, eleven a row and a row a pixel: position, shading normal, normal
                                              of the triangle (both on the viewer's side), 1 where the surface
                                              reflects, the triangle's number; zeros where nothing is seen
  textures                                    8-bit RGBA as in the file (sRGB or linear by use), first row at v = 0
  background                                  32-bit RGB, equirectangular: centre column looks along -Z, first row at +Y
Units and meanings are those of the library's `Scene`.

Example:
  hemicube export room.gltf -o room --width 256 --background sky.exr

Exit codes: 0 done; 2 bad usage or input.";

/// Runs the subcommand.
pub fn run(args: &ExportArgs) -> Result<ExitCode> {
    let scene = args.scene.load()?;
    let (camera, note) = args.scene.camera(&scene)?;
    if !args.quiet {
        scene.notes.iter().chain(&note).for_each(|note| remark!("note: {note}"));
    }
    let (width, height) = match (args.image.width, args.image.height) {
        (None, None) => scene::image_size(&camera, None, Some(HEIGHT)),
        (width, height) => scene::image_size(&camera, width, height),
    };
    let sides = 1..=scene::LARGEST_SIDE;
    ensure!(sides.contains(&width) && sides.contains(&height), "an image of {width} × {height} pixels");
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make the folder {:?}", args.output))?;
    let mut folder = Folder { path: &args.output, files: json!({}) };
    streams(&mut folder, &scene)?;
    pixels(&mut folder, &scene, &camera, (width, height))?;
    let mut description = describe::scene(&scene, (width, height));
    description["files"] = folder.files;
    write_atomic(&args.output.join("scene.json"), |sink| writeln!(sink, "{description:#}"))?;
    if !args.quiet {
        say!("{}: {} triangles; wrote {}", scene.name, scene.triangles.len(), args.output.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// Where arrays go, and what has been written.
struct Folder<'a> {
    path: &'a Path,
    files: Value,
}

impl Folder<'_> {
    /// Writes rows of `columns` numbers each; `kind` is NumPy's name of a number.
    fn write(&mut self, name: &str, kind: &str, columns: usize, bytes: &[u8]) -> Result<()> {
        write_atomic(&self.path.join(name), |sink| sink.write_all(bytes))?;
        self.files[name] = json!({"kind": kind, "columns": columns});
        Ok(())
    }
}

fn floats(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(f32::to_le_bytes).collect()
}

fn streams(folder: &mut Folder, scene: &Scene) -> Result<()> {
    let threes = |stream: &[glam::Vec3]| floats(stream.iter().flat_map(|v| v.to_array()));
    folder.write("positions", "<f4", 3, &threes(&scene.positions))?;
    folder.write("normals", "<f4", 3, &threes(&scene.normals))?;
    for (name, stream) in [("tangents", &scene.tangents), ("colors", &scene.colors)] {
        if !stream.is_empty() {
            folder.write(name, "<f4", 4, &floats(stream.iter().flat_map(|v| v.to_array())))?;
        }
    }
    for (name, stream) in ["uv0", "uv1"].into_iter().zip(&scene.uvs) {
        if !stream.is_empty() {
            folder.write(name, "<f4", 2, &floats(stream.iter().flat_map(|v| v.to_array())))?;
        }
    }
    let indices: Vec<u8> = scene.triangles.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    folder.write("triangles", "<u4", 3, &indices)?;
    for (index, texture) in scene.textures.iter().enumerate() {
        folder.write(&format!("texture{index}"), "u1", 4, texture.rgba.as_flattened())?;
    }
    if let Background::Map(map) = &scene.background {
        folder.write("background", "<f4", 3, &floats(map.rgb.as_flattened().iter().copied()))?;
    }
    Ok(())
}

/// The surface that each pixel's centre sees, row by row from the top.
fn pixels(folder: &mut Folder, scene: &Scene, camera: &Camera, (width, height): (u32, u32)) -> Result<()> {
    let tracer = Tracer::new(scene);
    let pixels = View::new(camera, width, height).pixels(&tracer);
    let row = |pixel: &hemicube::reference::Pixel| {
        let reflects = f64::from(u8::from(pixel.reflector().is_some()));
        let [p, n, g] = pixel.surface.map_or([glam::DVec3::ZERO; 3], |s| [s.position, s.normal, s.geometric]);
        let triangle = pixel.surface.map_or(0.0, |s| f64::from(s.triangle));
        [p.x, p.y, p.z, n.x, n.y, n.z, g.x, g.y, g.z, reflects, triangle]
    };
    let bytes: Vec<u8> = pixels.iter().flat_map(row).flat_map(f64::to_le_bytes).collect();
    folder.write("pixels", "<f8", 11, &bytes)
}

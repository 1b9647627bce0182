//! `hemicube info`: the devices of this machine, or what a scene needs.

mod json;

use super::common::SceneArgs;
use super::say::say;
use anyhow::Result;
use clap::Args;
use hemicube::methods::rates::Rates;
use hemicube::passes::geometry::SurfaceSize;
use hemicube::renderer::{Plan, Settings, check_memory, largest_of, memory_needs};
use hemicube::scene::{Camera, Lens, Scene};
use hemicube::vk::{Device, DeviceChoice, Instance, REQUIREMENTS};
use std::process::ExitCode;
use std::sync::Arc;

/// Show the devices and their limits, or what a scene needs and what is left out
///
/// Without SCENE: every Vulkan device, the limits and options that matter here, and what each missing option costs. With
/// SCENE: its size, lights and cameras, what a frame at the default settings will take of the first device's memory, the
/// passes that it needs, and those it does not with the reason.
#[derive(Args, Debug)]
pub struct InfoArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Measure what each device does at most, by the renderer's own passes: triangles, blended fragments, texels
    #[arg(long, conflicts_with = "scene")]
    measure: bool,
    /// Print the same as JSON, for programs: angles in degrees, sizes in bytes, rates in a second
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(args: &InfoArgs) -> Result<ExitCode> {
    if args.scene.scene.is_some() {
        let scene = args.scene.load()?;
        let (_, note) = args.scene.camera(&scene)?;
        if args.json {
            print(&json::scene(&scene, first_device().as_deref()))?;
        } else {
            describe(&scene, note.as_deref());
        }
    } else if args.json {
        print(&json::devices(args.measure)?)?;
    } else {
        devices(args.measure)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn print(value: &serde_json::Value) -> Result<()> {
    say!("{}", serde_json::to_string_pretty(value)?);
    Ok(())
}

/// Without a device there is still much to say.
fn first_device() -> Option<Arc<Device>> {
    Instance::new(false).and_then(|instance| Device::new(instance, &DeviceChoice::Best)).ok()
}

fn describe(scene: &Scene, note: Option<&str>) {
    let (low, high) = scene.bounds();
    say!("scene      {}", scene.name);
    say!("triangles  {}", scene.triangles.len());
    say!("vertices   {}", scene.positions.len());
    say!("materials  {} in use, {} textures", scene.parts.len(), scene.textures.len());
    say!("lights     {} punctual, {} emissive triangles", scene.lights.len(), scene.emitters().len());
    let cameras: Vec<_> = scene.cameras.iter().enumerate().map(camera).collect();
    say!("cameras    {}", if cameras.is_empty() { "none".into() } else { cameras.join(", ") });
    if !scene.animations.is_empty() {
        let animations: Vec<_> =
            scene.animations.iter().map(|a| format!("\"{}\" {:.2} s", a.name, a.seconds)).collect();
        say!("animations {}", animations.join(", "));
    }
    say!("bounds     {low} to {high}, origin {}", scene.origin);
    note.into_iter().for_each(|note| say!("note       {note}"));
    scene.notes.iter().for_each(|note| say!("note       {note}"));
    let settings = Settings::default();
    let device = first_device();
    let plan = Plan::of(scene, &settings, device.as_deref());
    if let Some(device) = &device {
        let size = SurfaceSize::about(scene, &plan.surface_cells, plan.detail());
        let needs = memory_needs(device, scene, &size, &plan, &settings);
        let bytes: u64 = needs.iter().map(|need| need.bytes).sum();
        say!("memory     about {} MB of {}: {}, …", bytes / 1_000_000, device.physical.name, largest_of(&needs));
        check_memory(device, scene, &size, &plan, &settings).err().into_iter().for_each(|e| say!("note       {e}"));
    }
    say!("\nruns       {}", plan.run().join(", "));
    for left in plan.left_out() {
        say!("left out   {} ({})", left.pass, left.why);
    }
}

/// A camera as `--camera` takes it, by index or name, with its lens.
fn camera((index, camera): (usize, &Camera)) -> String {
    let lens = match camera.lens {
        Lens::Perspective { yfov, .. } => format!("{:.1}° high", yfov.to_degrees()),
        Lens::Orthographic { ymag, .. } => format!("orthographic, {} high", 2.0 * ymag),
    };
    format!("{index} \"{}\" ({lens})", camera.name)
}

fn devices(measure: bool) -> Result<()> {
    let instance = Instance::new(false)?;
    for (index, physical) in instance.physical_devices()?.into_iter().enumerate() {
        let version = physical.api_version;
        let (major, minor) = (ash::vk::api_version_major(version), ash::vk::api_version_minor(version));
        say!("{index}  {} ({:?}, Vulkan {major}.{minor}, {})", physical.name, physical.kind, physical.driver.trim());
        match Device::new(instance.clone(), &DeviceChoice::Named(index.to_string())) {
            Err(error) => say!("   cannot be used: {error}"),
            Ok(device) => {
                describe_device(&device);
                if measure {
                    describe_rates(&Rates::measure(&device)?);
                }
            }
        }
    }
    Ok(())
}

fn describe_device(device: &Device) {
    let has = &device.capabilities;
    say!("   device memory {} MB, largest allocation {} MB", has.device_memory >> 20, has.max_allocation >> 20);
    if let Some(budget) = has.memory_budget {
        say!("   of which this process may expect {} MB now", budget >> 20);
    }
    say!(
        "   largest image {0} × {0}, largest storage buffer {1} MB, {2} views a pass",
        has.limits.max_image_dimension2_d,
        has.limits.max_storage_buffer_range >> 20,
        has.max_views
    );
    say!("   timestamps {} bits, {} ns a tick", has.timestamp_bits, has.timestamp_period);
    for requirement in REQUIREMENTS {
        let verdict = if (requirement.has)(has) { "yes" } else { "no " };
        say!("   {verdict}  {}: {}", requirement.name, requirement.cost);
    }
}

fn describe_rates(rates: &Rates) {
    let millions = |rate: f64| if rate > 0.0 { format!("{:.4} M/s", rate * 1e-6) } else { "not timed".into() };
    say!("   measured  {} triangles × views captured", millions(rates.triangle_views));
    say!("   measured  {} fragments splatted", millions(rates.blended_fragments));
    say!("   measured  {} texels integrated", millions(rates.integrated_texels));
    if let Some(compute) = rates.compute {
        say!("   measured  {} triangles × views captured in compute", millions(compute.triangle_views));
        say!("   measured  {} texels captured in compute", millions(compute.texels));
        say!("   measured  {} texels integrated after that", millions(compute.integrated_texels));
    }
    say!("   measured  {:.4} ms for the timestamps and barriers about a pass", rates.timestamp_ms);
}

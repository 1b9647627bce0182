//! `hemicube convergence`: error against time for every method and setting.

mod args;
mod eta;
mod folder;
mod measure;
mod output;
mod peers;
mod solvers;
mod stability;
mod task;
mod truth;

use super::say::remark;
use super::stop;
use anyhow::{Context, Result, ensure};
pub use args::{ConvergenceArgs, MethodArg};
use eta::Eta;
use folder::Folder;
use hemicube::reference::{Tracer, View, process_time};
use hemicube::report::convergence::Machine;
use hemicube::report::progress::Progress;
use hemicube::scene::{self, Camera};
use measure::Bench;
use std::process::ExitCode;
use std::time::Instant;
use task::Task;

/// Height of the image where nothing else says its size.
const HEIGHT: u32 = 256;
/// The same with `--quick`: in the time that it has for a reference, a larger one would have more noise than caches have
/// error.
const QUICK_HEIGHT: u32 = 128;

/// Runs the subcommand.
pub fn run(args: &ConvergenceArgs) -> Result<ExitCode> {
    if args.stability {
        return stability::run(args);
    }
    if args.solvers {
        return solvers::run(args);
    }
    let scene = args.scene.load()?;
    let (camera, note) = args.scene.camera(&scene)?;
    if !args.quiet {
        scene.notes.iter().chain(&note).for_each(|note| remark!("note: {note}"));
    }
    let given = args.reference.as_deref().map(|path| Ok::<_, anyhow::Error>((path, truth::read(path)?))).transpose()?;
    let size = size(args, &camera, given.as_ref().map(|(_, picture)| (picture.width, picture.height)))?;
    let others = args.peers.as_deref().map(|path| peers::read(path, &args.name(), size)).transpose()?;
    let mut folder = Folder::open(args)?;
    let cpu = process_time();
    let tracer = Tracer::new(&scene);
    let tracer_cpu_s = cpu.zip(process_time()).map_or(0.0, |(from, to)| to.saturating_sub(from).as_secs_f64());
    let view = View::new(&camera, size.0, size.1);
    let truth = match &given {
        Some((path, picture)) => truth::given(args, path, picture, &tracer, &view)?,
        None => truth::made(args, &tracer, &view)?,
    };
    folder.claim(&tracer, &view, &truth)?;
    let mut bench = Bench {
        args,
        name: args.name(),
        scene: &scene,
        camera: &camera,
        size,
        tracer: &tracer,
        tracer_cpu_s,
        truth: &truth,
        direct: None,
    };
    let device = measure_all(&mut bench, &mut folder)?;
    if let Some(others) = others {
        folder.merge(others.points)?;
        others.notes.iter().filter(|_| !args.quiet).for_each(|note| remark!("note: {note}"));
    }
    output::write(args, &folder, &truth, size, device.as_deref())?;
    Ok(ExitCode::SUCCESS)
}

fn size(args: &ConvergenceArgs, camera: &Camera, reference: Option<(u32, u32)>) -> Result<(u32, u32)> {
    let (width, height) = (args.image.width, args.image.height);
    let size = match reference {
        Some((w, h)) => {
            let agrees = width.is_none_or(|given| given == w) && height.is_none_or(|given| given == h);
            ensure!(agrees, "--reference has {w} × {h} pixels: leave --width and --height out, or name another");
            (w, h)
        }
        None if width.is_none() && height.is_none() => {
            scene::image_size(camera, None, Some(if args.quick { QUICK_HEIGHT } else { HEIGHT }))
        }
        None => scene::image_size(camera, width, height),
    };
    let sides = 1..=scene::LARGEST_SIDE;
    ensure!(sides.contains(&size.0) && sides.contains(&size.1), "an image of {} × {} pixels", size.0, size.1);
    Ok(size)
}

/// Measures what the folder does not have yet; returns the device's name if one was opened.
fn measure_all(bench: &mut Bench, folder: &mut Folder) -> Result<Option<String>> {
    let args = bench.args;
    let opened = if args.methods.contains(&MethodArg::Splatting) { Some(args.device.open()?) } else { None };
    let tasks = task::tasks(args, opened.as_ref().is_none_or(|device| device.is_cpu()));
    if let Some(device) = &opened {
        tasks.iter().try_for_each(|task| task.renderer(bench.size).check(device))?;
    }
    let device = opened.map(|device| format!("{} ({})", device.physical.name, device.physical.driver.trim()));
    let name = device.as_deref().unwrap_or_default();
    let missing: Vec<Task> =
        tasks.into_iter().filter(|task| !folder.has(&bench.empty_point(task, name).key())).collect();
    if let Some(load) = Machine::load().filter(|load| *load > 0.5 && !missing.is_empty() && !args.quiet) {
        remark!("note: this machine is busy with something else (load {load:.1}): clock times will be too long");
    }
    let kept = args.output.display();
    stop::keeps(format!("the points measured so far are in {kept}; the same command measures the others"));
    let mut eta = Eta::new(&missing);
    let stage = Progress::new(args.quiet).stage("points", missing.len() as u64);
    for (index, task) in missing.iter().enumerate() {
        let begun = Instant::now();
        let empty = bench.empty_point(task, name);
        let label = format!("{}/{} {} {}", index + 1, missing.len(), task.method(), empty.words());
        match bench.measure(task, empty).with_context(|| label.clone()) {
            Ok((point, picture)) => {
                let shown = output::one_line(&point);
                folder.add(point, &picture)?;
                eta.done(index, begun.elapsed());
                if !args.quiet {
                    remark!("{label}: {shown}{}", eta.words());
                }
            }
            Err(error) if error.downcast_ref::<measure::DoesNotFit>().is_some() => {
                eta.done(index, begun.elapsed());
                remark!("note: left out: {error:#}");
            }
            Err(error) => return Err(error),
        }
        stage.advance(1);
    }
    Ok(device)
}

//! `hemicube reference --points`: path-traced light at points, in the format of `hemicube probe`.

use super::{Method, ReferenceArgs};
use crate::cli::common::check_output;
use crate::cli::probe::points::{self, Light, Output};
use crate::cli::probe::{ORDER_OF_IRRADIANCE, check_order};
use crate::cli::say::{remark, say};
use anyhow::{Context, Result, ensure};
use hemicube::reference::points::light_at;
use hemicube::reference::{Settings, Tracer};
use hemicube::report::progress::Progress;
use rayon::prelude::*;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Paths a point without `--spp`.
const PATHS: u32 = 1 << 14;

/// Traces light at the points of a file.
pub fn run(args: &ReferenceArgs, file: &Path) -> Result<ExitCode> {
    let begun = Instant::now();
    check(args)?;
    let places = points::read(file)?;
    let scene = args.scene.load()?;
    if !args.quiet {
        scene.notes.iter().for_each(|note| remark!("note: {note}"));
    }
    let relative = points::within(&scene, &places)?;
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().context("cannot start the threads")?;
    }
    let tracer = Tracer::new(&scene);
    let settings = Settings { bounces: args.bounces, seed: args.seed, batch: 1 };
    let paths = args.spp.unwrap_or(PATHS);
    let stage = Progress::new(args.quiet).stage("points", relative.len() as u64);
    let light = |(i, place): (usize, &glam::Vec3)| {
        let order = args.order.max(ORDER_OF_IRRADIANCE);
        let found = light_at(&tracer, place.as_dvec3(), order, &settings, (i as u64, paths));
        stage.advance(1);
        Light { coefficients: found.coefficients, irradiance: Some(found.irradiance), error: Some(found.error) }
    };
    let lights: Vec<Light> = relative.par_iter().enumerate().map(light).collect();
    drop(stage);
    points::write(&args.output, &lights, Output { order: args.order, window: false })?;
    if !args.quiet {
        let mean = lights.iter().filter_map(|light| light.error).sum::<f64>() / lights.len() as f64;
        let seconds = begun.elapsed().as_secs_f64();
        let (name, count, output) = (&scene.name, lights.len(), args.output.display());
        say!(
            "{name}: {count} points, {paths} paths each, standard error {:.2} %, {seconds:.1} s; wrote {output}",
            1e2 * mean
        );
    }
    Ok(ExitCode::SUCCESS)
}

fn check(args: &ReferenceArgs) -> Result<()> {
    let is_json = args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    ensure!(is_json, "{}: light at --points is written to a .json file", args.output.display());
    check_output(&args.output)?;
    check_order(args.order)?;
    ensure!(args.method == Method::Path, "--points wants --method path");
    let of_pictures =
        args.resume.is_some() || args.time.is_some() || args.relative_error.is_some() || args.stats.is_some();
    ensure!(!of_pictures, "--resume, --time, --relative-error and --stats go with pictures, not with --points");
    Ok(())
}

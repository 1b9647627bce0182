//! What a run was and cost, for people and as JSON.

use super::ReferenceArgs;
use super::setup::{Job, Output, bounces_name};
use crate::cli::say::say;
use anyhow::Result;
use hemicube::reference::Cost;
use hemicube::report::stats::{SceneStats, StageStats, Stats};
use serde_json::json;
use std::time::Duration;

/// Prints the summary and writes `--stats`.
pub fn tell(args: &ReferenceArgs, job: &Job, output: &Output, wall: Duration) -> Result<()> {
    if !args.quiet {
        say!("{}", headline(args, job, output));
        output.stages.iter().for_each(|(name, cost)| say!("  {}", line(name, cost)));
    }
    if let Some(path) = &args.stats {
        stats(args, job, output, wall).write(path)?;
    }
    Ok(())
}

fn headline(args: &ReferenceArgs, job: &Job, output: &Output) -> String {
    let (width, height) = job.size;
    let bounces = bounces_name(args.bounces);
    let what = match output.relative_error {
        Some(error) => format!("{} paths a pixel, standard error {:.2} % of the mean", output.spp, 100.0 * error),
        None if output.records > 0 => format!("{} records", output.records),
        None => format!("{} paths a pixel", output.spp),
    };
    format!("{}: {width} × {height}, bounces {bounces}, {}: {what}", job.scene.name, args.method_name())
}

fn line(name: &str, cost: &Cost) -> String {
    format!(
        "{name:13} {:8.2} s on the clock, {:8.2} s of CPU, {:9.2} M rays, {:.2} M rays a CPU second",
        cost.wall.as_secs_f64(),
        cost.cpu.as_secs_f64(),
        cost.rays as f64 * 1e-6,
        cost.rays_per_cpu_second() * 1e-6
    )
}

fn stats(args: &ReferenceArgs, job: &Job, output: &Output, wall: Duration) -> Stats {
    let scene = &job.scene;
    let emitting = scene.materials.iter().filter(|m| m.emission != glam::Vec3::ZERO).count();
    let mut stats = Stats::new();
    stats.device = "CPU".into();
    stats.scene = SceneStats {
        triangles: scene.triangles.len() as u64,
        vertices: scene.positions.len() as u64,
        lights: (scene.lights.len() + emitting) as u64,
        materials: scene.materials.len() as u64,
    };
    stats.records = output.records as u64;
    stats.wall_ms = 1e3 * wall.as_secs_f64();
    stats.cpu_stages = output
        .stages
        .iter()
        .map(|(name, cost)| StageStats { name: (*name).into(), ms: 1e3 * cost.wall.as_secs_f64() })
        .collect();
    let cpu: f64 = output.stages.iter().map(|(_, cost)| cost.cpu.as_secs_f64()).sum();
    let rays: u64 = output.stages.iter().map(|(_, cost)| cost.rays).sum();
    let stages: Vec<_> = output
        .stages
        .iter()
        .map(|(name, c)| json!({"name": name, "wall_s": c.wall.as_secs_f64(), "cpu_s": c.cpu.as_secs_f64(), "rays": c.rays}))
        .collect();
    for (key, value) in [
        ("method", json!(args.method_name())),
        ("bounces", json!(bounces_name(args.bounces))),
        ("seed", json!(args.seed)),
        ("spp", json!(output.spp)),
        ("relative_error", json!(output.relative_error)),
        ("cpu_s", json!(cpu)),
        ("rays", json!(rays)),
        ("stages", json!(stages)),
    ] {
        stats.extra.insert(key.into(), value);
    }
    stats
}

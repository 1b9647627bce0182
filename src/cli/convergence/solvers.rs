//! `hemicube convergence --solvers`: all bounces, plain beside accelerated.

use super::ConvergenceArgs;
use crate::cli::say::remark;
use anyhow::{Context, Result};
use hemicube::image::write::write_atomic;
use hemicube::methods::surface_cache::Solver;
use hemicube::report::progress::Progress;
use hemicube::report::solvers::{cases, charts, csv, markdown, run as solve};
use std::fs;
use std::process::ExitCode;

/// Solves all cases and writes solvers.csv, solvers.md and two charts.
pub fn run(args: &ConvergenceArgs) -> Result<ExitCode> {
    let folder = &args.output;
    fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let device = args.device.open()?;
    let name = format!("{} ({})", device.physical.name, device.physical.driver.trim());
    let cases = cases();
    let stage = Progress::new(args.quiet).stage("cases", cases.len() as u64);
    let mut rows = Vec::new();
    for case in &cases {
        let both = solve(&device, case, &[Solver::Plain, Solver::Accelerated]).with_context(|| case.name.clone())?;
        both.iter().filter(|_| !args.quiet).for_each(|row| remark!("{}", row.words()));
        rows.extend(both);
        stage.advance(1);
    }
    let [by_products, by_time] = charts(&rows).map(|chart| chart.svg());
    let files = [
        ("solvers.csv", csv(&rows, &name)),
        ("solvers.md", markdown(&rows, &name)),
        ("missing-products.svg", by_products),
        ("missing-ms.svg", by_time),
    ];
    for (file, text) in files {
        write_atomic(&folder.join(file), |sink| sink.write_all(text.as_bytes()))?;
    }
    Ok(ExitCode::SUCCESS)
}

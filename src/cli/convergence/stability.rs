//! `hemicube convergence --stability`: the suite's rows as a table.

use super::ConvergenceArgs;
use crate::cli::say::remark;
use anyhow::{Context, Result};
use hemicube::image::write::write_atomic;
use hemicube::report::progress::Progress;
use hemicube::report::stability::{csv, markdown, run as run_suite};
use std::fs;
use std::process::ExitCode;

/// Runs the suite and writes stability.csv and stability.md; exit code 1 if a row is out of bounds.
pub fn run(args: &ConvergenceArgs) -> Result<ExitCode> {
    let folder = &args.output;
    fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let device = args.device.open()?;
    let name = format!("{} ({})", device.physical.name, device.physical.driver.trim());
    let stage = Progress::new(args.quiet).stage("groups", hemicube::report::stability::group_count());
    let rows = run_suite(&device, |group| {
        for row in group.iter().filter(|row| !args.quiet || !row.holds()) {
            let mark = if row.holds() { "" } else { ", OUT OF BOUNDS" };
            let (error, tolerance) = (row.error(), row.tolerance());
            remark!(
                "{}, {}: {}: error {error:.1e} of at most {tolerance:.1e}{mark}",
                row.capture,
                row.case,
                row.quantity
            );
        }
        stage.advance(1);
    })?;
    for (file, text) in [("stability.csv", csv(&rows, &name)), ("stability.md", markdown(&rows, &name))] {
        write_atomic(&folder.join(file), |sink| sink.write_all(text.as_bytes()))?;
    }
    let failed = rows.iter().filter(|row| !row.holds()).count();
    if !args.quiet {
        remark!("{}: {} rows, {failed} out of bounds", folder.display(), rows.len());
    }
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

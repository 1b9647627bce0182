//! The command line: one file a subcommand, the flags they share in [`common`].
//!
//! Exit codes: 0 done; 1 a comparison is above its threshold; 2 bad usage or input; 3 no suitable device or device lost.

mod common;
mod compare;
mod reference;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Global illumination by rasterisation alone: irradiance-cache splatting on Vulkan.
#[derive(Parser)]
#[command(version, about, long_about = None, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Compare(compare::CompareArgs),
    Reference(Box<reference::ReferenceArgs>),
}

/// Runs the chosen subcommand.
pub fn run(cli: Cli) -> Result<ExitCode> {
    match cli.command {
        Command::Compare(args) => compare::run(&args),
        Command::Reference(args) => reference::run(&args),
    }
}

/// Exit code of a failed run: whatever is not the device's fault is the input's.
pub fn exit_code(_error: &anyhow::Error) -> ExitCode {
    ExitCode::from(2)
}

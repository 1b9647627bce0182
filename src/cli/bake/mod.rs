//! `hemicube bake`: light for engines and tools.

mod volume;

use anyhow::Result;
use clap::{Args, Subcommand};
use std::process::ExitCode;

/// Bake light for engines and tools
#[derive(Args)]
pub struct BakeArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Volume(Box<volume::VolumeArgs>),
}

/// Runs the chosen bake.
pub fn run(args: &BakeArgs) -> Result<ExitCode> {
    match &args.what {
        What::Volume(args) => volume::run(args),
    }
}

//! `hemicube bake`: light for engines and tools, a kind of bake a subcommand.

mod vertices;
mod volume;

use anyhow::Result;
use clap::{Args, Subcommand};
use std::process::ExitCode;

/// Bake light for engines and tools
#[derive(Args)]
pub struct BakeArgs {
    #[command(subcommand)]
    kind: Kind,
}

/// The kinds of bakes.
#[derive(Subcommand)]
enum Kind {
    Vertices(Box<vertices::VerticesArgs>),
    Volume(Box<volume::VolumeArgs>),
}

/// Runs the chosen bake.
pub fn run(args: &BakeArgs) -> Result<ExitCode> {
    match &args.kind {
        Kind::Vertices(args) => vertices::run(args),
        Kind::Volume(args) => volume::run(args),
    }
}

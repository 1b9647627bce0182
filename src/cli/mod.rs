//! The command line: one file a subcommand, the flags they share in [`common`], what they print by [`say`].
//!
//! Exit codes: 0 done; 1 a comparison is above its threshold; 2 bad usage or input; 3 no suitable device or device lost.

mod choices;
mod common;
mod compare;
mod convergence;
mod export;
mod info;
mod reference;
mod render;
pub mod say;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
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
    Render(Box<render::RenderArgs>),
    Compare(compare::CompareArgs),
    Convergence(Box<convergence::ConvergenceArgs>),
    Export(export::ExportArgs),
    Info(info::InfoArgs),
    Reference(Box<reference::ReferenceArgs>),
}

/// The arguments of this run; wrong ones end it with exit code 2.
pub fn parse() -> Cli {
    // There `--time` is how long to work.
    let reference =
        |command: clap::Command| command.mut_arg("scene_time", |a| a.long("scene-time").alias(None::<&str>));
    let matches = Cli::command().mut_subcommand("reference", reference).get_matches();
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

/// Runs the chosen subcommand.
pub fn run(cli: Cli) -> Result<ExitCode> {
    let code = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Convergence(args) => convergence::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Reference(args) => reference::run(&args),
    }?;
    say::finish()?;
    Ok(code)
}

/// Exit code of a failed run: 3 where the device is at fault, 2 where the input is.
pub fn exit_code(error: &anyhow::Error) -> ExitCode {
    use hemicube::renderer::RenderError;
    let device = match error.downcast_ref::<RenderError>() {
        Some(error) => matches!(error, RenderError::Vulkan(_) | RenderError::Memory(_)),
        None => error.is::<hemicube::vk::Error>(),
    };
    ExitCode::from(if device { 3 } else { 2 })
}

//! The command line: one file a subcommand, the flags they share in [`common`], what they print by [`say`].
//!
//! Exit codes: 0 done; 1 a comparison is above its threshold; 2 bad usage or input; 3 no suitable device or device lost; 130
//! stopped by a signal.

mod bake;
mod choices;
mod common;
mod compare;
mod completions;
mod convergence;
mod export;
mod info;
mod probe;
mod reference;
mod render;
pub mod say;
mod stop;

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
    Bake(bake::BakeArgs),
    Render(Box<render::RenderArgs>),
    Compare(compare::CompareArgs),
    Completions(completions::CompletionsArgs),
    Convergence(Box<convergence::ConvergenceArgs>),
    Export(export::ExportArgs),
    Info(info::InfoArgs),
    Probe(probe::ProbeArgs),
    Reference(Box<reference::ReferenceArgs>),
}

/// The program's commands and flags.
fn command() -> clap::Command {
    // There `--time` is how long to work.
    let reference =
        |command: clap::Command| command.mut_arg("scene_time", |a| a.long("scene-time").alias(None::<&str>));
    Cli::command().mut_subcommand("reference", reference)
}

/// The arguments of this run; wrong ones end it with exit code 2.
pub fn parse() -> Cli {
    Cli::from_arg_matches(&command().get_matches()).unwrap_or_else(|error| error.exit())
}

/// Runs the chosen subcommand.
pub fn run(cli: Cli) -> Result<ExitCode> {
    stop::handle_signals();
    let code = match cli.command {
        Command::Bake(args) => bake::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Completions(args) => completions::run(&args, &mut command()),
        Command::Convergence(args) => convergence::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Probe(args) => probe::run(&args),
        Command::Reference(args) => reference::run(&args),
    }?;
    say::finish()?;
    Ok(code)
}

/// Exit code of a failed run: 3 where the device is at fault, 2 where the input is.
pub fn exit_code(error: &anyhow::Error) -> ExitCode {
    ExitCode::from(if error.chain().any(is_of_device) { 3 } else { 2 })
}

fn is_of_device(cause: &(dyn std::error::Error + 'static)) -> bool {
    use hemicube::methods::probes::ProbeError;
    use hemicube::renderer::{RenderError, TooLarge};
    let by_render = |e: &RenderError| matches!(e, RenderError::Vulkan(_) | RenderError::Memory(_));
    cause.downcast_ref().is_some_and(by_render)
        || matches!(cause.downcast_ref(), Some(ProbeError::Vulkan(_)))
        || cause.is::<TooLarge>()
        || cause.is::<hemicube::vk::Error>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;
    use hemicube::methods::probes::ProbeError;
    use hemicube::renderer::RenderError;

    #[test]
    fn every_error_of_a_device_has_the_exit_code_3() {
        let lost = || hemicube::vk::Error::DeviceLost { content: "the pass \"splat\"".into() };
        let code = |error: anyhow::Error| format!("{:?}", exit_code(&error));
        let three = format!("{:?}", ExitCode::from(3));
        assert_eq!(code(lost().into()), three);
        assert_eq!(code(RenderError::from(lost()).into()), three);
        assert_eq!(code(ProbeError::from(lost()).into()), three);
        let wrapped = Err::<(), _>(ProbeError::from(lost())).context("measuring");
        assert_eq!(code(wrapped.unwrap_err()), three);
        assert_eq!(code(anyhow::anyhow!("no such file")), format!("{:?}", ExitCode::from(2)));
    }
}

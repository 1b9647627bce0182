//! `hemicube completions`: a script that completes commands and flags in a shell.

use anyhow::Result;
use clap::Args;
use clap_complete::{Shell, generate};
use std::process::ExitCode;

/// Print a script that completes commands and flags in a shell
///
/// For example: hemicube completions bash > ~/.local/share/bash-completion/completions/hemicube
#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// Shell to complete in
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the subcommand on the program's `command`.
pub fn run(args: &CompletionsArgs, command: &mut clap::Command) -> Result<ExitCode> {
    let mut script = Vec::new();
    generate(args.shell, command, "hemicube", &mut script);
    super::say::say!("{}", String::from_utf8_lossy(&script).trim_end());
    Ok(ExitCode::SUCCESS)
}

//! The `hemicube` command: parse, run, exit code.

// What is printed may go unread: `cli::say`.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::run(cli::parse()) {
        Ok(code) => code,
        Err(error) => {
            cli::say::remark!("error: {error:#}");
            cli::exit_code(&error)
        }
    }
}

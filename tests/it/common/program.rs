//! Runs of the `hemicube` program.

use assert_cmd::Command;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// How a run ended.
#[derive(Debug)]
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
    pub time: Duration,
}

impl Run {
    /// Whether it succeeded, and printed no warning, validation message or panic among its messages.
    pub fn is_clean(&self) -> bool {
        let is_bad = |line: &str| {
            ["warning:", "error:"].iter().any(|label| line.starts_with(label))
                || ["VUID", "panicked", "Validation"].iter().any(|word| line.contains(word))
        };
        self.code == 0 && !self.err.lines().any(is_bad)
    }
}

/// Runs `hemicube` in `folder` with the words of `arguments`.
pub fn hemicube(folder: &Path, arguments: &str) -> Run {
    hemicube_with(folder, arguments, &[])
}

/// The same with environment variables. A run that has not ended after two minutes is killed.
pub fn hemicube_with(folder: &Path, arguments: &str, variables: &[(&str, &str)]) -> Run {
    let words: Vec<&str> = arguments.split_whitespace().collect();
    run(folder, &words, variables)
}

/// The same with arguments that may hold spaces.
pub fn run(folder: &Path, arguments: &[&str], variables: &[(&str, &str)]) -> Run {
    let start = Instant::now();
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemicube"));
    command.current_dir(folder).args(arguments).timeout(Duration::from_secs(120));
    command.envs(variables.iter().copied());
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap_or(-1);
    Run { code, out: text(output.stdout), err: text(output.stderr), time: start.elapsed() }
}

/// Exit code, and what is said on the standard error output, where nobody reads the standard output; nor that other one, if
/// `neither`.
pub fn unread(folder: &Path, arguments: &str, neither: bool) -> (Option<i32>, String) {
    let closed = || {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        Stdio::from(writer)
    };
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_hemicube"));
    command.current_dir(folder).args(arguments.split_whitespace());
    command.stdout(closed()).stderr(if neither { closed() } else { Stdio::piped() });
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

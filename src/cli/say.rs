//! What the program says: the standard output and the standard error output.
//!
//! Whoever reads may stop before all is said (`| head`). A run goes on then and writes its files, without a word: `println!` would
//! end it in the middle, and so would the signal that other programs leave at its default.

use anyhow::{Context, Result};
use console::Style;
use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// The first line that could not be said, for another reason than that nobody reads.
static FAILED: OnceLock<io::Error> = OnceLock::new();

/// Whether the standard output holds a picture, so that lines go to the other one.
static DIVERTED: AtomicBool = AtomicBool::new(false);

/// Keeps the standard output free of lines from now on: they go to the standard error output.
pub fn divert() {
    DIVERTED.store(true, Ordering::Relaxed);
}

/// Prints a line on the standard output.
macro_rules! say {
    ($($words:tt)*) => { $crate::cli::say::line(format_args!($($words)*)) };
}

/// Prints a line on the standard error output: notes, warnings, progress.
macro_rules! remark {
    ($($words:tt)*) => { $crate::cli::say::remark_line(format_args!($($words)*)) };
}

pub(crate) use {remark, say};

/// What [`say!`] does.
pub fn line(words: Arguments<'_>) {
    if DIVERTED.load(Ordering::Relaxed) {
        return remark_line(words);
    }
    let said = writeln!(io::stdout(), "{words}");
    if let Err(error) = said.or_else(unless_unread) {
        // Only the first one is told.
        let _ = FAILED.set(error);
    }
}

/// What [`remark!`] does: the label of an error, a warning or a note has a colour on a terminal. A failure to write here cannot be
/// reported anywhere.
pub fn remark_line(words: Arguments<'_>) {
    let text = words.to_string();
    let style = |label| match label {
        "error" => Style::new().red().bold(),
        "warning" => Style::new().yellow().bold(),
        _ => Style::new().cyan(),
    };
    let _ = match text.split_once(": ") {
        Some((label @ ("error" | "warning" | "note"), rest)) => {
            writeln!(io::stderr(), "{}: {rest}", style(label).for_stderr().apply_to(label))
        }
        _ => writeln!(io::stderr(), "{text}"),
    };
}

/// Makes sure that all was said, or that nobody reads it.
pub fn finish() -> Result<()> {
    io::stdout().flush().or_else(unless_unread).context("cannot write the standard output")?;
    FAILED.get().map_or(Ok(()), |error| anyhow::bail!("cannot write the standard output: {error}"))
}

fn unless_unread(error: io::Error) -> io::Result<()> {
    if error.kind() == ErrorKind::BrokenPipe { Ok(()) } else { Err(error) }
}

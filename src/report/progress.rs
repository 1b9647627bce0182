//! Progress of long stages, on a terminal alone.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A stage shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_secs(2);

/// Whether progress is shown at all.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    shown: bool,
}

/// One stage with a bar; the bar goes when the stage is dropped.
pub struct Stage {
    bar: ProgressBar,
    begun: Instant,
    /// The bar waits for its time, and only a terminal's bar waits.
    waiting: AtomicBool,
}

impl Progress {
    /// Shown where the standard error output is a terminal and `quiet` is not set.
    pub fn new(quiet: bool) -> Self {
        Self { shown: !quiet && std::io::stderr().is_terminal() }
    }

    /// Begins a stage of `steps` steps.
    pub fn stage(self, name: &str, steps: u64) -> Stage {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg}  {wide_bar}  {human_pos} / {human_len}  {eta_precise} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(name.to_owned());
        Stage { bar, begun: Instant::now(), waiting: AtomicBool::new(self.shown) }
    }
}

impl Stage {
    /// Counts `steps` more steps as done. Any thread may call it.
    pub fn advance(&self, steps: u64) {
        let due = self.waiting.load(Ordering::Relaxed) && self.begun.elapsed() >= PATIENCE;
        if due && self.waiting.swap(false, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.inc(steps);
    }

    /// Steps done.
    pub fn done(&self) -> u64 {
        self.bar.position()
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quiet_stages_count_and_show_nothing() {
        let stage = Progress::new(true).stage("captures", 10);
        (0..4).for_each(|_| stage.advance(2));
        assert_eq!(stage.done(), 8);
        assert!(stage.bar.is_hidden());
    }

    #[test]
    fn a_bar_waits_for_a_long_stage() {
        let stage = Progress { shown: true }.stage("captures", 10);
        stage.advance(1);
        assert!(stage.bar.is_hidden() && stage.waiting.load(Ordering::Relaxed));
        let mut long = Progress { shown: true }.stage("captures", 10);
        long.begun -= 2 * PATIENCE;
        long.advance(1);
        assert!(!long.waiting.load(Ordering::Relaxed));
    }
}

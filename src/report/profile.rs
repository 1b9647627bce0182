//! Times of the passes on the GPU and of the stages on the CPU, as a terminal table.

use super::limits::{self, Share};
use super::table::{Table, milliseconds, percent};
use crate::image::metrics::percentile;
use std::fmt;

/// Times of one pass.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PassTimes {
    /// Name of the pass, the same as its module and its shaders.
    pub name: String,
    /// Time on the GPU of each time it ran, in order, milliseconds; empty where the device has no timestamps.
    pub gpu_ms: Vec<f64>,
    /// Time the CPU took to record it, all runs together, milliseconds.
    pub cpu_ms: f64,
}

impl PassTimes {
    /// A pass that has not run yet.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Time on the GPU of all runs, milliseconds.
    pub fn total_ms(&self) -> f64 {
        // From +0: an empty sum is −0.
        self.gpu_ms.iter().fold(0.0, |sum, ms| sum + ms)
    }

    /// Median of the runs on the GPU, milliseconds; 0 where there are none.
    pub fn median_ms(&self) -> f64 {
        self.quantile(0.5)
    }

    /// 95th percentile of the runs on the GPU, milliseconds; 0 where there are none.
    pub fn p95_ms(&self) -> f64 {
        self.quantile(0.95)
    }

    fn quantile(&self, p: f64) -> f64 {
        let mut sorted = self.gpu_ms.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        percentile(&sorted, p)
    }
}

/// Where the time of a run went.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Profile {
    /// The passes in order of their first execution.
    pub passes: Vec<PassTimes>,
    /// Time on the GPU from the first to the last pass, milliseconds.
    pub gpu_ms: f64,
    /// Time on the clock while passes were recorded and run, milliseconds.
    pub run_ms: f64,
    /// Time on the clock from start to end, milliseconds.
    pub wall_ms: f64,
    /// What passes did beside what the device does at most, where that was measured.
    pub limits: Vec<Share>,
    /// Stages of the CPU in order, with milliseconds.
    pub cpu_stages: Vec<(String, f64)>,
}

impl Profile {
    /// The pass of that name, added at the end where there is none: passes stay in order of first execution.
    pub fn pass(&mut self, name: &str) -> &mut PassTimes {
        let index = self.passes.iter().position(|pass| pass.name == name).unwrap_or_else(|| {
            self.passes.push(PassTimes::new(name));
            self.passes.len() - 1
        });
        &mut self.passes[index]
    }

    /// Share of the time in which passes are recorded and run that the device works: what is missing, it waits for the CPU. None
    /// without timestamps.
    pub fn busy(&self) -> Option<f64> {
        (self.gpu_ms > 0.0 && self.run_ms > 0.0).then(|| self.gpu_ms / self.run_ms)
    }

    fn pass_table(&self) -> Table {
        let mut table = Table::new(&["pass", "runs", "total ms", "median ms", "p95 ms", "share", "CPU ms"]);
        for pass in &self.passes {
            let total = pass.total_ms();
            let timed = |ms| if pass.gpu_ms.is_empty() { "–".to_owned() } else { milliseconds(ms) };
            let times = [total, pass.median_ms(), pass.p95_ms()].map(timed);
            let tail = [share(total, self.gpu_ms), milliseconds(pass.cpu_ms)];
            table.row([pass.name.clone(), pass.gpu_ms.len().to_string()].into_iter().chain(times).chain(tail));
        }
        let sum: f64 = self.passes.iter().map(PassTimes::total_ms).sum();
        let blank = String::new;
        table.row(["all passes".into(), blank(), milliseconds(sum), blank(), blank(), share(sum, self.gpu_ms)]);
        table
    }

    fn stage_table(&self) -> Table {
        let mut table = Table::new(&["CPU stage", "ms", "share"]);
        for (name, ms) in &self.cpu_stages {
            table.row([name.clone(), milliseconds(*ms), share(*ms, self.wall_ms)]);
        }
        table
    }
}

fn share(part: f64, whole: f64) -> String {
    if whole > 0.0 { percent(part / whole) } else { "–".into() }
}

impl fmt::Display for Profile {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.passes.is_empty() {
            writeln!(out, "{}", self.pass_table())?;
        }
        if !self.limits.is_empty() {
            writeln!(out, "{}", limits::table(&self.limits))?;
        }
        let stages = self.stage_table();
        if !stages.is_empty() {
            writeln!(out, "{stages}")?;
        }
        let busy =
            self.busy().map(|busy| format!(", {} of the time that passes run", percent(busy))).unwrap_or_default();
        writeln!(out, "GPU {} ms{busy}, wall clock {} ms", milliseconds(self.gpu_ms), milliseconds(self.wall_ms))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Two passes, one of which ran several times.
    pub(crate) fn sample() -> Profile {
        let mut profile = Profile { gpu_ms: 20.0, run_ms: 25.0, wall_ms: 50.0, ..Profile::default() };
        profile.pass("gbuffer").gpu_ms.push(2.0);
        for ms in [1.0, 5.0, 3.0, 4.0, 2.0] {
            let capture = profile.pass("capture");
            capture.gpu_ms.push(ms);
            capture.cpu_ms += 0.25;
        }
        profile.cpu_stages = vec![("load scene".into(), 12.5), ("write EXR".into(), 4.0)];
        profile
    }

    #[test]
    fn table_shows_the_passes_in_order() {
        let expected = "\
pass        runs  total ms  median ms  p95 ms   share  CPU ms
──────────  ────  ────────  ─────────  ──────  ──────  ──────
gbuffer        1     2.000      2.000   2.000  10.0 %   0.000
capture        5      15.0      3.000   4.800  75.0 %   1.250
all passes            17.0                     85.0 %

CPU stage      ms   share
──────────  ─────  ──────
load scene   12.5  25.0 %
write EXR   4.000  8.00 %

GPU 20.0 ms, 80.0 % of the time that passes run, wall clock 50.0 ms
";
        assert_eq!(sample().to_string(), expected);
    }

    #[test]
    fn a_pass_without_timestamps_is_shown_as_such() {
        let mut profile = Profile::default();
        profile.pass("splat");
        assert!(profile.to_string().contains("splat          0         –          –       –      –"), "{profile}");
    }
}

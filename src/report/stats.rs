//! The statistics file (`--stats FILE.json`): what ran, what was left out, times, memory.

use super::limits::Share;
use super::profile::{PassTimes, Profile};
use crate::image::write::{WriteError, write_atomic};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Statistics of one run; the fields are the file's keys.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Stats {
    /// Version of the program.
    pub version: String,
    /// Name of the Vulkan device.
    pub device: String,
    /// Its driver: name and version.
    pub driver: String,
    /// Size of the scene.
    pub scene: SceneStats,
    /// Which passes ran, and which the scene did not need.
    pub plan: Plan,
    /// Cache records in the result.
    pub records: u64,
    /// Rounds in which records were added.
    pub rounds: u32,
    /// Times of the passes, in order of execution.
    pub passes: Vec<PassStats>,
    /// Time on the GPU from the first to the last pass, milliseconds; the median where the run repeats.
    pub gpu_ms: f64,
    /// Time on the clock from start to end, milliseconds; the median where the run repeats.
    pub wall_ms: f64,
    /// Share of the time in which passes are recorded and run that the device works.
    #[serde(default)]
    pub busy: Option<f64>,
    /// What passes did beside what the device does at most (`--measure`).
    #[serde(default)]
    pub limits: Vec<Share>,
    /// Times of the CPU's stages, in order of execution.
    #[serde(default)]
    pub cpu_stages: Vec<StageStats>,
    /// Memory on the device.
    pub memory: Memory,
    /// Number of warnings and errors from the validation layers; 0 also where they were off.
    pub validation_messages: u64,
    /// Whatever a subcommand adds.
    #[serde(flatten)]
    pub extra: BTreeMap<String, serde_json::Value>,
}

/// Size of the scene as it was loaded.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneStats {
    /// Triangles, instances counted each.
    pub triangles: u64,
    /// Vertices, instances counted each.
    pub vertices: u64,
    /// Lights: punctual ones and emissive meshes.
    pub lights: u64,
    /// Materials in use.
    pub materials: u64,
}

/// What the renderer decided for the scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Names of the passes that run, in order.
    pub run: Vec<String>,
    /// Passes that do not run.
    pub left_out: Vec<LeftOut>,
}

/// A pass that the scene does not need.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Name of the pass.
    pub pass: String,
    /// Why, in words: `no emissive meshes`.
    pub why: String,
}

/// Times of one pass.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PassStats {
    /// Name of the pass.
    pub name: String,
    /// How many times it ran and was timed.
    pub count: u64,
    /// Time on the GPU of all runs, milliseconds.
    pub total_ms: f64,
    /// Median of the runs, milliseconds.
    pub median_ms: f64,
    /// 95th percentile of the runs, milliseconds.
    pub p95_ms: f64,
    /// Time the CPU took to record it, all runs together, milliseconds.
    pub cpu_ms: f64,
}

/// Time of one stage of the CPU.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StageStats {
    /// Name of the stage.
    pub name: String,
    /// Time on the clock, milliseconds.
    pub ms: f64,
}

/// Memory on the device, bytes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Largest amount allocated at once.
    pub gpu_bytes: u64,
    /// Allocated by use: `geometry`, `gbuffer`, `records` …
    pub by_use: BTreeMap<String, u64>,
}

impl From<&PassTimes> for PassStats {
    fn from(pass: &PassTimes) -> Self {
        Self {
            name: pass.name.clone(),
            count: pass.gpu_ms.len() as u64,
            total_ms: pass.total_ms(),
            median_ms: pass.median_ms(),
            p95_ms: pass.p95_ms(),
            cpu_ms: pass.cpu_ms,
        }
    }
}

impl Stats {
    /// Statistics with this program's version and nothing else.
    pub fn new() -> Self {
        Self { version: env!("CARGO_PKG_VERSION").into(), ..Self::default() }
    }

    /// Takes over the times of a profile.
    pub fn set_times(&mut self, profile: &Profile) {
        self.passes = profile.passes.iter().map(PassStats::from).collect();
        (self.gpu_ms, self.wall_ms) = (profile.gpu_ms, profile.wall_ms);
        (self.busy, self.limits) = (profile.busy(), profile.limits.clone());
        let stage = |(name, ms): &(String, f64)| StageStats { name: name.clone(), ms: *ms };
        self.cpu_stages = profile.cpu_stages.iter().map(stage).collect();
    }

    /// Writes the file, complete or not at all.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        write_atomic(path, |sink| {
            serde_json::to_writer_pretty(&mut *sink, self)?;
            sink.write_all(b"\n")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn file_has_the_promised_keys() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stats.json");
        let mut stats = Stats::new();
        stats.set_times(&super::super::profile::tests::sample());
        stats.plan.left_out.push(LeftOut { pass: "alpha".into(), why: "no cut-out materials".into() });
        stats.memory.by_use.insert("records".into(), 4096);
        stats.extra.insert("seed".into(), json!(7));
        stats.write(&path).unwrap();
        let value: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let promised =
            "version device driver scene plan records rounds passes gpu_ms wall_ms memory validation_messages";
        promised.split(' ').for_each(|key| assert!(value.get(key).is_some(), "{key}"));
        ["triangles", "vertices", "lights", "materials"].iter().for_each(|key| assert!(value["scene"][key].is_u64()));
        assert_eq!(value["plan"]["left_out"], json!([{"pass": "alpha", "why": "no cut-out materials"}]));
        assert_eq!(
            value["passes"][1],
            json!({"name": "capture", "count": 5, "total_ms": 15.0, "median_ms": 3.0, "p95_ms": 4.8, "cpu_ms": 1.25})
        );
        assert_eq!((&value["memory"]["by_use"]["records"], &value["seed"]), (&json!(4096), &json!(7)));
        assert_eq!(serde_json::from_value::<Stats>(value).unwrap(), stats);
    }
}

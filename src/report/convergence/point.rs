//! One measured point: a method with its settings, what it cost and how far it is from the reference.

use crate::image::metrics::Metrics;
use crate::report::csv::Row;
use serde_json::{Map, Value};

/// Columns of the CSV. Those that `tools/peers/run.py` writes too mean the same there.
pub const COLUMNS: [&str; 36] = [
    "scene",
    "width",
    "height",
    "bounces",
    "method",
    "settings",
    "threads",
    "repeats",
    "records",
    "setup_cpu_s",
    "cpu_s",
    "wall_s",
    "wall_spread_s",
    "indirect_cpu_s",
    "indirect_wall_s",
    "indirect_cpu_spread_s",
    "gpu_ms",
    "gpu_spread_ms",
    "passes_ms",
    "device_bytes",
    "host_bytes",
    "mae",
    "rms",
    "relmse",
    "p95",
    "p99",
    "max",
    "energy",
    "block_mae",
    "block_rms",
    "flip",
    "non_finite_test",
    "reference",
    "version",
    "device",
    "picture",
];

/// Settings that are the same for all points of a run; the CSV has them, tables leave them out.
const STEADY: [&str; 14] = [
    "area_samples",
    "covered",
    "direct_spp",
    "gradient_limit",
    "max_radius",
    "min_radius",
    "neighbour_clamping",
    "normal_limit",
    "sampler",
    "seed",
    "shadow_size",
    "sky_samples",
    "surface_cells",
    "weight",
];

/// Which time a chart is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Time {
    /// Processor seconds of all threads together.
    Cpu,
    /// Seconds on the clock.
    Wall,
}

/// A row of the CSV with the figures that charts need.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Every column.
    pub row: Row,
}

impl Point {
    /// A point of one scene, view and transport depth.
    pub fn new(scene: &str, (width, height): (u32, u32), method: &str, settings: &Map<String, Value>) -> Self {
        let mut point = Self { row: Row::new() };
        point.set("scene", scene);
        point.set("width", width);
        point.set("height", height);
        point.set("bounces", 1);
        point.set("method", method);
        point.set("settings", Value::Object(settings.clone()));
        point
    }

    /// Sets a column.
    pub fn set(&mut self, column: &'static str, value: impl ToString) {
        self.row.insert(column.into(), value.to_string());
    }

    /// Sets a column to a number with seven digits.
    pub fn set_number(&mut self, column: &'static str, value: f64) {
        self.set(column, short(value));
    }

    /// Sets the columns of the metrics.
    pub fn set_metrics(&mut self, m: &Metrics) {
        let plain = [
            ("mae", m.mae),
            ("rms", m.rms),
            ("relmse", m.relmse),
            ("p95", m.p95),
            ("p99", m.p99),
            ("max", m.max),
            ("block_mae", m.block_mae),
            ("block_rms", m.block_rms),
        ];
        plain.into_iter().for_each(|(column, value)| self.set_number(column, value));
        [("energy", m.energy), ("flip", m.flip)]
            .into_iter()
            .filter_map(|(column, value)| Some((column, value?)))
            .for_each(|(column, value)| self.set_number(column, value));
        self.set("non_finite_test", m.non_finite_test);
    }

    /// A column's text; empty where there is none.
    pub fn text(&self, column: &str) -> &str {
        self.row.get(column).map_or("", String::as_str)
    }

    /// A column's number, if it holds one.
    pub fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// Settings in their order.
    pub fn settings(&self) -> Map<String, Value> {
        serde_json::from_str(self.text("settings")).unwrap_or_default()
    }

    /// What a point is of; a point of the same key is not measured again.
    pub fn key(&self) -> String {
        // Devices make different points; programs on the CPU are told apart by their threads.
        let settings = Value::Object(self.settings());
        let place = [self.text("scene"), self.text("width"), self.text("height"), self.text("bounces")].join(" ");
        [&place, self.text("method"), &settings.to_string(), self.text("threads"), self.text("device")].join("|")
    }

    /// Time for the indirect light: setting up and direct light are not in it.
    pub fn seconds(&self, time: Time) -> Option<f64> {
        let column = match time {
            Time::Cpu => "indirect_cpu_s",
            Time::Wall => "indirect_wall_s",
        };
        self.number(column).filter(|seconds| *seconds > 0.0)
    }

    /// Settings that points of a method differ in, for people: `accuracy 0.3, capture compute`.
    pub fn words(&self) -> String {
        let word = |(name, value): (&String, &Value)| match value {
            Value::String(text) => format!("{name} {text}"),
            other => format!("{name} {other}"),
        };
        self.settings()
            .iter()
            .filter(|(name, _)| !STEADY.contains(&name.as_str()))
            .map(word)
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// The settings of [`Point::words`] but the one that is swept, the accuracy; in few letters.
    pub fn variant(&self) -> String {
        let settings = self.settings();
        let text = |name: &str| settings.get(name).map(|value| value.to_string().trim_matches('"').to_owned());
        let words = [
            text("capture"),
            text("capture_size").map(|size| format!("{size} texels")),
            text("gradients").map(|which| if which == "none" { "no gradients".into() } else { "gradients".into() }),
        ];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// Name of the line that the point belongs to: its method, with the number of threads where it is one of a peer's.
    pub fn series(&self) -> String {
        let name = method_name(self.text("method"));
        match self.text("method") {
            "radiance" | "mitsuba" if self.text("threads") == "1" => format!("{name}, 1 thread"),
            "radiance" | "mitsuba" => format!("{name}, {} threads", self.text("threads")),
            _ => name,
        }
    }
}

/// A method's name for people.
pub fn method_name(method: &str) -> String {
    match method {
        "splatting" => "Irradiance splatting".into(),
        "ward" => "Ward's cache".into(),
        "path" => "Path tracing".into(),
        "radiance" => "Radiance".into(),
        "mitsuba" => "Mitsuba 3 path".into(),
        other => other.into(),
    }
}

/// A number with seven significant digits and no more.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = (6 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Seconds with three digits.
pub fn seconds(value: f64) -> String {
    let digits = if value.abs() >= 100.0 { 0 } else { 2 - (value.abs().max(1e-3).log10().floor().max(-1.0) as i32) };
    format!("{value:.*}", digits.max(0) as usize)
}

/// Half-sample: the middle of the sorted values, and largest less smallest.
pub fn median_and_spread(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let spread = sorted.last().zip(sorted.first()).map_or(0.0, |(last, first)| last - first);
    (crate::image::metrics::percentile(&sorted, 0.5), spread)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use serde_json::json;

    /// A point with a time and an error.
    pub(crate) fn sample(method: &str, accuracy: f64, seconds: f64, mae: f64) -> Point {
        let settings = json!({"accuracy": accuracy, "capture": "compute"});
        let mut point = Point::new("box", (8, 6), method, settings.as_object().unwrap());
        point.set("threads", 2);
        for column in ["cpu_s", "wall_s", "indirect_cpu_s", "indirect_wall_s"] {
            point.set_number(column, seconds);
        }
        point.set_metrics(&Metrics { mae, block_mae: mae / 2.0, energy: Some(1.0), ..Metrics::default() });
        point
    }

    #[test]
    fn key_tells_settings_and_devices_apart() {
        let (a, mut b) = (sample("ward", 0.3, 1.0, 0.1), sample("ward", 0.3, 2.0, 0.2));
        assert_eq!(a.key(), b.key());
        assert_ne!(a.key(), sample("ward", 0.2, 1.0, 0.1).key());
        b.set("device", "other");
        assert_ne!(a.key(), b.key());
        // Other programs write JSON with other spaces.
        b = a.clone();
        b.set("settings", r#"{"accuracy": 0.3,   "capture": "compute"}"#);
        assert_eq!((a.key(), a.words().as_str()), (b.key(), "accuracy 0.3, capture compute"));
        assert_eq!(a.variant(), "compute");
    }

    #[test]
    fn numbers_are_short_and_exact_enough() {
        assert_eq!([0.3, 1234567.89, 1e-4, 0.0, 12.0].map(short), ["0.3", "1234568", "0.0001", "0", "12"]);
        assert_eq!(median_and_spread(&[3.0, 1.0, 2.0]), (2.0, 2.0));
        assert_eq!([0.0123, 1.234, 12.34, 1234.0].map(seconds), ["0.012", "1.23", "12.3", "1234"]);
    }
}

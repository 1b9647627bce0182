//! A trace of a run for Perfetto (<https://ui.perfetto.dev>) and `chrome://tracing` (`--trace FILE.json`).
//!
//! Google's "Trace Event Format": complete events (`X`) in microseconds on one track a queue. Events of a track must
//! not overlap other than by nesting, so each is cut where the next begins.

use crate::image::write::{WriteError, write_atomic};
use serde_json::{Value, json};
use std::path::Path;

/// A track of a trace, by [`Trace::track`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Track(usize);

/// Events on named tracks.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    tracks: Vec<(String, Vec<Span>)>,
}

#[derive(Debug, Clone)]
struct Span {
    name: String,
    start_us: f64,
    end_us: f64,
}

impl Trace {
    /// A trace without tracks.
    pub fn new() -> Self {
        Self::default()
    }

    /// The track of that name (`GPU graphics queue`, `CPU`), added below the others where there is none.
    pub fn track(&mut self, name: &str) -> Track {
        let known = self.tracks.iter().position(|(track, _)| track == name);
        Track(known.unwrap_or_else(|| {
            self.tracks.push((name.to_owned(), Vec::new()));
            self.tracks.len() - 1
        }))
    }

    /// Adds an event: begin and length in microseconds on a clock that all tracks share. Any order will do.
    pub fn span(&mut self, track: Track, name: &str, start_us: f64, length_us: f64) {
        let span = Span { name: name.to_owned(), start_us, end_us: start_us + length_us.max(0.0) };
        self.tracks[track.0].1.push(span);
    }

    /// The file's content: names of the tracks, then the events in order of time.
    pub fn to_json(&self) -> Value {
        let names = self.tracks.iter().enumerate().flat_map(|(index, (name, _))| track_names(index, name));
        let mut events: Vec<(f64, Value)> =
            self.tracks.iter().enumerate().flat_map(|(index, (_, spans))| track_events(index, spans)).collect();
        events.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let process = json!({"ph": "M", "pid": 1, "name": "process_name", "args": {"name": "hemicube"}});
        let all: Vec<Value> = std::iter::once(process).chain(names).chain(events.into_iter().map(|e| e.1)).collect();
        json!({"displayTimeUnit": "ms", "traceEvents": all})
    }

    /// Writes the file, complete or not at all.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        write_atomic(path, |sink| Ok(serde_json::to_writer(sink, &self.to_json())?))
    }
}

fn track_names(index: usize, name: &str) -> [Value; 2] {
    let event = |kind: &str, args: Value| json!({"ph": "M", "pid": 1, "tid": index + 1, "name": kind, "args": args});
    [event("thread_name", json!({"name": name})), event("thread_sort_index", json!({"sort_index": index}))]
}

/// The events of a track in order, with their begin; each ends no later than the next begins.
fn track_events(index: usize, spans: &[Span]) -> Vec<(f64, Value)> {
    let mut sorted: Vec<&Span> = spans.iter().filter(|span| (span.start_us + span.end_us).is_finite()).collect();
    sorted.sort_by(|a, b| a.start_us.total_cmp(&b.start_us));
    let event = |(place, span): (usize, &&Span)| {
        let next = sorted.get(place + 1).map_or(f64::INFINITY, |next| next.start_us);
        // Whole nanoseconds: begin plus length then never passes the next begin by a rounding error.
        let (start, end) = ((span.start_us * 1e3).round(), (span.end_us.min(next) * 1e3).round());
        let (ts, dur) = (start / 1e3, (end - start) / 1e3);
        (ts, json!({"ph": "X", "pid": 1, "tid": index + 1, "name": span.name, "ts": ts, "dur": dur}))
    };
    sorted.iter().enumerate().map(event).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Trace {
        let mut trace = Trace::new();
        let (gpu, cpu) = (trace.track("GPU graphics queue"), trace.track("CPU"));
        trace.span(cpu, "load scene", 0.0, 900.0);
        trace.span(gpu, "splat", 1200.7, 300.0);
        trace.span(gpu, "gbuffer", 1000.1, 200.6003);
        trace.span(gpu, "capture", 1100.0, 50.0);
        trace.span(cpu, "record", 900.0, 33.3);
        assert_eq!(trace.track("CPU"), cpu);
        trace
    }

    #[test]
    fn events_are_in_order_and_do_not_overlap_within_a_track() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.json");
        sample().write(&path).unwrap();
        let value: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let events: Vec<&Value> = value["traceEvents"].as_array().unwrap().iter().filter(|e| e["ph"] == "X").collect();
        assert_eq!(events.len(), 5);
        let number = |event: &Value, key: &str| event[key].as_f64().unwrap();
        assert!(events.windows(2).all(|pair| number(pair[0], "ts") <= number(pair[1], "ts")));
        for tid in [1, 2] {
            let track: Vec<&&Value> = events.iter().filter(|event| event["tid"] == tid).collect();
            for pair in track.windows(2) {
                let end = number(pair[0], "ts") + number(pair[0], "dur");
                assert!(end <= number(pair[1], "ts") + 1e-9 && number(pair[0], "dur") >= 0.0, "{pair:?}");
            }
        }
    }

    #[test]
    fn tracks_are_named() {
        let value = sample().to_json();
        let named = |tid: u64| {
            let events = value["traceEvents"].as_array().unwrap();
            let name = events.iter().find(|event| event["name"] == "thread_name" && event["tid"] == tid);
            name.unwrap()["args"]["name"].as_str().unwrap().to_owned()
        };
        assert_eq!([named(1), named(2)], ["GPU graphics queue", "CPU"]);
    }
}

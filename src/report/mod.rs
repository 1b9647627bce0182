//! What a run cost and did: times of passes, statistics, a trace, progress.

pub mod profile;
pub mod progress;
pub mod stats;
pub mod table;
pub mod trace;

//! What a run cost and did: times of passes, statistics, a trace, progress; error against time.

pub mod convergence;
pub mod csv;
pub mod limits;
pub mod profile;
pub mod progress;
pub mod solvers;
pub mod stability;
pub mod stats;
pub mod svg;
pub mod table;
pub mod trace;

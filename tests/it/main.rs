//! The integration tests, one program: the crate is linked once, and all tests share one validated device.
//!
//! A new test goes into a module here, `tests/it/TOPIC.rs`, never into a file of its own beside this folder: that would be another
//! program, which `tools/test.sh` does not run. Helpers: `crate::common`. Each module has a topic; `cargo test --release --test it MODULE::` runs one of them. No test needs a process of its own:
//! a test that changes a device's limits, or that counts the messages of a deliberate fault, opens another instance and
//! device, and nothing changes the environment or the working directory.

#![allow(clippy::unwrap_used)] // the helpers belong to tests, which the lint does not know

mod analytic;
mod bad_scenes;
mod bakes;
mod bounces;
mod capabilities;
mod captures;
mod cells;
mod cli;
mod common;
mod compare;
mod contrast;
mod convergence;
mod determinism;
mod device;
mod emitters;
mod export;
mod extents;
mod gltf_conformance;
mod hidden;
mod kept_records;
mod leaks;
mod levels;
mod light_fuzz;
mod masks;
mod memory;
mod peers;
mod probes;
mod reference;
mod references;
mod scenes;
mod shadows;
mod slices;
mod solvers;
mod stability;
mod validation;
mod views;
mod volume;
mod work;

//! The guide: how a frame is computed, sequences and files of records, irradiance volumes, limits, and measurements with their
//! commands.

#[doc = include_str!("method.md")]
pub mod method {}

#[doc = include_str!("bounces.md")]
pub mod bounces {}

#[doc = include_str!("sequences.md")]
pub mod sequences {}

#[doc = include_str!("measurements.md")]
pub mod measurements {}

#[doc = include_str!("capabilities.md")]
pub mod capabilities {}

#[doc = include_str!("volumes.md")]
pub mod volumes {}

#[doc = include_str!("limits.md")]
pub mod limits {}

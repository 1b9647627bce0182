//! Techniques: passes composed into something a user would name.

pub mod direct;
pub mod irradiance_cache;
pub mod light_samples;

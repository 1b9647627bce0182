//! Global illumination by rasterisation alone, on raw Vulkan.
//!
//! Data goes one way: file → [`scene`] → needs → plan → GPU scene → G-buffer → records ⇄ captures → accumulation →
//! [`image`] → report.

pub mod image;
pub mod math;
pub mod methods;
pub mod passes;
pub mod reference;
pub mod renderer;
pub mod report;
pub mod scene;
pub mod vk;

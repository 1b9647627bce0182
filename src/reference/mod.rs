//! The truth on the CPU: an unbiased path tracer, and the irradiance cache of 1988. Nothing here knows of the GPU.
//!
//! [`path_trace`] and [`ward()`] go from a scene to a picture. [`Tracer`] makes a scene ready for rays; [`Progressive`]
//! traces batches of paths from the surface that each pixel's centre sees; [`irradiance_at`] does so from any place. All
//! surfaces are Lambertian and two-sided; what emits reflects too; directions below a triangle's own plane carry
//! nothing, whatever its shading normal says.
//!
//! Geometry is double precision throughout: rays leave surfaces 2⁻³⁶ of the local coordinates above them, which hides no
//! detail that single-precision meshes can hold.

pub mod balls;
mod bvh;
mod cost;
mod film;
mod intersect;
mod lights;
mod path;
pub mod picture;
pub mod points;
mod progressive;
mod run;
mod sampler;
mod sky;
mod state;
mod surface;
#[cfg(test)]
mod tests;
mod tracer;
mod view;
pub mod ward;

pub use cost::{Cost, Meter, process_time};
pub use film::Estimate;
pub use path::Layers;
pub use progressive::{Progressive, Settings, batch_for, irradiance_at, open_batch};
pub use run::{Cached, Stop, path_trace, ward};
pub use state::StateError;
pub use surface::SurfacePoint;
pub use tracer::Tracer;
pub use view::{Pixel, View};

//! Pure functions: measures, gradients, bounds. No I/O, no GPU; each integrating shader has its twin here.

pub mod adjacency;
pub mod capture;
pub mod cells;
pub mod core;
pub mod density;
pub mod deringing;
pub mod form_factor;
pub mod hsh;
pub mod levels;
pub mod merge;
pub mod octahedron;
pub mod outline;
pub mod quadrature;
pub mod sampling;
pub mod sequence;
pub mod sh;
pub mod simplify;
pub mod slices;
pub mod visibility;
pub mod ward;
pub mod zone;

//! Pure functions, no I/O: what the shaders and the reference both rest on.

pub mod form_factor;
pub mod sampling;
pub mod ward;

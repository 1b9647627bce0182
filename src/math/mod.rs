//! Pure functions: measures, gradients, bounds. No I/O, no GPU; each integrating shader has its twin here.

pub mod hemicube;
pub mod sequence;

//! Light kept with the scene: irradiance at the vertices, and scenes written with it as GLB.

pub mod glb;
pub mod vertices;

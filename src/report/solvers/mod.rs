//! All bounces by each solver, in scenes where light goes on for long: products, time, residual, and the error against closed
//! forms and traced paths.
//!
//! The tests and `hemicube convergence --solvers` run the same rows.

mod cases;
mod row;
mod truth;

pub use cases::{Case, Region, cases, checkerboard, needle, sphere};
pub use row::{Row, charts, csv, markdown};

use crate::methods::light_set::LightSettings;
use crate::methods::probes::Result;
use crate::methods::surface_cache::{ALL_BOUNCES, Solver};
use crate::methods::surface_irradiance::{SurfaceIrradiance, SurfaceIrradianceSettings};
use crate::vk::Device;
use std::sync::Arc;
use truth::mean;

/// What rows are computed with.
pub const SETTINGS: SurfaceIrradianceSettings = SurfaceIrradianceSettings {
    direct: false,
    bounces: ALL_BOUNCES,
    tolerance: 1e-3,
    solver: Solver::Accelerated,
    places: None,
    capture_size: 16,
    surface_cells: 1 << 17,
    lights: LightSettings { area_samples: 64, sky_samples: 64, shadow_size: 64 },
};

/// Solves a case by one solver after the other.
///
/// # Errors
/// The device's.
pub fn run(device: &Arc<Device>, case: &Case, solvers: &[Solver]) -> Result<Vec<Row>> {
    let expected: Vec<f64> = case.regions.iter().map(|region| truth::expected(&case.scene, region)).collect();
    let row = |solver: &Solver| {
        let settings = SurfaceIrradianceSettings { solver: *solver, ..SETTINGS };
        let found = SurfaceIrradiance::new(device, &case.scene, &settings, &mut |_| {})?;
        let off =
            |(region, expected): (&Region, &f64)| (region.name, mean(&case.scene, &found, region) / expected - 1.0);
        let errors = case.regions.iter().zip(&expected).map(off).collect();
        Ok(Row { case: case.name.clone(), solver: *solver, errors, bounced: found.bounced })
    };
    solvers.iter().map(row).collect()
}

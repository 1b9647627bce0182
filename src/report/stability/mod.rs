//! The stability suite: records measured by the real passes and held against closed forms, differences and themselves.
//!
//! [`closed_forms`] are cases whose irradiance or gradient is known; [`evaluate`] measures each at three capture sizes and
//! several turns. [`GROUPS`] compare several places or scenes: differences, changes that must not change the light, extremes. The tests and
//! `hemicube convergence --stability` run the same rows.

mod area;
mod case;
mod differences;
mod invariants;
mod row;
mod sky;
mod walls;

pub use case::{Case, Known, Read, Site, evaluate};
pub use row::{Bound, Row, csv, markdown};

use crate::methods::captures::CaptureMode;
use crate::methods::light_samples::LightSettings;
use crate::methods::probes::{Place, Probe, ProbeError, ProbeSettings, Probes};
use crate::passes::integrate::Gradients;
use crate::scene::Scene;
use crate::vk::Device;
use crate::vk::pass::Recorder;
use std::f32::consts::TAU;
use std::sync::Arc;

/// Capture sizes that rows are measured at, coarse to fine: the last one is the row's own.
pub const SIZES: [u32; 3] = [16, 32, 64];
/// Turns of the hemicube about the normal that errors are averaged over.
pub const TURNS: u32 = 24;

/// What rows are measured with.
pub struct Bench {
    /// The device.
    pub device: Arc<Device>,
    /// How records look at the scene.
    pub capture: CaptureMode,
}

impl Bench {
    /// Measures `places` in `scene`; `cells` are the surfaces', `samples` those of all emissive triangles together and of
    /// the sky that lights them.
    pub fn measure(
        &self,
        scene: &Scene,
        places: &[Place],
        size: u32,
        (cells, samples): (u32, u32),
    ) -> Result<Vec<Probe>, ProbeError> {
        let settings = ProbeSettings {
            capture: self.capture,
            capture_size: size,
            gradients: Gradients { rotation: true, translation: true },
            lights: LightSettings { area_samples: samples, sky_samples: samples, shadow_size: 256 },
            surface_cells: cells,
        };
        let mut recorder = Recorder::new(&self.device);
        Probes::new(&self.device, &mut recorder, scene, &settings)?.measure(&mut recorder, places, |_| {})
    }
}

/// All rows, in order; `done` hears each group's.
pub fn run(bench: &Bench, mut done: impl FnMut(&[Row])) -> Result<Vec<Row>, ProbeError> {
    let mut rows = Vec::new();
    let mut add = |group: Vec<Row>| {
        done(&group);
        rows.extend(group);
    };
    for case in closed_forms() {
        add(evaluate(bench, &case)?);
    }
    for (_, measure) in GROUPS {
        add(measure(bench)?);
    }
    Ok(rows)
}

/// Number of groups that [`run`] reports.
pub fn group_count() -> u64 {
    (closed_forms().len() + GROUPS.len()) as u64
}

/// Every case with a closed form.
pub fn closed_forms() -> Vec<Case> {
    area::cases().into_iter().chain(walls::cases()).chain(sky::cases()).collect()
}

/// A group of rows by what it measures.
pub type Measure = fn(&Bench) -> Result<Vec<Row>, ProbeError>;

/// Rows of several places or scenes together: means, differences, changes that must not change the light, extremes.
pub const GROUPS: [(&str, Measure); 12] = [
    ("cube faces", area::cube_faces),
    ("Cornell gradients", differences::cornell_gradients),
    ("world × 2^k", invariants::world_by_powers_of_two),
    ("emission × 2^k", invariants::emission_by_powers_of_two),
    ("scale", invariants::scales),
    ("radiance 10⁶ : 1", invariants::radiance_range),
    ("near-black", invariants::near_black),
    ("thin wall", invariants::thin_wall),
    ("needles", invariants::needles),
    ("bad triangles", invariants::bad_triangles),
    ("one-texel light", invariants::small_light),
    ("slit", walls::slit_limit),
];

/// Turns spread evenly by the golden ratio, never along an axis.
pub(crate) fn turn(index: u32) -> f32 {
    TAU * (0.137 + 0.618_034 * index as f32).fract()
}

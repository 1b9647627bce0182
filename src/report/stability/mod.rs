//! The stability suite: records measured by the real passes and held against closed forms, differences and themselves.
//!
//! [`closed_forms`] are cases whose irradiance or gradient is known; [`evaluate`] measures each at three capture sizes and
//! several turns. [`GROUPS`] compare several places or scenes: differences, changes that must not change the light, extremes. The tests and
//! `hemicube convergence --stability` run the same rows.

mod area;
mod case;
mod differences;
mod exact;
mod invariants;
mod row;
mod sky;
mod walls;

pub use case::{Case, Known, Read, Site, evaluate};
pub use row::{Bound, Row, csv, markdown};

use crate::math::capture::Projection;
use crate::methods::captures::{CaptureMode, PLANE_APERTURE};
use crate::methods::light_set::LightSettings;
use crate::methods::probes::{Place, Probe, ProbeError, ProbeSettings, Probes, SurfaceCell};
use crate::passes::integrate::Gradients;
use crate::scene::{Scene, SideLimit};
use crate::vk::Device;
use crate::vk::pass::Recorder;
use std::f32::consts::TAU;
use std::sync::Arc;

/// Capture sizes that rows are measured at, coarse to fine: the last one is the row's own.
pub const SIZES: [u32; 3] = [16, 32, 64];
/// Turns of the hemicube about the normal that errors are averaged over.
pub const TURNS: u32 = 24;

/// Longest side of a triangle for hemispheres, which draw curved sides straight, as a share of the scene's diagonal.
const LONGEST_SIDE: f32 = 0.03;

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
        let mut recorder = Recorder::new(&self.device);
        let cut;
        let by_passes = self.capture.against_compute(&self.device, scene, size).is_some();
        let scene = if self.capture.projection() == Projection::Hemisphere && by_passes {
            let (low, high) = scene.bounds();
            cut = scene.tessellated(&SideLimit::even(LONGEST_SIDE * (high - low).length()));
            &cut
        } else {
            scene
        };
        let settings = self.settings(size, (cells, samples));
        Probes::new(&self.device, &mut recorder, scene, &settings)?.measure(&mut recorder, places, |_| {})
    }

    /// The lit surface that records see: every cell with its radiance.
    fn surface(&self, scene: &Scene, light: (u32, u32)) -> Result<Vec<SurfaceCell>, ProbeError> {
        let mut recorder = Recorder::new(&self.device);
        let probes = Probes::new(&self.device, &mut recorder, scene, &self.settings(SIZES[0], light))?;
        probes.surface(&mut recorder, &self.device)
    }

    fn settings(&self, size: u32, (cells, samples): (u32, u32)) -> ProbeSettings {
        ProbeSettings {
            capture: self.capture,
            capture_size: size,
            gradients: Gradients { rotation: true, translation: true },
            lights: LightSettings { area_samples: samples, sky_samples: samples, shadow_size: 256 },
            surface_cells: cells,
        }
    }
}

/// A kind of capture and the rows that concern it.
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// How records look at the scene.
    pub mode: CaptureMode,
    /// Names of its cases and groups; none: all of them.
    rows: Option<&'static [&'static str]>,
}

/// Kinds of capture: a plane's rows are those that it sees wholly, or whose radiance is the same everywhere, for what is near
/// the horizon is a guess; a hemisphere's those of scenes small enough to be cut finely.
///
/// In compute a hemisphere lacks the rows that ask more of the horizon than the disc has texels there. One at the rim is √(4/N)
/// wide, 14° at 64², and its middle's radiance counts for all of it. So the derivatives of the linear sky are of first order, off
/// by 0.2 % at 64², where a hemicube's are of second; a wedge of 175°, 5° high, has gradients 7 % off; the furthest place before
/// the wall has dE/dn 2.2 % off where 2 % are asked, and dE/dn in the Cornell box is 2.4 % off.
pub const KINDS: [Kind; 5] = [
    Kind { name: "compute", mode: CaptureMode::Compute, rows: None },
    Kind { name: "hemicube", mode: CaptureMode::Hemicube, rows: None },
    Kind {
        name: "plane",
        mode: CaptureMode::Plane { aperture: PLANE_APERTURE, compensated: true },
        rows: Some(&[
            "rectangle ahead",
            "parallel plates",
            "furnace",
            "world × 2^k",
            "emission × 2^k",
            "radiance 10⁶ : 1",
            "near-black",
            "thin wall",
            "needles",
            "bad triangles",
            "one-texel light",
        ]),
    },
    Kind {
        name: "compute-hemisphere",
        mode: CaptureMode::ComputeHemisphere,
        rows: Some(&[
            "rectangle",
            "rectangle ahead",
            "polygon",
            "parallel plates",
            "sphere light",
            "integrating sphere",
            "cube faces",
            "perpendicular wall",
            "wedge of 5°",
            "wedge of 45°",
            "wedge of 90°",
            "wedge of 135°",
            "furnace",
            "half a sky",
            "world × 2^k",
            "emission × 2^k",
            "scale",
            "far origin",
            "radiance 10⁶ : 1",
            "near-black",
            "thin wall",
            "two rooms",
            "needles",
            "bad triangles",
            "one-texel light",
            "slit",
        ]),
    },
    Kind {
        name: "hemisphere",
        mode: CaptureMode::Hemisphere,
        rows: Some(&[
            "rectangle",
            "rectangle ahead",
            "sphere light",
            "integrating sphere",
            "furnace",
            "half a sky",
            "world × 2^k",
            "emission × 2^k",
            "radiance 10⁶ : 1",
            "near-black",
            "thin wall",
            "bad triangles",
            "one-texel light",
        ]),
    },
];

impl Kind {
    /// Whether a case or group concerns it.
    pub fn covers(&self, name: &str) -> bool {
        self.rows.is_none_or(|rows| rows.contains(&name))
    }

    /// The rows that `measure` finds with it.
    pub fn rows(
        &self,
        device: &Arc<Device>,
        measure: impl Fn(&Bench) -> Result<Vec<Row>, ProbeError>,
    ) -> Result<Vec<Row>, ProbeError> {
        let mut rows = measure(&Bench { device: device.clone(), capture: self.mode })?;
        rows.iter_mut().for_each(|row| row.capture = self.name);
        Ok(rows)
    }
}

/// All rows of every kind, in order; `done` hears each group's.
pub fn run(device: &Arc<Device>, mut done: impl FnMut(&[Row])) -> Result<Vec<Row>, ProbeError> {
    let mut rows = Vec::new();
    let mut add = |group: Vec<Row>| {
        done(&group);
        rows.extend(group);
    };
    for kind in &KINDS {
        for case in closed_forms().iter().filter(|case| kind.covers(case.name)) {
            add(kind.rows(device, |bench| evaluate(bench, case))?);
        }
        for (_, measure) in GROUPS.into_iter().filter(|(name, _)| kind.covers(name)) {
            add(kind.rows(device, measure)?);
        }
    }
    Ok(rows)
}

/// Number of groups that [`run`] reports.
pub fn group_count() -> u64 {
    let names = || closed_forms().into_iter().map(|case| case.name).chain(GROUPS.into_iter().map(|(name, _)| name));
    KINDS.iter().map(|kind| names().filter(|name| kind.covers(name)).count() as u64).sum()
}

/// Every case with a closed form.
pub fn closed_forms() -> Vec<Case> {
    area::cases().into_iter().chain(walls::cases()).chain(sky::cases()).collect()
}

/// A group of rows by what it measures.
pub type Measure = fn(&Bench) -> Result<Vec<Row>, ProbeError>;

/// Rows of several places or scenes together: means, differences, changes that must not change the light, extremes.
pub const GROUPS: [(&str, Measure); 14] = [
    ("cube faces", area::cube_faces),
    ("Cornell gradients", differences::cornell_gradients),
    ("world × 2^k", invariants::world_by_powers_of_two),
    ("emission × 2^k", invariants::emission_by_powers_of_two),
    ("scale", invariants::scales),
    ("far origin", invariants::far_origin),
    ("radiance 10⁶ : 1", invariants::radiance_range),
    ("near-black", invariants::near_black),
    ("thin wall", invariants::thin_wall),
    ("two rooms", invariants::two_rooms),
    ("needles", invariants::needles),
    ("bad triangles", invariants::bad_triangles),
    ("one-texel light", invariants::small_light),
    ("slit", walls::slit_limit),
];

/// Turns spread evenly by the golden ratio, never along an axis.
pub(crate) fn turn(index: u32) -> f32 {
    TAU * (0.137 + 0.618_034 * index as f32).fract()
}

//! Cases with a closed form: a scene, sites, and what is known there.

use super::{Bench, Bound, Row, SIZES, TURNS, turn};
use crate::methods::probes::{Irradiance, Place, Probe, ProbeError};
use crate::scene::Scene;
use glam::{DVec3, Vec3};

/// What is read from a record, in its red channel.
#[derive(Clone, Copy, Debug)]
pub enum Read {
    /// Irradiance by reflection.
    E,
    /// Translation gradient of it along a direction.
    Move(DVec3),
    /// Its derivative as the normal turns towards a direction.
    Turn(DVec3),
    /// Irradiance by the sky.
    Sky,
    /// Its derivative as the normal turns towards a direction.
    SkyTurn(DVec3),
    /// Length of the sky's translation gradient.
    SkyMove,
    /// 1/R.
    InverseDistance,
}

/// A quantity that is known at a site.
#[derive(Clone, Debug)]
pub struct Known {
    /// Its name.
    pub quantity: String,
    /// How it is read.
    pub read: Read,
    /// Its value.
    pub expected: f64,
    /// What errors are relative to.
    pub scale: f64,
    /// What they may be.
    pub bound: Bound,
}

/// A place, and what is known there.
#[derive(Clone, Debug)]
pub struct Site {
    /// Where it is, in words.
    pub words: String,
    /// Position.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// What is known.
    pub known: Vec<Known>,
}

/// A scene and its sites.
pub struct Case {
    /// What it is.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// Surface cells, and samples of the sky that lights them.
    pub light: (u32, u32),
    /// Where it is looked at from.
    pub sites: Vec<Site>,
}

impl Known {
    /// `quantity` is `expected`, within `bound` relative to it.
    pub fn new(quantity: &str, read: Read, expected: f64, bound: Bound) -> Self {
        Self { quantity: quantity.into(), read, expected, scale: expected.abs(), bound }
    }

    /// The same with the error relative to `scale`.
    pub fn relative_to(self, scale: f64) -> Self {
        Self { scale, ..self }
    }
}

impl Read {
    fn of(self, probe: &Probe, normal: DVec3) -> f64 {
        let sky = probe.sky.unwrap_or_default();
        match self {
            Self::E => f64::from(probe.reflected.value.x),
            Self::Move(along) => probe.reflected.translation[0].as_dvec3().dot(along),
            Self::Turn(towards) => slope_of_turn(&probe.reflected, normal, towards),
            Self::Sky => f64::from(sky.value.x),
            Self::SkyTurn(towards) => slope_of_turn(&sky, normal, towards),
            Self::SkyMove => f64::from(sky.translation[0].length()),
            Self::InverseDistance => f64::from(probe.inverse_distance),
        }
    }
}

/// dE/dα as the normal n turns by α towards t: (n × t)·∇_r E.
pub(super) fn slope_of_turn(irradiance: &Irradiance, normal: DVec3, towards: DVec3) -> f64 {
    irradiance.rotation[0].as_dvec3().dot(normal.cross(towards))
}

/// A place at a site, turned.
pub(super) fn place(position: DVec3, normal: DVec3, turn: f32) -> Place {
    let normal: Vec3 = normal.as_vec3();
    Place { position: position.as_vec3(), normal, geometric: normal, turn }
}

/// Measures all that is known of `case`, at every size and turn.
pub fn evaluate(bench: &Bench, case: &Case) -> Result<Vec<Row>, ProbeError> {
    let places: Vec<Place> =
        case.sites.iter().flat_map(|s| (0..TURNS).map(|i| place(s.position, s.normal, turn(i)))).collect();
    let mut rows = empty_rows(case);
    for size in SIZES {
        let probes = bench.measure(&case.scene, &places, size, case.light)?;
        let mut row = rows.iter_mut();
        for (site, probes) in case.sites.iter().zip(probes.chunks(TURNS as usize)) {
            for (known, row) in site.known.iter().zip(row.by_ref()) {
                let values: Vec<f64> = probes.iter().map(|probe| known.read.of(probe, site.normal)).collect();
                let mean = |f: &dyn Fn(f64) -> f64| values.iter().map(|v| f(*v)).sum::<f64>() / values.len() as f64;
                row.got = mean(&|v| v);
                row.errors.push((size, mean(&|v| (v - known.expected).powi(2)).sqrt() / known.scale));
            }
        }
    }
    Ok(rows)
}

fn empty_rows(case: &Case) -> Vec<Row> {
    let row = |site: &Site, known: &Known| Row {
        capture: "",
        case: if site.words.is_empty() { case.name.into() } else { format!("{}, {}", case.name, site.words) },
        quantity: known.quantity.clone(),
        expected: known.expected,
        got: 0.0,
        errors: Vec::new(),
        bound: known.bound,
    };
    case.sites.iter().flat_map(|site| site.known.iter().map(|known| row(site, known))).collect()
}

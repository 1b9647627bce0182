//! The file of a volume: JSON, version 1. [`crate::guide::volumes`] describes every field.

mod error;

pub use error::VolumeError;

use super::lattice::{MOST_DIVISIONS, MOST_LEVELS, octants};
use super::tree::corners_of;
use super::{Cell, Lattice, Sample, State, Volume};
use crate::image::write::{WriteError, write_atomic};
use crate::math::{octahedron, sh};
use glam::{DVec3, UVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::Path;

const FORMAT: &str = "hemicube volume";
const VERSION: u32 = 1;

#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

#[derive(Serialize, Deserialize)]
struct File {
    format: String,
    version: u32,
    order: u32,
    bounces: String,
    bounds: [[f64; 3]; 2],
    sample_count: usize,
    positions: Vec<[f64; 3]>,
    coefficients: Vec<Vec<[f32; 3]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gradients: Option<Vec<Vec<[[f32; 3]; 3]>>>,
    back_face_share: Vec<f32>,
    harmonic_mean_distance: Vec<Option<f32>>,
    state: Vec<State>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    distance_moments: Option<Moments>,
    cells: Cells,
}

#[derive(Serialize, Deserialize)]
struct Moments {
    octahedron: usize,
    values: Vec<Vec<[f32; 2]>>,
}

#[derive(Serialize, Deserialize)]
struct Cells {
    low: [f64; 3],
    high: [f64; 3],
    divisions: [u32; 3],
    levels: u32,
    leaves: Vec<[u32; 12]>,
}

/// Writes `volume` to `path`: the whole file, or nothing.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, volume: &Volume) -> Result<(), WriteError> {
    write_atomic(path, |sink| {
        serde_json::to_writer(&mut *sink, &File::of(volume))?;
        sink.write_all(b"\n")
    })
}

/// Reads a volume.
///
/// # Errors
/// The file cannot be read, or is no volume of this version.
pub fn read(path: &Path) -> Result<Volume, VolumeError> {
    let text =
        std::fs::read_to_string(path).map_err(|cause| VolumeError::Unreadable { path: path.to_owned(), cause })?;
    parse(path, &text)
}

fn parse(path: &Path, text: &str) -> Result<Volume, VolumeError> {
    let path = path.to_owned();
    let head: Head = match serde_json::from_str(text) {
        Ok(head) => head,
        Err(cause) => return Err(VolumeError::Torn { path, cause }),
    };
    if head.format != FORMAT {
        return Err(VolumeError::Wrong { path, what: format!("its format is {:?}, not {FORMAT:?}", head.format) });
    }
    if head.version != VERSION {
        return Err(VolumeError::Version { path, version: head.version });
    }
    match serde_json::from_str::<File>(text) {
        Ok(file) => file.volume().map_err(|what| VolumeError::Wrong { path, what }),
        Err(cause) => Err(VolumeError::Torn { path, cause }),
    }
}

impl File {
    fn of(volume: &Volume) -> Self {
        let samples = &volume.samples;
        let gradients =
            |sample: &Sample| sample.gradients.iter().map(|of_axes| of_axes.map(|slope| slope.to_array())).collect();
        let lattice = &volume.lattice;
        let leaf = |cell: &Cell| {
            let mut numbers = [cell.level, cell.at.x, cell.at.y, cell.at.z, 0, 0, 0, 0, 0, 0, 0, 0];
            numbers[4..].copy_from_slice(&cell.corners);
            numbers
        };
        Self {
            format: FORMAT.into(),
            version: VERSION,
            order: volume.order,
            bounces: volume.bounces.clone(),
            bounds: volume.bounds.map(|corner| corner.to_array()),
            sample_count: samples.len(),
            positions: samples.iter().map(|sample| sample.position.to_array()).collect(),
            coefficients: samples.iter().map(|s| s.coefficients.iter().map(Vec3::to_array).collect()).collect(),
            gradients: volume.has_gradients().then(|| samples.iter().map(gradients).collect()),
            back_face_share: samples.iter().map(|sample| sample.back_share).collect(),
            harmonic_mean_distance: samples
                .iter()
                .map(|sample| (sample.inverse_distance > 0.0).then(|| 1.0 / sample.inverse_distance))
                .collect(),
            state: samples.iter().map(|sample| sample.state).collect(),
            distance_moments: volume.has_moments().then(|| Moments {
                octahedron: octahedron::SIDE,
                values: samples.iter().map(|sample| sample.moments.clone()).collect(),
            }),
            cells: Cells {
                low: lattice.low.to_array(),
                high: lattice.high.to_array(),
                divisions: lattice.divisions.to_array(),
                levels: lattice.levels,
                leaves: lattice.leaves.iter().map(leaf).collect(),
            },
        }
    }

    fn volume(self) -> Result<Volume, String> {
        self.check()?;
        let lattice = self.cells.lattice(self.sample_count)?;
        let sample = |i: usize| Sample {
            position: DVec3::from(self.positions[i]),
            coefficients: self.coefficients[i].iter().map(|rgb| Vec3::from(*rgb)).collect(),
            gradients: self
                .gradients
                .as_ref()
                .map_or_else(Vec::new, |all| all[i].iter().map(|of_axes| of_axes.map(Vec3::from)).collect()),
            back_share: self.back_face_share[i],
            inverse_distance: self.harmonic_mean_distance[i].map_or(0.0, f32::recip),
            moments: self.distance_moments.as_ref().map_or_else(Vec::new, |all| all.values[i].clone()),
            state: self.state[i],
        };
        let samples = (0..self.sample_count).map(sample).collect();
        let bounds = self.bounds.map(DVec3::from);
        if !(bounds[0].cmple(lattice.low).all() && bounds[1].cmpge(lattice.high).all()) {
            return Err("its cells reach beyond its bounds".into());
        }
        Ok(Volume { order: self.order, bounces: self.bounces, bounds, samples, lattice })
    }

    fn check(&self) -> Result<(), String> {
        if !(2..=sh::MAX_ORDER).contains(&self.order) {
            return Err(format!("its order is {}, not from 2 to {}", self.order, sh::MAX_ORDER));
        }
        let lists = [
            ("positions", self.positions.len()),
            ("coefficients", self.coefficients.len()),
            ("gradients", self.gradients.as_ref().map_or(self.sample_count, Vec::len)),
            ("back_face_share", self.back_face_share.len()),
            ("harmonic_mean_distance", self.harmonic_mean_distance.len()),
            ("state", self.state.len()),
            ("distance_moments", self.distance_moments.as_ref().map_or(self.sample_count, |m| m.values.len())),
        ];
        for (name, length) in lists {
            if length != self.sample_count {
                return Err(format!("\"{name}\" has {length} entries for {} samples", self.sample_count));
            }
        }
        let count = sh::count(self.order);
        let odd = self.coefficients.iter().map(Vec::len).chain(self.gradients.iter().flatten().map(Vec::len));
        if odd.into_iter().any(|length| length != count) {
            return Err(format!("a sample has not the {count} coefficients of order {}", self.order));
        }
        let gradients = self.gradients.iter().flatten().flatten().flatten().flatten();
        let numbers = self.coefficients.iter().flatten().flatten().chain(gradients);
        if !numbers.copied().all(f32::is_finite) || !self.positions.iter().flatten().copied().all(f64::is_finite) {
            return Err("a number is too large".into());
        }
        if let Some(moments) = &self.distance_moments
            && (moments.octahedron != octahedron::SIDE || moments.values.iter().any(|m| m.len() != octahedron::CELLS))
        {
            return Err(format!("its distance moments are not of {0} × {0} directions", octahedron::SIDE));
        }
        Ok(())
    }
}

impl Cells {
    fn lattice(&self, samples: usize) -> Result<Lattice, String> {
        let (low, high, divisions) = (DVec3::from(self.low), DVec3::from(self.high), UVec3::from(self.divisions));
        let sound = low.is_finite() && high.is_finite() && low.cmplt(high).all();
        let few = divisions.min_element() > 0 && divisions.max_element() <= MOST_DIVISIONS;
        if !sound || !few || self.levels > MOST_LEVELS {
            return Err("its cells have no sound bounds, divisions or levels".into());
        }
        let mut lattice = Lattice::new(low, high, divisions, self.levels);
        // In cells of the finest level.
        let mut filled = 0_u128;
        for (number, leaf) in self.leaves.iter().enumerate() {
            let [level, x, y, z, ..] = *leaf;
            let at = UVec3::new(x, y, z);
            if level > self.levels || !at.cmplt(divisions << level).all() {
                return Err(format!("leaf {number} lies outside of the cells"));
            }
            if let Some(sample) = leaf[4..].iter().find(|sample| **sample as usize >= samples) {
                return Err(format!("leaf {number} names sample {sample} of {samples}"));
            }
            let mut corners = [0; 8];
            corners.copy_from_slice(&leaf[4..]);
            filled += 1 << (3 * (self.levels - level));
            lattice.leaves.push(Cell { level, at, corners });
        }
        let whole: u128 = divisions.to_array().iter().map(|n| u128::from(*n) << self.levels).product();
        if filled != whole {
            return Err("its leaves do not fill its box".into());
        }
        let known = corners_of(&lattice);
        let corner = |at: UVec3| octants().into_iter().all(|o| known.contains_key(&lattice.corner(0, at + o)));
        if !lattice.cells_of(0).into_iter().all(corner) {
            return Err("a corner of its box has no sample".into());
        }
        Ok(lattice)
    }
}

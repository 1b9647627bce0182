//! Where samples are.

mod adaptive;
mod inside;

pub use adaptive::{Adaptive, LevelReport, adaptive};

use super::lattice::{Lattice, octants};
use super::{Cell, Sample, State, Volume};
use glam::{DVec3, UVec3, Vec3};
use serde::Serialize;
use std::collections::HashMap;

/// Samples at the faces of the box stand this share of a cell inside of it: its faces are often walls, in whose very plane a sample
/// would see both sides.
const INSET: f64 = 0.01;

/// What is seen in one cell of [`crate::math::octahedron`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Mean distance and mean square of it, by solid angle over its square.
    pub moments: [f32; 2],
    /// Solid angle of triangles' backs, sr.
    pub backs: f32,
    /// 1/distance of the nearest; 0 where nothing but the sky is.
    pub nearness: f32,
}

/// What is measured at a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Radiance as spherical harmonics.
    pub coefficients: Vec<Vec3>,
    /// Their gradients, or none.
    pub gradients: Vec<[Vec3; 3]>,
    /// 1/R, by solid angle.
    pub inverse_distance: f32,
    /// By direction.
    pub seen: Vec<Seen>,
}

/// Measures light at places in the scene's coordinates.
pub type Measure<'a, E> = &'a mut dyn FnMut(&[DVec3]) -> Result<Vec<Measured>, E>;

/// What all placements share.
#[derive(Clone, Debug, PartialEq)]
pub struct Common {
    /// The box.
    pub bounds: [DVec3; 2],
    /// Order of the harmonics.
    pub order: u32,
    /// Reflections of the light, for the file.
    pub bounces: String,
    /// Share of triangles' backs in the sphere from which on a place is inside of geometry.
    pub inside: f32,
    /// Whether moments of distances are kept.
    pub moments: bool,
}

/// What became of a placement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Placement {
    /// Samples in the volume.
    pub samples: usize,
    /// Places that were measured in all: samples, middles of cells, and where samples were moved to.
    pub measured: usize,
    /// Samples that were moved out of geometry.
    pub moved: usize,
    /// Samples that stay inside of geometry.
    pub inside: usize,
    /// Cells of the result.
    pub cells: usize,
    /// Of an adaptive placement, level by level.
    pub levels: Vec<LevelReport>,
    /// Cells that were cut and are whole again.
    pub culled_cells: usize,
    /// Samples that no cell needs any more.
    pub culled_samples: usize,
}

/// Samples while their places are looked for.
struct Sites<'a> {
    common: &'a Common,
    volume: Volume,
    numbers: HashMap<UVec3, u32>,
    seen: Vec<Vec<Seen>>,
    /// Measured and not in use yet.
    spare: HashMap<UVec3, Measured>,
    measured: usize,
}

impl<'a> Sites<'a> {
    fn new(common: &'a Common, divisions: UVec3, levels: u32) -> Self {
        let [low, high] = common.bounds;
        let lattice = Lattice::new(low, high, divisions, levels);
        let (order, bounces) = (common.order, common.bounces.clone());
        let volume = Volume { order, bounces, samples: Vec::new(), lattice };
        Self { common, volume, numbers: HashMap::new(), seen: Vec::new(), spare: HashMap::new(), measured: 0 }
    }

    /// Where a corner is measured.
    fn place(&self, corner: UVec3) -> DVec3 {
        let lattice = &self.volume.lattice;
        let inset = INSET * lattice.size(lattice.levels);
        lattice.place(corner).clamp(lattice.low + inset, lattice.high - inset)
    }

    /// Measures at corners, unless they are known, without making samples of them.
    fn look<E>(&mut self, corners: &[UVec3], measure: Measure<'_, E>) -> Result<(), E> {
        let mut missing: Vec<UVec3> = corners.to_vec();
        missing.retain(|corner| !self.numbers.contains_key(corner) && !self.spare.contains_key(corner));
        missing.sort_by_key(|corner| (corner.z, corner.y, corner.x));
        missing.dedup();
        let places: Vec<DVec3> = missing.iter().map(|corner| self.place(*corner)).collect();
        if !places.is_empty() {
            let measured = self.measure(&places, measure)?;
            self.spare.extend(missing.into_iter().zip(measured));
        }
        Ok(())
    }

    fn measure<E>(&mut self, places: &[DVec3], measure: Measure<'_, E>) -> Result<Vec<Measured>, E> {
        self.measured += places.len();
        measure(places)
    }

    /// Makes samples of corners; those inside of geometry are moved out of it where that is near.
    fn add<E>(&mut self, corners: &[UVec3], measure: Measure<'_, E>) -> Result<(), E> {
        self.look(corners, measure)?;
        let mut new: Vec<UVec3> = corners.to_vec();
        new.retain(|corner| !self.numbers.contains_key(corner));
        new.sort_by_key(|corner| (corner.z, corner.y, corner.x));
        new.dedup();
        let first = self.volume.samples.len();
        for corner in new {
            let measured = self.spare.remove(&corner).expect("it was measured just now");
            self.numbers.insert(corner, self.volume.samples.len() as u32);
            let place = self.place(corner);
            self.push(place, measured);
        }
        self.move_out(first, measure)
    }

    fn push(&mut self, position: DVec3, measured: Measured) {
        let sample = self.sample(position, &measured, State::Free);
        self.volume.samples.push(sample);
        self.seen.push(measured.seen);
    }

    fn sample(&self, position: DVec3, measured: &Measured, state: State) -> Sample {
        Sample {
            position,
            coefficients: measured.coefficients.clone(),
            gradients: measured.gradients.clone(),
            back_share: inside::back_share(&measured.seen),
            inverse_distance: measured.inverse_distance,
            moments: if self.common.moments { measured.seen.iter().map(|s| s.moments).collect() } else { Vec::new() },
            state,
        }
    }

    /// A cell whose corners are samples.
    fn cell(&self, level: u32, at: UVec3) -> Cell {
        let lattice = &self.volume.lattice;
        let corners = octants().map(|octant| self.numbers[&lattice.corner(level, at + octant)]);
        Cell { level, at, corners }
    }

    fn report(&self) -> Placement {
        let in_state = |state| self.volume.samples.iter().filter(|sample| sample.state == state).count();
        Placement {
            samples: self.volume.samples.len(),
            measured: self.measured,
            moved: in_state(State::Moved),
            inside: in_state(State::Inside),
            cells: self.volume.lattice.leaves.len(),
            ..Placement::default()
        }
    }
}

/// Corners of cells of a level, each once or more.
fn corners_of(lattice: &Lattice, level: u32, cells: &[UVec3]) -> Vec<UVec3> {
    cells.iter().flat_map(|at| octants().map(|octant| lattice.corner(level, *at + octant))).collect()
}

/// A uniform grid of `per_side` samples along each axis, two at least.
///
/// # Errors
/// Those of `measure`.
pub fn uniform<E>(common: &Common, per_side: u32, measure: Measure<'_, E>) -> Result<(Volume, Placement), E> {
    let mut sites = Sites::new(common, UVec3::splat(per_side - 1), 0);
    let cells = sites.volume.lattice.cells_of(0);
    sites.add(&corners_of(&sites.volume.lattice, 0, &cells), measure)?;
    sites.volume.lattice.leaves = cells.iter().map(|at| sites.cell(0, *at)).collect();
    let report = sites.report();
    Ok((sites.volume, report))
}

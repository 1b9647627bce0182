//! Placement of a volume's samples: on a uniform grid, or in an octree. Whoever calls says how light is measured at a place.

mod adaptive;
mod cull;
mod inside;
mod named;

pub use adaptive::{Adaptive, LevelReport, adaptive};

use super::lattice::{Lattice, octants};
use super::{Cell, Sample, State, Volume};
use glam::{DVec3, UVec3, Vec3};
use serde::Serialize;
use std::collections::HashMap;

/// The outermost samples stand this share of a finest cell inside of the box. Its faces are often walls: a sample in the plane of a
/// wall sees both of its sides, and right beside a wall gradients and moments of the distances hold for no distance.
const INSET: f64 = 0.1;

/// The distances that a place sees in the directions of one cell of [`crate::math::octahedron`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Mean of the distance and mean of its square, weighted by solid angle over the distance's square.
    pub moments: [f32; 2],
    /// Solid angle of backs of triangles, sr.
    pub backs: f32,
    /// 1/distance of the nearest surface; 0 where only the sky is seen.
    pub nearness: f32,
}

/// The light at a place, and the distances that it sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Radiance as spherical harmonics, W·sr⁻¹·m⁻².
    pub coefficients: Vec<Vec3>,
    /// Derivatives of each coefficient along x, y and z, per unit of length; or empty.
    pub gradients: Vec<[Vec3; 3]>,
    /// 1/R: R is the harmonic mean of the distances, by solid angle.
    pub inverse_distance: f32,
    /// The distances, [`crate::math::octahedron::CELLS`] of them.
    pub seen: Vec<Seen>,
}

/// Measures light at places in the scene's coordinates.
pub type Measure<'a, E> = &'a mut dyn FnMut(&[DVec3]) -> Result<Vec<Measured>, E>;

/// Settings of every kind of placement.
#[derive(Clone, Debug, PartialEq)]
pub struct Common {
    /// Lowest and highest corner of the box, in the scene's coordinates.
    pub bounds: [DVec3; 2],
    /// Order of the harmonics.
    pub order: u32,
    /// Number of reflections of the light, as the file states it.
    pub bounces: String,
    /// Share of the sphere from which on backs of triangles mean that a place is inside of geometry.
    pub inside: f32,
    /// Whether samples keep the moments of their distances.
    pub moments: bool,
}

/// Counts of a placement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Placement {
    /// Samples of the volume.
    pub samples: usize,
    /// Places that were measured: samples, middles of cells, and places that samples were moved to or tried at.
    pub measured: usize,
    /// Samples that were moved out of geometry.
    pub moved: usize,
    /// Samples that are inside of geometry.
    pub inside: usize,
    /// Cells of the volume.
    pub cells: usize,
    /// The levels of an octree.
    pub levels: Vec<LevelReport>,
    /// Cells of the octree that were merged into larger ones at the end.
    pub culled_cells: usize,
    /// Samples of those cells that no other cell uses.
    pub culled_samples: usize,
}

/// Samples during their placement.
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
        let rim = INSET * (high - low) / (divisions << levels).as_dvec3();
        let lattice = Lattice::new(low + rim, high - rim, divisions, levels);
        let (order, bounces) = (common.order, common.bounces.clone());
        let volume = Volume { order, bounces, bounds: common.bounds, samples: Vec::new(), lattice };
        Self { common, volume, numbers: HashMap::new(), seen: Vec::new(), spare: HashMap::new(), measured: 0 }
    }

    /// Where a corner is measured.
    fn place(&self, corner: UVec3) -> DVec3 {
        self.volume.lattice.place(corner)
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

/// A uniform grid of `counts` samples along the axes, 2 at least along each.
///
/// # Errors
/// Those of `measure`.
pub fn uniform<E>(common: &Common, counts: UVec3, measure: Measure<'_, E>) -> Result<(Volume, Placement), E> {
    let mut sites = Sites::new(common, counts - 1, 0);
    let cells = sites.volume.lattice.cells_of(0);
    sites.add(&corners_of(&sites.volume.lattice, 0, &cells), measure)?;
    sites.volume.lattice.leaves = cells.iter().map(|at| sites.cell(0, *at)).collect();
    let report = sites.report();
    Ok((sites.volume, report))
}

//! Octrees: samples where light changes (Tatarchuk and Oat 2005), and no more than the error asks for.
//!
//! Three tests name the cells in which light may change ([`super::named`]). A measurement decides: the light at the middle of each
//! named cell is compared with the interpolation from the cell's corners, and the cell is cut if the error is too large. At the end
//! cells are merged where the larger cell gives the samples of the smaller ones as well ([`super::cull`]).

use super::cull::{cull, drop_unused};
use super::named::tests;
use super::{Common, Measure, Measured, Placement, Sites, corners_of};
use crate::math::sh;
use crate::volume::cell::Interpolation;
use crate::volume::lattice::octants;
use crate::volume::reader::{ReadSettings, Reader};
use crate::volume::{Cell, Sample, State, Volume};
use glam::{DVec3, UVec3, Vec3};
use serde::Serialize;
use std::collections::HashSet;

/// Settings of an octree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adaptive {
    /// Level of the coarsest cells at first; at the end some may be merged into coarser ones.
    pub min_level: u32,
    /// Level of the finest cells.
    pub max_level: u32,
    /// Largest error of a cell before it is cut: of the irradiance interpolated at its middle, RMS over all directions, relative to
    /// the volume's mean.
    pub error: f64,
    /// A cell is named if a corner's gradient changes the irradiance across it by more than this share of the volume's mean.
    pub gradient: f64,
    /// A cell is named if its longest side is longer than this many harmonic mean distances at a corner.
    pub harmonic: f64,
}

/// Counts of the cells of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LevelReport {
    /// Level.
    pub level: u32,
    /// Cells of the level.
    pub cells: usize,
    /// Cells that the test of the gradient names.
    pub by_gradient: usize,
    /// Cells that the test of the geometry names.
    pub by_geometry: usize,
    /// Cells that the test of the harmonic mean distance names.
    pub by_harmonic_mean: usize,
    /// Cells that a test or several name: their middles were measured.
    pub measured: usize,
    /// Cells that were cut: the error at the middle is too large, or the middle is inside of geometry and a corner is not.
    pub cut: usize,
}

/// Places samples in an octree that fills the box.
///
/// # Errors
/// Those of `measure`.
pub fn adaptive<E>(common: &Common, settings: &Adaptive, measure: Measure<'_, E>) -> Result<(Volume, Placement), E> {
    let mut sites = Sites::new(common, UVec3::ONE, settings.max_level);
    let cells = sites.volume.lattice.cells_of(settings.min_level);
    sites.add(&corners_of(&sites.volume.lattice, settings.min_level, &cells), measure)?;
    sites.volume.lattice.leaves = cells.iter().map(|at| sites.cell(settings.min_level, *at)).collect();
    let mean = mean_of(&sites.volume.samples);
    let mut levels = Vec::new();
    for level in settings.min_level..settings.max_level {
        let report = refine(&mut sites, level, settings, mean, measure)?;
        levels.push(report);
        if report.cut == 0 {
            break;
        }
    }
    let before = (sites.volume.lattice.leaves.len(), sites.volume.samples.len());
    cull(&mut sites, settings.error * mean);
    drop_unused(&mut sites.volume);
    let culled_cells = before.0 - sites.volume.lattice.leaves.len();
    let culled_samples = before.1 - sites.volume.samples.len();
    let report = Placement { levels, culled_cells, culled_samples, ..sites.report() };
    Ok((sites.volume, report))
}

/// Cuts the cells of a level that need it.
fn refine<E>(
    sites: &mut Sites<'_>,
    level: u32,
    settings: &Adaptive,
    mean: f64,
    measure: Measure<'_, E>,
) -> Result<LevelReport, E> {
    let mut report = LevelReport { level, ..LevelReport::default() };
    let mut named = Vec::new();
    for cell in sites.volume.lattice.leaves.iter().filter(|cell| cell.level == level) {
        let [gradient, geometry, harmonic] = tests(sites, cell, settings, mean);
        report.cells += 1;
        report.by_gradient += usize::from(gradient);
        report.by_geometry += usize::from(geometry);
        report.by_harmonic_mean += usize::from(harmonic);
        if gradient || geometry || harmonic {
            named.push(*cell);
        }
    }
    report.measured = named.len();
    let lattice = &sites.volume.lattice;
    let middle = |cell: &Cell| lattice.corner(level + 1, 2 * cell.at + 1);
    let middles: Vec<UVec3> = named.iter().map(middle).collect();
    sites.look(&middles, measure)?;
    let cut: Vec<UVec3> = to_cut(sites, &named, &middles, settings.error * mean);
    report.cut = cut.len();
    let children: Vec<UVec3> = cut.iter().flat_map(|at| octants().map(|octant| *at * 2 + octant)).collect();
    sites.add(&corners_of(&sites.volume.lattice, level + 1, &children), measure)?;
    let cut: HashSet<UVec3> = cut.into_iter().collect();
    sites.volume.lattice.leaves.retain(|cell| cell.level != level || !cut.contains(&cell.at));
    let new: Vec<Cell> = children.iter().map(|at| sites.cell(level + 1, *at)).collect();
    sites.volume.lattice.leaves.extend(new);
    Ok(report)
}

/// The named cells with too large an error at their middle.
fn to_cut(sites: &Sites<'_>, named: &[Cell], middles: &[UVec3], allowed: f64) -> Vec<UVec3> {
    let reader = Reader::new(&sites.volume);
    let is_inside = |sample: u32| sites.volume.samples[sample as usize].state == State::Inside;
    let is_needed = |cell: &Cell, middle: &UVec3| {
        let size = sites.volume.lattice.size(cell.level);
        let place = sites.place(*middle);
        if let Some(known) = sites.numbers.get(middle) {
            let sample = &sites.volume.samples[*known as usize];
            return error_at(&reader, sites, place, (&sample.coefficients, &sample.gradients), size) > allowed;
        }
        let spare: &Measured = &sites.spare[middle];
        if super::inside::back_share(&spare.seen) > sites.common.inside {
            return !cell.corners.iter().all(|sample| is_inside(*sample));
        }
        error_at(&reader, sites, place, (&spare.coefficients, &spare.gradients), size) > allowed
    };
    named.iter().zip(middles).filter(|(cell, middle)| is_needed(cell, middle)).map(|(cell, _)| cell.at).collect()
}

/// Error of the interpolation at the middle of a cell of `size`, against the light that was measured there.
///
/// Slopes are compared too, because values may agree by symmetry alone: beside the middle a cubic's error reaches about an eighth of
/// the slope's error times the cell's side (as that of t²(1 − t)²(t − ½) does).
fn error_at(
    reader: &Reader<'_>,
    sites: &Sites<'_>,
    place: DVec3,
    (values, slopes): (&[Vec3], &[[Vec3; 3]]),
    size: DVec3,
) -> f64 {
    let settings = ReadSettings { interpolation: Interpolation::default(), guard: sites.common.moments };
    let read = |at: DVec3| reader.read(at, settings).expect("middles of cells lie in the box");
    let mut error = difference(&read(place), values);
    if slopes.is_empty() {
        return error;
    }
    for axis in 0..3 {
        let step = 1e-3 * size * DVec3::AXES[axis];
        let (less, more) = (read(place - step), read(place + step));
        let turn = |c: usize| 500.0 * (more[c] - less[c]) - size[axis] * slopes[c][axis].as_dvec3();
        error = error.max(norm((0..values.len()).map(turn)) / 8.0);
    }
    error
}

/// RMS, over all directions and the channels, of the irradiance of radiance coefficients (Ramamoorthi and Hanrahan 2001).
pub(super) fn norm(coefficients: impl Iterator<Item = DVec3>) -> f64 {
    let squares = coefficients.enumerate().map(|(i, c)| (sh::cosine_factor(i.isqrt() as u32) * c).length_squared());
    (squares.sum::<f64>() / (12.0 * std::f64::consts::PI)).sqrt()
}

/// RMS difference of the irradiance.
pub(super) fn difference(a: &[DVec3], b: &[Vec3]) -> f64 {
    norm(a.iter().zip(b).map(|(a, b)| *a - b.as_dvec3()))
}

/// Mean over the samples outside of geometry.
fn mean_of(samples: &[Sample]) -> f64 {
    let norms: Vec<f64> = samples
        .iter()
        .filter(|sample| sample.state != State::Inside)
        .map(|sample| norm(sample.coefficients.iter().map(|c| c.as_dvec3())))
        .collect();
    norms.iter().sum::<f64>() / norms.len().max(1) as f64
}

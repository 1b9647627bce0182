//! Octrees: samples where light changes (Tatarchuk and Oat 2005), and no more of them than the error asks for.
//!
//! Three tests name the cells in which light may change: a corner's gradient, geometry within the cell, and a harmonic mean distance
//! shorter than the cell. What decides is measured: light at the middle of each named cell, beside what its corners give there. In
//! the end cells that were cut and whose samples the uncut cell gives as well are made whole again.

use super::{Common, Measure, Measured, Placement, Seen, Sites, corners_of};
use crate::math::{octahedron, sh};
use crate::volume::cell::{Interpolation, cubic, trilinear};
use crate::volume::lattice::octants;
use crate::volume::reader::{ReadSettings, Reader};
use crate::volume::{Cell, Sample, State, Volume};
use glam::{DVec3, UVec3, Vec3};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap, HashSet};

/// An adaptive placement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adaptive {
    /// All cells are cut to this level first.
    pub min_level: u32,
    /// Finest level.
    pub max_level: u32,
    /// Error that a cell is cut for: of the irradiance at its middle, RMS over all directions, relative to the volume's mean.
    pub error: f64,
    /// Change of the mean radiance over a cell by a corner's gradient, relative to the volume's mean, that names it.
    pub gradient: f64,
    /// A cell is named whose longest side is longer than this times the harmonic mean distance at a corner.
    pub harmonic: f64,
}

/// What the tests said of a level's cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LevelReport {
    /// Level.
    pub level: u32,
    /// Cells that were looked at.
    pub cells: usize,
    /// Cells that a corner's gradient names.
    pub by_gradient: usize,
    /// Cells that corners see geometry in.
    pub by_geometry: usize,
    /// Cells that the harmonic mean distance names.
    pub by_harmonic_mean: usize,
    /// Cells whose middle was measured: all that were named.
    pub measured: usize,
    /// Cells that were cut: the error at their middle is too large, or the middle is inside of geometry and a corner is not.
    pub cut: usize,
}

/// Places samples in the octree of the box.
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

/// Of the named cells those whose middle shows too large an error.
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

/// Error of the interpolation at a cell's middle, of `size`, beside what was measured there.
///
/// Where values agree by symmetry, slopes do not: a cubic's error grows to about an eighth of the slope's error times the cell's
/// side beside the middle (that of t²(1 − t)²(t − ½) does).
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

/// By the gradient, by geometry, by the harmonic mean distance.
fn tests(sites: &Sites<'_>, cell: &Cell, settings: &Adaptive, mean: f64) -> [bool; 3] {
    let size = sites.volume.lattice.size(cell.level);
    let corners = octants().into_iter().zip(cell.corners);
    let mut found = [false; 3];
    for (octant, number) in corners {
        let sample = &sites.volume.samples[number as usize];
        if sample.state == State::Inside {
            continue;
        }
        found[0] |= change_over(sample, size) > settings.gradient * mean;
        let inward = DVec3::ONE - 2.0 * octant.as_dvec3();
        found[1] |= sees_geometry(&sites.seen[number as usize], inward, size);
        found[2] |= size.max_element() * f64::from(sample.inverse_distance) > settings.harmonic;
    }
    found
}

/// Change of the irradiance's mean over all directions along a cell's sides, by the gradient.
fn change_over(sample: &Sample, size: DVec3) -> f64 {
    let Some(slopes) = sample.gradients.first() else { return 0.0 };
    let along = DVec3::from(slopes.map(|slope| slope.as_dvec3().length()));
    sh::cosine_factor(0) * (along * size).length() / (12.0 * std::f64::consts::PI).sqrt()
}

/// Whether something is nearer than the opposite faces of a cell, seen from a corner; `inward` holds the signs of the way in.
fn sees_geometry(seen: &[Seen], inward: DVec3, size: DVec3) -> bool {
    let hit = |(cell, seen): (usize, &Seen)| {
        let way = octahedron::middle(cell);
        if (way * inward).cmple(DVec3::ZERO).any() {
            return false;
        }
        let leaves = (size / way.abs()).min_element();
        f64::from(seen.nearness) * leaves > 1.0
    };
    seen.iter().enumerate().any(hit)
}

/// RMS, over all directions and the channels, of the irradiance of radiance coefficients (Ramamoorthi and Hanrahan 2001).
fn norm(coefficients: impl Iterator<Item = DVec3>) -> f64 {
    let squares = coefficients.enumerate().map(|(i, c)| (sh::cosine_factor(i.isqrt() as u32) * c).length_squared());
    (squares.sum::<f64>() / (12.0 * std::f64::consts::PI)).sqrt()
}

/// RMS difference of the irradiance.
fn difference(a: &[DVec3], b: &[Vec3]) -> f64 {
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

/// Makes cut cells whole again, from the finest level up, where the whole cell gives all its samples to within `allowed`.
fn cull(sites: &mut Sites<'_>, allowed: f64) {
    for level in (1..=sites.volume.lattice.levels).rev() {
        let mut families: BTreeMap<(u32, u32, u32), Vec<Cell>> = BTreeMap::new();
        for cell in sites.volume.lattice.leaves.iter().filter(|cell| cell.level == level) {
            let parent = cell.at / 2;
            families.entry((parent.z, parent.y, parent.x)).or_default().push(*cell);
        }
        let whole: Vec<Cell> = families
            .into_iter()
            .filter(|(_, children)| children.len() == 8)
            .map(|((z, y, x), children)| (sites.cell(level - 1, UVec3::new(x, y, z)), children))
            .filter(|(parent, children)| is_redundant(sites, parent, children, allowed))
            .map(|(parent, _)| parent)
            .collect();
        let gone: HashSet<UVec3> = whole.iter().map(|cell| cell.at).collect();
        let leaves = &mut sites.volume.lattice.leaves;
        leaves.retain(|cell| cell.level != level || !gone.contains(&(cell.at / 2)));
        leaves.extend(whole);
    }
}

/// Whether the corners of `parent` give what the other corners of its `children` hold.
fn is_redundant(sites: &Sites<'_>, parent: &Cell, children: &[Cell], allowed: f64) -> bool {
    let samples = &sites.volume.samples;
    let of = |number: u32| &samples[number as usize];
    let is_inside = |number: &u32| of(*number).state == State::Inside;
    let all = children.iter().flat_map(|child| child.corners);
    let mut others: Vec<u32> = all.filter(|number| !parent.corners.contains(number)).collect();
    others.sort_unstable();
    others.dedup();
    if parent.corners.iter().any(is_inside) {
        return parent.corners.iter().chain(&others).all(is_inside);
    }
    let lattice = &sites.volume.lattice;
    let (size, low) = (lattice.size(parent.level), lattice.place(lattice.corner(parent.level, parent.at)));
    let fits = |number: &u32| {
        let sample = of(*number);
        let t = ((sample.position - low) / size).clamp(DVec3::ZERO, DVec3::ONE);
        sample.state != State::Inside
            && difference(&by_corners(parent.corners.map(of), t, size), &sample.coefficients) <= allowed
    };
    others.iter().all(fits)
}

/// What a cell's corners give, cubic where they have gradients.
fn by_corners(corners: [&Sample; 8], t: DVec3, size: DVec3) -> Vec<DVec3> {
    let (linear, weights) = (trilinear(t), cubic(t, size));
    let value = |c: usize| {
        let of = |i: usize| {
            let value = corners[i].coefficients[c].as_dvec3();
            let Some(slopes) = corners[i].gradients.get(c) else { return linear[i] * value };
            let slope = |axis: usize| weights[i].gradient[axis] * slopes[axis].as_dvec3();
            weights[i].value * value + slope(0) + slope(1) + slope(2)
        };
        (0..8).map(of).sum()
    };
    (0..corners[0].coefficients.len()).map(value).collect()
}

/// Leaves out samples that no cell has as a corner.
fn drop_unused(volume: &mut Volume) {
    let mut used = vec![false; volume.samples.len()];
    volume.lattice.leaves.iter().flat_map(|cell| cell.corners).for_each(|number| used[number as usize] = true);
    let new: HashMap<u32, u32> = (0..).zip(&used).filter(|(_, used)| **used).map(|(old, _)| old).zip(0..).collect();
    let mut kept = used.iter();
    volume.samples.retain(|_| *kept.next().expect("one flag a sample"));
    for cell in &mut volume.lattice.leaves {
        cell.corners = cell.corners.map(|old| new[&old]);
    }
}

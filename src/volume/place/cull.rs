//! Merging of an octree's cells that turned out to be finer than the error asks for.

use super::Sites;
use super::adaptive::difference;
use crate::volume::cell::{cubic, trilinear};
use crate::volume::{Cell, Sample, State, Volume};
use glam::{DVec3, UVec3};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Merges cells, from the finest level up, where the larger cell gives the samples of the smaller ones to within `allowed`, W·m⁻².
pub fn cull(sites: &mut Sites<'_>, allowed: f64) {
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

/// Whether the corners of `parent` give the light of all other corners of its `children`.
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

/// The coefficients at a place of a cell by its corners, cubic where they have gradients.
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

/// Removes the samples that are no cell's corner.
pub fn drop_unused(volume: &mut Volume) {
    let mut used = vec![false; volume.samples.len()];
    volume.lattice.leaves.iter().flat_map(|cell| cell.corners).for_each(|number| used[number as usize] = true);
    let new: HashMap<u32, u32> = (0..).zip(&used).filter(|(_, used)| **used).map(|(old, _)| old).zip(0..).collect();
    let mut kept = used.iter();
    volume.samples.retain(|_| *kept.next().expect("one flag a sample"));
    for cell in &mut volume.lattice.leaves {
        cell.corners = cell.corners.map(|old| new[&old]);
    }
}

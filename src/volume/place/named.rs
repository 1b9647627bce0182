//! The three tests by which a cell of an octree is named, so that its error is measured (Tatarchuk and Oat 2005).

use super::{Adaptive, Seen, Sites};
use crate::math::{octahedron, sh};
use crate::volume::lattice::octants;
use crate::volume::{Cell, Sample, State};
use glam::DVec3;

/// The three tests of a cell: by the gradient, by geometry, by the harmonic mean distance. Samples inside of geometry say nothing.
pub fn tests(sites: &Sites<'_>, cell: &Cell, settings: &Adaptive, mean: f64) -> [bool; 3] {
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

/// Change of the mean irradiance of all directions along a cell's sides, by a corner's gradient.
fn change_over(sample: &Sample, size: DVec3) -> f64 {
    let Some(slopes) = sample.gradients.first() else { return 0.0 };
    let along = DVec3::from(slopes.map(|slope| slope.as_dvec3().length()));
    sh::cosine_factor(0) * (along * size).length() / (12.0 * std::f64::consts::PI).sqrt()
}

/// Whether a corner sees a surface that is nearer than the opposite faces of the cell; `inward` holds the signs of the directions into
/// the cell.
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

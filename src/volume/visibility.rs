//! The leak guard: the share of a sample's light that reaches a point, by the moments of the sample's distances.
//!
//! The moments are weighted by 1/d²: where a cell of directions sees a near wall and past its edge, the wall decides. Some light still
//! passes: cells of 25° cannot tell the two sides of a wall apart a few centimetres from a room's edges. `tests/it/volume.rs` measures
//! it.

use super::{Sample, State};
use crate::math::octahedron;
use glam::DVec3;

/// Weight of a sample behind a wall: small, but above 0, so that a point which sees no sample still has light.
pub const HIDDEN: f64 = 1e-9;
/// Weight of a sample inside of geometry.
const INSIDE: f64 = 1e-14;
/// Weights below this are pressed towards 0, as Majercik et al. (2019) do.
const CRUSH: f64 = 0.2;

/// Weight of `sample` at `point`, above 0 and at most 1; without `guard` it depends on the sample's state alone.
///
/// At most the share σ²/(σ² + (d − m)²) of the distances in the point's direction reaches as far as the point's distance d, by their mean m
/// and variance σ² (Chebyshev's one-sided inequality; Donnelly and Lauritzen 2006). The bound is loose, so its third power is used.
/// The weight is the geometric mean over the cells of directions around the point's direction: one of them may see past the wall's
/// horizon, and an arithmetic mean would let its light through.
pub fn weight(sample: &Sample, point: DVec3, guard: bool) -> f64 {
    if sample.state == State::Inside {
        return INSIDE;
    }
    let offset = point - sample.position;
    let distance = offset.length();
    if !guard || sample.moments.is_empty() || distance == 0.0 {
        return 1.0;
    }
    let log = |(cell, share): (usize, f64)| {
        let moments = sample.moments[cell].map(f64::from);
        share * reaching(distance, moments).max(HIDDEN).ln()
    };
    octahedron::around(offset).into_iter().map(log).sum::<f64>().exp()
}

/// Bound of the share of the distances with these moments that reaches as far as `distance`, sharpened.
fn reaching(distance: f64, [mean, square]: [f64; 2]) -> f64 {
    if distance <= mean {
        return 1.0;
    }
    let variance = (square - mean * mean).max(1e-6 * mean * mean);
    let share = variance / (variance + (distance - mean).powi(2));
    let weight = share.powi(3);
    if weight < CRUSH { weight.powi(3) / (CRUSH * CRUSH) } else { weight }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::octahedron::CELLS;

    #[test]
    fn what_is_behind_a_wall_is_hidden() {
        let sample = Sample { moments: vec![[1.0, 1.01]; CELLS], ..Sample::default() };
        assert_eq!(weight(&sample, DVec3::ZERO, true), 1.0);
        assert_eq!(weight(&sample, DVec3::X * 0.99, true), 1.0);
        assert!(weight(&sample, DVec3::X * 1.5, true) < 1e-3);
        assert_eq!(weight(&sample, DVec3::X * 1.5, false), 1.0);
        let inside = Sample { state: State::Inside, ..sample };
        assert!(weight(&inside, DVec3::X * 0.5, false) < 1e-9);
    }

    #[test]
    fn it_fades_without_a_jump() {
        let at = |d: f64| reaching(d, [1.0, 1.04]);
        for i in 0..2000 {
            let d = 0.5 + f64::from(i) * 1e-3;
            assert!(at(d) >= at(d + 1e-3) && at(d) - at(d + 1e-3) < 0.02, "{d}: {} {}", at(d), at(d + 1e-3));
        }
    }
}

//! The leak guard: how much of a sample a point sees, by the moments of the sample's distances.

use super::{Sample, State};
use crate::math::octahedron;
use glam::DVec3;

/// Weight of a sample that a wall hides: enough that a point which sees none has light at all, and no more.
pub const HIDDEN: f64 = 1e-9;
/// The same of a sample inside of geometry.
const INSIDE: f64 = 1e-14;
/// Weights below this are pressed towards 0 (Majercik et al. 2019 do so to what is left of hidden probes).
const CRUSH: f64 = 0.2;

/// The moments are weighted by 1/d²: in a cell of directions that sees a near wall and past its edge, the wall counts. What is left
/// of a light behind a wall is little in the mean, and up to most of it at single points a few centimetres from a room's edges, where
/// cells of 25° cannot tell the two sides of a wall apart.
///
/// Weight of `sample` at `point`, above 0 and at most 1; without `guard` by its state alone.
///
/// The share of the distances in the point's direction that reach as far as the point is at most σ²/(σ² + (d − m)²), by their
/// mean m and variance σ² (Chebyshev's inequality, one-sided; Donnelly and Lauritzen 2006). Its third power makes up for the
/// bound's being loose. Of the cells of directions around the point's the weights' geometric mean is taken: beside one that a wall
/// fills another one sees past the wall's horizon, far away, and would open it where moments are mixed.
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

/// How much of the distances with these moments reaches as far as `distance`.
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

//! Samples inside of geometry: the backs of triangles that they see give them away. They are moved out, or marked.

use super::{Measure, Seen, Sites};
use crate::math::octahedron;
use crate::volume::State;
use glam::DVec3;
use std::f32::consts::PI;

/// A sample moves by this share of its cell at most, so that its neighbours stay the same (RTXGI moves probes by 45 %).
const REACH: f64 = 0.45;
/// Number of ways out that are tried.
const WAYS: usize = 4;

/// Share of the sphere that backs of triangles fill.
pub fn back_share(seen: &[Seen]) -> f32 {
    (seen.iter().map(|cell| cell.backs).sum::<f32>() / (4.0 * PI)).min(1.0)
}

/// Places just behind the nearest backs of triangles, nearest first, no farther than `reach`.
fn ways_out(from: DVec3, seen: &[Seen], reach: f64) -> Vec<DVec3> {
    let mut ways: Vec<(f64, usize)> = (0..seen.len())
        .filter(|cell| seen[*cell].backs > 0.0 && seen[*cell].nearness > 0.0)
        .map(|cell| (1.1 / f64::from(seen[cell].nearness) + 0.05 * reach, cell))
        .filter(|(distance, _)| *distance <= reach)
        .collect();
    ways.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<(f64, DVec3)> = Vec::new();
    for (distance, cell) in ways {
        let way = octahedron::middle(cell);
        // Ways that differ, not cells side by side.
        if chosen.len() < WAYS && chosen.iter().all(|(_, known)| known.dot(way) < 0.5) {
            chosen.push((distance, way));
        }
    }
    chosen.into_iter().map(|(distance, way)| from + distance * way).collect()
}

impl Sites<'_> {
    /// Moves the samples from `first` on that are inside of geometry, or marks them.
    pub(super) fn move_out<E>(&mut self, first: usize, measure: Measure<'_, E>) -> Result<(), E> {
        let limit = self.common.inside;
        let lattice = &self.volume.lattice;
        let reach = REACH * lattice.size(lattice.levels).min_element();
        let mut tries: Vec<(usize, DVec3)> = Vec::new();
        for number in first..self.volume.samples.len() {
            let sample = &mut self.volume.samples[number];
            if sample.back_share > limit {
                sample.state = State::Inside;
                tries.extend(ways_out(sample.position, &self.seen[number], reach).into_iter().map(|at| (number, at)));
            }
        }
        let [low, high] = self.common.bounds;
        tries.retain(|(_, at)| at.cmpge(low).all() && at.cmple(high).all());
        if tries.is_empty() {
            return Ok(());
        }
        let places: Vec<DVec3> = tries.iter().map(|(_, at)| *at).collect();
        for ((number, at), measured) in tries.into_iter().zip(self.measure(&places, measure)?) {
            let waits = self.volume.samples[number].state == State::Inside;
            if waits && back_share(&measured.seen) <= limit {
                self.volume.samples[number] = self.sample(at, &measured, State::Moved);
                self.seen[number] = measured.seen;
            }
        }
        Ok(())
    }
}

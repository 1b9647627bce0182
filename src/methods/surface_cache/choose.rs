//! Chooses places in rounds: first for the sides of patches that are lit directly, then for what these places see, and so on, until
//! all that light can reach is covered. What no place sees stays black, and costs nothing.

use super::interpolate::{COVERED, Interpolator};
use super::numbers::{NOTHING, Numbers};
use super::places::Places;
use super::sides::{Point, Sides};
use crate::methods::Ground;
use crate::vk::Result;
use crate::vk::pass::Recorder;
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Largest reach of a place relative to the distance between places.
const OVERLAP: f32 = 1.6;
/// Sides that are looked at in a row.
const CHUNK: usize = 512;

/// What the choice goes by.
pub(super) struct Choice<'a> {
    pub(super) ground: &'a Ground<'a>,
    pub(super) sides: &'a Sides<'a>,
    /// Distance between places.
    pub(super) distance: f32,
    /// Places altogether, at most.
    pub(super) most: usize,
}

/// What was chosen.
pub(super) struct Chosen {
    pub(super) places: Places,
    /// Rounds of captures.
    pub(super) rounds: u32,
    /// Whether more places would have been needed than there may be.
    pub(super) is_cut: bool,
}

impl Choice<'_> {
    /// Chooses and captures places for the sides in `wanted` and all that they light.
    pub(super) fn run(&self, numbers: &Numbers, recorder: &mut Recorder, mut wanted: Vec<u32>) -> Result<Chosen> {
        let places = Places::new(&numbers.table(), OVERLAP * self.distance);
        let mut chosen = Chosen { places, rounds: 0, is_cut: false };
        let mut known = vec![false; self.sides.count()];
        wanted.iter().for_each(|side| known[*side as usize] = true);
        loop {
            let mut picked = self.pick(&self.uncovered(&chosen.places, &wanted));
            let room = self.most - chosen.places.all.len();
            chosen.is_cut |= picked.len() > room;
            picked.truncate(room);
            if picked.is_empty() {
                return Ok(chosen);
            }
            let first = chosen.places.all.len();
            self.capture(numbers, recorder, &mut chosen.places, &picked)?;
            chosen.rounds += 1;
            // A side that its group's place does not cover has what is near.
            wanted.clear();
            for place in first..chosen.places.all.len() {
                for cell_side in chosen.places.seen_by(place).iter().filter(|side| **side != NOTHING) {
                    let side = self.sides.of_cell(*cell_side);
                    if !known[side as usize] && !self.sides.is_black(side) {
                        known[side as usize] = true;
                        wanted.push(side);
                    }
                }
            }
            wanted.par_sort_unstable();
        }
    }

    fn uncovered(&self, places: &Places, wanted: &[u32]) -> Vec<u32> {
        let bare = |chunk: &[u32]| {
            let mut interpolator = Interpolator::new(places, self.sides);
            chunk.iter().filter(|side| interpolator.find(**side) < COVERED).copied().collect::<Vec<_>>()
        };
        wanted.par_chunks(CHUNK).map(bare).collect::<Vec<_>>().concat()
    }

    /// One side of each group that lies in a voxel and faces the same way, next to the group's middle.
    fn pick(&self, wanted: &[u32]) -> Vec<u32> {
        let mut keyed: Vec<_> = wanted.par_iter().map(|side| (self.key(*side), *side)).collect();
        keyed.par_sort_unstable();
        let nearest_to_middle = |group: &[(u64, u32)]| {
            let position = |(_, side): &(u64, u32)| self.sides.point(*side).position;
            let middle = group.iter().map(position).sum::<Vec3>() / group.len() as f32;
            let off = |entry: &(u64, u32)| position(entry).distance_squared(middle);
            group.iter().min_by(|a, b| off(a).total_cmp(&off(b))).map(|(_, side)| *side)
        };
        let groups: Vec<_> = keyed.chunk_by(|a, b| a.0 == b.0).collect();
        groups.into_par_iter().filter_map(nearest_to_middle).collect()
    }

    /// Voxel and the axis that a side faces.
    fn key(&self, side: u32) -> u64 {
        let Point { position, normal, .. } = self.sides.point(side);
        let voxel = ((position - self.ground.geometry.bounds[0]) / self.distance).floor().as_ivec3();
        let axis = normal.abs().max_position();
        let way = 2 * axis as u64 + u64::from(normal[axis] < 0.0);
        let bits = |v: i32| v.clamp(0, (1 << 20) - 1) as u64;
        let IVec3 { x, y, z } = voxel;
        way << 60 | bits(z) << 40 | bits(y) << 20 | bits(x)
    }

    fn capture(&self, numbers: &Numbers, recorder: &mut Recorder, places: &mut Places, picked: &[u32]) -> Result<()> {
        let first = places.all.len();
        let points: Vec<_> = picked.iter().map(|side| self.sides.point(*side)).collect();
        let frames: Vec<_> =
            (first..).zip(&points).map(|(number, p)| places.frame(p, number, self.ground.geometry)).collect();
        let mut next = points.iter().zip(&frames);
        numbers.capture(recorder, self.ground, &frames, |seen| {
            if let Some((point, frame)) = next.next() {
                places.add(*point, frame, &seen, self.sides);
            }
        })
    }
}

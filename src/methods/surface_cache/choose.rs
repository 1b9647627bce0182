//! Chooses places in rounds, from coarse to fine: first for the sides of cells that are lit directly, then for what these places
//! see, and so on, until all that light can reach is covered. What no place sees stays black, and costs nothing.

use super::interpolate::Interpolator;
use super::numbers::{NOTHING, Numbers};
use super::places::Places;
use super::sides::{Point, Sides};
use crate::methods::Ground;
use crate::vk::Result;
use crate::vk::pass::Recorder;
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Sum of weights from which a cell counts as covered.
const COVERED: f32 = 0.3;
/// How often the distance of places is halved for cells that others do not cover.
const FINEST: u8 = 3;
/// Reach of a place relative to the distance between places.
const OVERLAP: f32 = 1.6;
/// Cells that are looked at in a row.
const CHUNK: usize = 2048;

/// A side that needs a place near it, and how fine the places are that are tried next.
type Wanted = (u32, u8);

/// What the choice goes by.
pub(super) struct Choice<'a> {
    pub(super) ground: &'a Ground<'a>,
    pub(super) sides: &'a Sides<'a>,
    /// Distance between places at first.
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
    /// Chooses and captures places for the sides in `lit` and all that they light.
    pub(super) fn run(&self, numbers: &Numbers, recorder: &mut Recorder, lit: Vec<u32>) -> Result<Chosen> {
        let places = Places::new(&numbers.table(), OVERLAP * self.distance);
        let mut chosen = Chosen { places, rounds: 0, is_cut: false };
        let mut known = vec![false; self.sides.count()];
        lit.iter().for_each(|side| known[*side as usize] = true);
        let mut wanted: Vec<Wanted> = lit.into_iter().map(|side| (side, 0)).collect();
        loop {
            wanted = self.uncovered(&chosen.places, &wanted);
            let mut picked = self.pick(&wanted);
            let room = self.most - chosen.places.all.len();
            chosen.is_cut |= picked.len() > room;
            picked.truncate(room);
            if picked.is_empty() {
                return Ok(chosen);
            }
            let first = chosen.places.all.len();
            eprintln!("round {}: wanted {} picked {:?}", chosen.rounds, wanted.len(), (0..4).map(|l| picked.iter().filter(|p| p.1 == l).count()).collect::<Vec<_>>());
            self.capture(numbers, recorder, &mut chosen.places, &picked)?;
            chosen.rounds += 1;
            // Where the finest places do not help either, there is no surface to speak of.
            wanted = wanted.into_iter().filter(|(_, level)| f32::from(*level) < super::places::knob("K_FINEST", f32::from(FINEST))).map(|(s, l)| (s, l + 1)).collect();
            for place in first..chosen.places.all.len() {
                for cell_side in chosen.places.seen_by(place).iter().filter(|side| **side != NOTHING) {
                    let side = self.sides.of_cell(*cell_side);
                    if !known[side as usize] && !self.sides.is_black(side) {
                        known[side as usize] = true;
                        wanted.push((side, 0));
                    }
                }
            }
            wanted.par_sort_unstable();
        }
    }

    fn uncovered(&self, places: &Places, wanted: &[Wanted]) -> Vec<Wanted> {
        let covered = super::places::knob("K_COV", COVERED);
        let bare = |chunk: &[Wanted]| {
            let mut interpolator = Interpolator::new(places, self.sides);
            let is_bare = |(side, _): &&Wanted| interpolator.find(*side) < covered;
            chunk.iter().filter(is_bare).copied().collect::<Vec<_>>()
        };
        wanted.par_chunks(CHUNK).map(bare).collect::<Vec<_>>().concat()
    }

    /// One side of each group that lies in a voxel and faces the same way, next to the group's middle; with its level.
    fn pick(&self, wanted: &[Wanted]) -> Vec<Wanted> {
        let with_key = |(side, level): &Wanted| (self.key(*side, *level), *side, *level);
        let mut keyed: Vec<_> = wanted.par_iter().map(with_key).collect();
        keyed.par_sort_unstable();
        let nearest_to_middle = |group: &[(u64, u32, u8)]| {
            let position = |(_, side, _): &(u64, u32, u8)| self.sides.point(*side).position;
            let middle = group.iter().map(position).sum::<Vec3>() / group.len() as f32;
            let off = |entry: &(u64, u32, u8)| position(entry).distance_squared(middle);
            let nearest = group.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.map(|(_, side, level)| (*side, *level))
        };
        let groups: Vec<_> = keyed.chunk_by(|a, b| a.0 == b.0).collect();
        groups.into_par_iter().filter_map(nearest_to_middle).collect()
    }

    /// Level, voxel and the axis that a side faces.
    fn key(&self, side: u32, level: u8) -> u64 {
        let Point { position, normal, .. } = self.sides.point(side);
        let voxel = ((position - self.ground.geometry.bounds[0]) / self.reach(level) * OVERLAP).floor().as_ivec3();
        let axis = normal.abs().max_position();
        let way = 2 * axis as u64 + u64::from(normal[axis] < 0.0);
        let bits = |v: i32| v.clamp(0, (1 << 18) - 1) as u64;
        let IVec3 { x, y, z } = voxel;
        u64::from(level) << 58 | way << 54 | bits(z) << 36 | bits(y) << 18 | bits(x)
    }

    /// How far places of a level reach at most.
    fn reach(&self, level: u8) -> f32 {
        OVERLAP * self.distance / f32::from(1_u16 << level)
    }

    fn capture(
        &self,
        numbers: &Numbers,
        recorder: &mut Recorder,
        places: &mut Places,
        picked: &[Wanted],
    ) -> Result<()> {
        let first = places.all.len();
        let points: Vec<_> = picked.iter().map(|(side, level)| (self.sides.point(*side), self.reach(*level))).collect();
        let radius = self.ground.geometry.radius;
        let frames: Vec<_> = (first..).zip(&points).map(|(number, (p, _))| places.frame(p, number, radius)).collect();
        let mut next = points.iter().zip(&frames);
        numbers.capture(recorder, self.ground, &frames, |seen| {
            if let Some(((point, most), frame)) = next.next() {
                places.add(*point, frame, &seen, self.sides, *most);
            }
        })
    }
}

//! What places receive of each other's irradiance, by what they see.

use super::choose::Chosen;
use super::interpolate::{Interpolator, Weight};
use super::numbers::NOTHING;
use super::sides::Sides;
use super::system::{Entry, System};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

impl System {
    /// The matrix of all places, each by what it sees.
    pub(super) fn of_places(reflected: &Reflected, sides: &Sides<'_>, chosen: &Chosen) -> Self {
        let count = chosen.places.all.len();
        let scratch = || (vec![Vec3::ZERO; count], Vec::new());
        let rows: Vec<_> = (0..count)
            .into_par_iter()
            .with_min_len(16)
            .map_init(scratch, |(sums, touched), place| row((reflected, sides), chosen, place, sums, touched))
            .collect();
        Self::new(&rows)
    }
}

/// Row of the matrix K. `sums` holds zeros for all places, before and after.
fn row(
    (reflected, sides): (&Reflected, &Sides<'_>),
    chosen: &Chosen,
    place: usize,
    sums: &mut [Vec3],
    touched: &mut Vec<u32>,
) -> Vec<Entry> {
    for (side, weight) in chosen.places.seen_by(place).iter().zip(&chosen.places.weights) {
        let seen = (*side != NOTHING).then(|| reflected.of(sides.of_cell(*side))).flatten();
        let Some((albedo, places)) = seen else { continue };
        for Weight { place, value, .. } in places {
            let sum = &mut sums[*place as usize];
            if *sum == Vec3::ZERO {
                touched.push(*place);
            }
            *sum += albedo * (weight * value / PI);
        }
    }
    touched.sort_unstable();
    touched.dedup();
    let entry = |place: u32| Entry { place, factor: std::mem::take(&mut sums[place as usize]) };
    touched.drain(..).map(entry).collect()
}

/// What each side that some place sees reflects: its albedo, and the places whose irradiance it has, with their shares.
pub(super) struct Reflected {
    /// Of each side, its number among those that are seen.
    number: Vec<u32>,
    albedo: Vec<Vec3>,
    ends: Vec<usize>,
    shares: Vec<Weight>,
}

impl Reflected {
    pub(super) fn new(sides: &Sides<'_>, chosen: &Chosen) -> Self {
        let mut number = vec![NOTHING; sides.count()];
        let seen = chosen.places.seen.iter().filter(|side| **side != NOTHING);
        seen.for_each(|side| number[sides.of_cell(*side) as usize] = 0);
        let seen: Vec<u32> = (0..).zip(&number).filter(|(_, n)| **n == 0).map(|(side, _)| side).collect();
        (0..).zip(&seen).for_each(|(n, side)| number[*side as usize] = n);
        let of_chunk = |chunk: &[u32]| {
            let mut interpolator = Interpolator::new(&chosen.places, sides);
            let (mut ends, mut shares) = (Vec::with_capacity(chunk.len()), Vec::new());
            for side in chunk {
                interpolator.find(*side);
                shares.extend_from_slice(&interpolator.weights);
                ends.push(shares.len());
            }
            (ends, shares)
        };
        let chunks: Vec<_> = seen.par_chunks(1024).map(of_chunk).collect();
        let mut ends = Vec::with_capacity(seen.len());
        let mut shares = Vec::new();
        for (of_chunk, more) in chunks {
            ends.extend(of_chunk.into_iter().map(|end| end + shares.len()));
            shares.extend(more);
        }
        let albedo = seen.par_iter().map(|side| sides.albedo(*side)).collect();
        Self { number, albedo, ends, shares }
    }

    /// Albedo of a side and the shares of places in its irradiance, where some place sees it.
    fn of(&self, side: u32) -> Option<(Vec3, &[Weight])> {
        let number = self.number[side as usize];
        let n = (number != NOTHING).then_some(number as usize)?;
        let begin = n.checked_sub(1).map_or(0, |before| self.ends[before]);
        Some((self.albedo[n], &self.shares[begin..self.ends[n]]))
    }

    /// The shares of places in the irradiance of a side, where some place sees it.
    pub(super) fn shares(&self, side: u32) -> Option<&[Weight]> {
        self.of(side).map(|(_, shares)| shares)
    }
}

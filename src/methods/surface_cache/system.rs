//! The linear system of radiosity between places: E = b + K·E.
//!
//! E is the irradiance of a place by light that was reflected at least once, b that by one reflection. A row of K holds what a
//! place sees: of each texel with the weight w of its directions (Σ w = π) a cell with the albedo ρ, whose own irradiance is
//! Σ a·E over places with interpolation weights a, so that K = Σ w·(ρ/π)·a. Weights a are not negative and sum to 1 at most:
//! no row of K sums to more than the largest albedo (Goral, Torrance, Greenberg & Battaile 1984, with places for patches).

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What a place receives of another's irradiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The other place.
    pub place: u32,
    /// Share of its irradiance, a colour channel each.
    pub factor: Vec3,
}

/// The matrix K, row by row.
#[derive(Clone, Debug, Default)]
pub struct System {
    ends: Vec<usize>,
    entries: Vec<Entry>,
}

impl System {
    /// By its rows.
    pub fn new(rows: &[Vec<Entry>]) -> Self {
        let end = |end: &mut usize, row: &Vec<Entry>| {
            *end += row.len();
            Some(*end)
        };
        Self { ends: rows.iter().scan(0, end).collect(), entries: rows.concat() }
    }

    /// Number of entries.
    pub fn entry_count(&self) -> usize {
        self.entries.len()
    }

    /// The largest sum of a row, of any colour channel: no bounce has more of the one before.
    pub fn largest_row(&self) -> f64 {
        let sum = |p: usize| self.row(p).iter().map(|entry| entry.factor.as_dvec3()).sum::<DVec3>().max_element();
        (0..self.ends.len()).into_par_iter().map(sum).reduce(|| 0.0, f64::max)
    }

    fn row(&self, place: usize) -> &[Entry] {
        let begin = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.entries[begin..self.ends[place]]
    }

    /// K·E. Every row has one order of summation: the result does not depend on the number of threads.
    pub fn product(&self, irradiance: &[DVec3]) -> Vec<DVec3> {
        let of_entry = |entry: &Entry| entry.factor.as_dvec3() * irradiance[entry.place as usize];
        let row = |p: usize| self.row(p).iter().map(of_entry).sum();
        (0..self.ends.len()).into_par_iter().with_min_len(64).map(row).collect()
    }
}

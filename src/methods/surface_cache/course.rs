//! The course of the surface cache: places are chosen and captured, their system is built and solved, cells get its light.

use super::choose::{Choice, Chosen};
use super::numbers::{Looking, Numbers};
use super::reflected::Reflected;
use super::sides::Sides;
use super::solve::{self, Solution};
use super::system::System;
use super::{ALL_BOUNCES, Bounced, SEEN_BYTES, SurfaceCacheSettings, read_surface};
use crate::methods::Ground;
use crate::vk::pass::Recorder;
use crate::vk::{Device, Error, Result};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Cells for each place, about.
const CELLS: u32 = 100;
/// Width of patches relative to the distance between places.
const PATCH: f32 = 0.4;
/// Fewest and most places that are aimed at where nobody says how many.
const USUAL: [u32; 2] = [1 << 10, 3 << 10];
/// Products of all bounces together, at most.
const MOST_PRODUCTS: usize = 20_000;

/// What the places of a scene are chosen, captured and solved from.
pub(super) struct SurfaceCache<'a> {
    pub(super) device: &'a Arc<Device>,
    pub(super) ground: &'a Ground<'a>,
    pub(super) sides: Sides<'a>,
    /// Radiance of both sides of each cell by direct light.
    pub(super) direct: Vec<[f32; 3]>,
    /// Between places.
    pub(super) distance: f32,
    pub(super) settings: &'a SurfaceCacheSettings,
}

/// Irradiance by reflected light of both sides of each cell, if there is any, and what was done for it.
type Found = (Option<Vec<[f32; 3]>>, Bounced);

impl<'a> SurfaceCache<'a> {
    /// Reads the direct light of the surface.
    pub(super) fn new(
        device: &'a Arc<Device>,
        recorder: &mut Recorder,
        ground: &'a Ground<'a>,
        settings: &'a SurfaceCacheSettings,
    ) -> Result<Self> {
        let (direct, first) = read_surface(device, recorder, ground)?;
        let distance = distance(ground, settings.places);
        let sides = Sides::new(ground, first, PATCH * distance);
        Ok(Self { device, ground, sides, direct, distance, settings })
    }

    /// Gathers by the way to capture that is asked for; where the device ends its loops, by whole workgroups, then by render
    /// passes. The surface holds numbers afterwards in place of its light.
    pub(super) fn gather(&self, recorder: &mut Recorder, on_progress: &mut dyn FnMut(u64)) -> Result<Found> {
        let mut looking = self.settings.looking;
        loop {
            match self.run(recorder, looking, on_progress) {
                Err(Error::LoopsEnded { shared: false }) => looking.shared = true,
                Err(Error::LoopsEnded { .. }) if looking.in_compute => looking.in_compute = false,
                done => return done,
            }
        }
    }

    fn run(&self, recorder: &mut Recorder, looking: Looking, on_progress: &mut dyn FnMut(u64)) -> Result<Found> {
        let begun = Instant::now();
        let lap = || begun.elapsed().as_secs_f64() * 1e3;
        let lit = self.lit();
        if lit.is_empty() {
            return Ok((None, Bounced::default()));
        }
        let numbers = Numbers::new(self.device, self.ground, self.sides.cell_side_count(), looking)?;
        let most = (SEEN_BYTES / 4 / numbers.table().texels.len()).max(1);
        let choice = Choice { ground: self.ground, sides: &self.sides, distance: self.distance, most };
        let chosen = choice.run(&numbers, recorder, lit)?;
        let captured = lap();
        on_progress(1);
        let reflected = Reflected::new(&self.sides, &chosen);
        let system = System::of_places(&reflected, &self.sides, &chosen);
        let built = lap();
        let solution = self.solve(&system, &self.first_bounce(&chosen));
        let solved = lap();
        on_progress(2);
        let irradiance = self.irradiance(&chosen, &reflected, &solution);
        on_progress(3);
        let bounced = Bounced {
            places: chosen.places.all.len() as u64,
            rounds: chosen.rounds,
            seen_bytes: 4 * chosen.places.seen.len() as u64,
            entries: system.entry_count() as u64,
            times_ms: [captured, built - captured, solved - built, lap() - solved],
            is_unfinished: solution.is_unfinished,
            steps: solution.steps,
            lost: solution.lost,
            is_cut: chosen.is_cut,
        };
        Ok((Some(irradiance), bounced))
    }

    /// The sides that direct light reaches, in order.
    fn lit(&self) -> Vec<u32> {
        let is_lit = |(_, light): &(u32, &[f32; 3])| **light != [0.0; 3];
        let mut lit: Vec<u32> =
            (0..).zip(&self.direct).filter(is_lit).map(|(side, _)| self.sides.of_cell(side)).collect();
        lit.sort_unstable();
        lit.dedup();
        lit
    }

    /// Irradiance of each place by light that was reflected once.
    fn first_bounce(&self, chosen: &Chosen) -> Vec<DVec3> {
        let of_place = |place: usize| {
            let seen = chosen.places.seen_by(place).iter().zip(&chosen.places.weights);
            let of_texel = |(side, weight): (&u32, &f32)| {
                let radiance = self.direct.get(*side as usize).copied().unwrap_or_default();
                Vec3::from(radiance).as_dvec3() * f64::from(*weight)
            };
            seen.map(of_texel).sum()
        };
        (0..chosen.places.all.len()).into_par_iter().map(of_place).collect()
    }

    fn solve(&self, system: &System, first: &[DVec3]) -> Solution {
        let SurfaceCacheSettings { bounces, tolerance, solver, .. } = *self.settings;
        match bounces {
            ALL_BOUNCES => solve::solve(system, first, solver, f64::from(tolerance), MOST_PRODUCTS),
            bounces => solve::partial_sum(system, first, bounces),
        }
    }
}

/// Between places, so that about as many as are asked for cover one side of everything.
fn distance(ground: &Ground<'_>, places: Option<u32>) -> f32 {
    let area: f64 = (0..ground.scene.triangles.len() as u32).map(|t| f64::from(ground.scene.area(t))).sum();
    let usual = || (ground.geometry.cell_count / CELLS).clamp(USUAL[0], USUAL[1]);
    let places = places.unwrap_or_else(usual).max(1);
    ((area / f64::from(places)).sqrt() as f32).max(1e-5 * ground.geometry.radius)
}

//! The surface cache: light that goes on from surface to surface, captured once and gathered as often as there are bounces.
//!
//! Sparse places on the surface, one for some hundred cells, capture a hemicube each, which is kept as the numbers of the cells
//! that its texels see. Irradiance by one reflection is a sum over these; that by every further one a sparse product
//! ([`system`]). Patches of cells get theirs by interpolation between places ([`interpolate`]) and reflect it on top of their direct light,
//! for whatever looks at the lit surface next.
//!
//! Captures of cells with light, one for each place and bounce, would take as long as the first ones every time; a product
//! takes a few milliseconds. The memory for it is [`SEEN_BYTES`] at most: in scenes that need more places, these lie further apart.

mod choose;
mod interpolate;
mod numbers;
mod places;
mod sides;
pub mod solve;
pub mod system;

pub use numbers::Looking;
pub use solve::Solver;

use super::Ground;
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Error, Memory, Result};
use choose::{Choice, Chosen};
use glam::{DVec3, Vec3};
use interpolate::{Interpolator, Weight};
use numbers::{NOTHING, Numbers};
use rayon::prelude::*;
use sides::Sides;
use solve::Solution;
use std::collections::HashMap;
use std::f32::consts::PI;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;
use system::{Entry, System};

/// As many bounces as carry light.
pub const ALL_BOUNCES: u32 = u32::MAX;
/// Cells for each place, about.
const CELLS: u32 = 100;
/// Width of patches relative to the distance between places.
const PATCH: f32 = 0.4;
/// Fewest and most places that are aimed at where nobody says how many.
const USUAL: [u32; 2] = [1 << 10, 3 << 10];
/// Bytes of what texels see, at most.
const SEEN_BYTES: usize = 512 << 20;
/// Products of all bounces together, at most.
const MOST_PRODUCTS: usize = 5000;

/// How light goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCacheSettings {
    /// Reflections whose light cells receive: 1 adds the light by one reflection to direct light; [`ALL_BOUNCES`] all.
    pub bounces: u32,
    /// Of all bounces, the share of the light by one reflection that may be missing after the last product.
    pub tolerance: f32,
    /// How all bounces are summed.
    pub solver: Solver,
    /// Places, about. `None`: by the number of cells.
    pub places: Option<u32>,
    /// How places look.
    pub looking: Looking,
}

/// What was done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounced {
    /// Places that captured.
    pub places: u64,
    /// Rounds in which they were chosen.
    pub rounds: u32,
    /// Bytes of what their texels see.
    pub seen_bytes: u64,
    /// Entries of the matrix.
    pub entries: u64,
    /// ‖b + K·E − E‖/‖b‖ after each product, of the worst colour channel, over all places.
    pub residuals: Vec<f64>,
    /// What the bounces left out would add, as a share of all light by reflection.
    pub lost: f64,
    /// Milliseconds that choosing and capturing places, building the matrix, solving, and lighting cells took.
    pub times_ms: [f64; 4],
    /// Whether the residual is above the tolerance.
    pub is_unfinished: bool,
    /// Whether more places would have been needed than memory is set aside for.
    pub is_cut: bool,
}

impl Bounced {
    /// What was not done as asked for, for the user.
    pub fn warning(&self) -> Option<String> {
        let Self { places, residuals, lost, .. } = self;
        if self.is_cut {
            let limit = SEEN_BYTES >> 20;
            return Some(format!(
                "what {places} places see takes {limit} MB, and light beyond the first bounce has no more places"
            ));
        }
        let (products, lost) = (residuals.len(), lost * 100.0);
        let unfinished = || {
            format!(
                "bounces: after {products} products {lost:.2} % of the light are missing; is a closed room's albedo 1?"
            )
        };
        self.is_unfinished.then(unfinished)
    }
}

/// Adds to the light of all cells of `ground`, which are lit directly, what they reflect of each other's. `on_progress` hears
/// stages done, of three.
///
/// # Errors
/// The device's. The cells have their direct light then.
pub fn add_bounces(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    ground: &Ground<'_>,
    settings: &SurfaceCacheSettings,
    on_progress: &mut dyn FnMut(u64),
) -> Result<Bounced> {
    let (direct, first) = read_surface(device, recorder, ground)?;
    let distance = distance(ground, settings.places);
    let sides = Sides::new(ground, first, PATCH * distance);
    let cache = SurfaceCache { device, ground, sides, direct, distance, settings };
    let mut looking = settings.looking;
    loop {
        match cache.run(recorder, looking, on_progress) {
            Err(Error::LoopsEnded { shared: false }) => looking.shared = true,
            Err(Error::LoopsEnded { .. }) if looking.in_compute => looking.in_compute = false,
            done => {
                let (light, bounced) = done.map_or_else(|e| (None, Err(e)), |(light, b)| (light, Ok(b)));
                ground.geometry.cell_radiance.upload(&light.unwrap_or(cache.direct))?;
                return bounced;
            }
        }
    }
}

/// Radiance of every side, and the first cell of every triangle.
fn read_surface(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    ground: &Ground<'_>,
) -> Result<(Vec<[f32; 3]>, Vec<u32>)> {
    let geometry = ground.geometry;
    let (radiance, first) = (&geometry.cell_radiance, &geometry.first_cell);
    let room = |buffer: &Buffer| Buffer::new(device, "surface radiance", buffer.size, Memory::Readback);
    let (to_radiance, to_first) = (room(radiance)?, room(first)?);
    recorder.submit(|recording| {
        recording.pass("readback", |c| {
            c.copy_buffer(radiance, &to_radiance, radiance.size);
            c.copy_buffer(first, &to_first, first.size);
            Ok(())
        })
    })?;
    Ok((to_radiance.read(2 * geometry.cell_count as usize), to_first.read(geometry.triangles.len() + 1)))
}

struct SurfaceCache<'a> {
    device: &'a Arc<Device>,
    ground: &'a Ground<'a>,
    sides: Sides<'a>,
    /// Radiance of both sides of each cell by direct light.
    direct: Vec<[f32; 3]>,
    /// Between places.
    distance: f32,
    settings: &'a SurfaceCacheSettings,
}

impl SurfaceCache<'_> {
    /// The light of all sides with bounces, if there is any.
    fn run(
        &self,
        recorder: &mut Recorder,
        looking: Looking,
        on_progress: &mut dyn FnMut(u64),
    ) -> Result<(Option<Vec<[f32; 3]>>, Bounced)> {
        let begun = Instant::now();
        let lap = || begun.elapsed().as_secs_f64() * 1e3;
        let mut lit: Vec<u32> = (0..)
            .zip(&self.direct)
            .filter(|(_, light)| **light != [0.0; 3])
            .map(|(side, _)| self.sides.of_cell(side))
            .collect();
        lit.sort_unstable();
        lit.dedup();
        if lit.is_empty() {
            return Ok((None, Bounced::default()));
        }
        let numbers = Numbers::new(self.device, self.ground, self.sides.cell_side_count(), looking)?;
        let most = (SEEN_BYTES / 4 / numbers.table().texels.len()).max(1);
        let choice = Choice { ground: self.ground, sides: &self.sides, distance: self.distance, most };
        let chosen = choice.run(&numbers, recorder, lit)?;
        let captured = lap();
        on_progress(1);
        let system = self.system(&chosen);
        let built = lap();
        let solution = self.solve(&system, &self.first_bounce(&chosen));
        let solved = lap();
        on_progress(2);
        let light = self.light(&chosen, &solution);
        on_progress(3);
        let tolerance = f64::from(self.settings.tolerance);
        let is_all = self.settings.bounces == ALL_BOUNCES;
        let bounced = Bounced {
            places: chosen.places.all.len() as u64,
            rounds: chosen.rounds,
            seen_bytes: 4 * chosen.places.seen.len() as u64,
            entries: system.entry_count() as u64,
            times_ms: [captured, built - captured, solved - built, lap() - solved],
            is_unfinished: is_all && solution.residuals.last().is_some_and(|r| *r > tolerance),
            residuals: solution.residuals,
            lost: solution.lost,
            is_cut: chosen.is_cut,
        };
        Ok((Some(light), bounced))
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

    fn system(&self, chosen: &Chosen) -> System {
        let reflected = Reflected::new(&self.sides, chosen);
        let count = chosen.places.all.len();
        let scratch = || (vec![Vec3::ZERO; count], Vec::new());
        let rows: Vec<_> = (0..count)
            .into_par_iter()
            .with_min_len(16)
            .map_init(scratch, |(sums, touched), place| row((&reflected, &self.sides), chosen, place, sums, touched))
            .collect();
        System::new(&rows)
    }

    fn solve(&self, system: &System, first: &[DVec3]) -> Solution {
        let SurfaceCacheSettings { bounces, tolerance, solver, .. } = *self.settings;
        match bounces {
            ALL_BOUNCES => solve::solve(system, first, solver, f64::from(tolerance), MOST_PRODUCTS),
            bounces => solve::partial_sum(system, first, bounces),
        }
    }

    /// Direct light and what is reflected of the places' irradiance, of both sides of each cell.
    fn light(&self, chosen: &Chosen, solution: &Solution) -> Vec<[f32; 3]> {
        let interpolator = || Interpolator::new(&chosen.places, &self.sides);
        let of_triangle = |interpolator: &mut Interpolator<'_>, (triangle, cells): (u32, Range<u32>)| {
            let mut light = self.direct[2 * cells.start as usize..2 * cells.end as usize].to_vec();
            let mut fits: HashMap<u32, Option<Fitted>> = HashMap::new();
            for cell in cells.clone() {
                let mut albedo = None;
                for cell_side in [2 * cell, 2 * cell + 1] {
                    let side = self.sides.of_cell(cell_side);
                    let fit = fits.entry(side).or_insert_with(|| Fitted::at(side, interpolator, &self.sides, solution));
                    let Some(fit) = fit else { continue };
                    let albedo = *albedo.get_or_insert_with(|| self.sides.cell_albedo(triangle, cell));
                    let more = albedo / PI * fit.irradiance(self.sides.cell_position(triangle, cell));
                    let light = &mut light[(cell_side - 2 * cells.start) as usize];
                    *light = (Vec3::from(*light) + more).into();
                }
            }
            light
        };
        self.sides
            .cells_of_triangles()
            .with_min_len(64)
            .map_init(interpolator, of_triangle)
            .collect::<Vec<_>>()
            .concat()
    }
}

/// Irradiance about the middle of a patch, as a linear fit has it.
struct Fitted {
    middle: Vec3,
    axes: [Vec3; 2],
    value: Vec3,
    slope: [Vec3; 2],
}

impl Fitted {
    /// That of a side, if there is any.
    fn at(side: u32, interpolator: &mut Interpolator<'_>, sides: &Sides<'_>, solution: &Solution) -> Option<Self> {
        interpolator.find(side);
        let sum = |of: &dyn Fn(&Weight) -> f32| {
            let of_place = |w: &Weight| solution.irradiance[w.place as usize] * f64::from(of(w));
            interpolator.weights.iter().map(of_place).sum::<DVec3>().as_vec3()
        };
        let value = sum(&|w| w.value);
        let point = sides.point(side);
        let slope = [sum(&|w| w.slope[0]), sum(&|w| w.slope[1])];
        let axes = point.normal.any_orthonormal_pair().into();
        (value != Vec3::ZERO).then_some(Self { middle: point.position, axes, value, slope })
    }

    /// At a point of the patch: not negative, and not twice of what there is in the middle.
    fn irradiance(&self, position: Vec3) -> Vec3 {
        let way = position - self.middle;
        let change = self.slope[0] * way.dot(self.axes[0]) + self.slope[1] * way.dot(self.axes[1]);
        self.value + change.clamp(-self.value, self.value)
    }
}

/// Between places, so that about as many as are asked for cover one side of everything.
fn distance(ground: &Ground<'_>, places: Option<u32>) -> f32 {
    let area: f64 = (0..ground.scene.triangles.len() as u32).map(|t| f64::from(ground.scene.area(t))).sum();
    let usual = || (ground.geometry.cell_count / CELLS).clamp(USUAL[0], USUAL[1]);
    let places = places.unwrap_or_else(usual).max(1);
    ((area / f64::from(places)).sqrt() as f32).max(1e-5 * ground.geometry.radius)
}

/// Row of the matrix. `sums` holds zeros for all places, before and after.
fn row(
    (reflected, sides): (&Reflected, &Sides<'_>),
    chosen: &Chosen,
    place: usize,
    sums: &mut [Vec3],
    touched: &mut Vec<u32>,
) -> Vec<Entry> {
    for (side, weight) in chosen.places.seen_by(place).iter().zip(&chosen.places.weights) {
        let (albedo, places) = reflected.of(if *side == NOTHING { NOTHING } else { sides.of_cell(*side) });
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
struct Reflected {
    /// Of each side, its number among those that are seen.
    number: Vec<u32>,
    albedo: Vec<Vec3>,
    ends: Vec<usize>,
    shares: Vec<Weight>,
}

impl Reflected {
    fn new(sides: &Sides<'_>, chosen: &Chosen) -> Self {
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

    fn of(&self, side: u32) -> (Vec3, &[Weight]) {
        if side == NOTHING {
            return (Vec3::ZERO, &[]);
        }
        let n = self.number[side as usize] as usize;
        let begin = n.checked_sub(1).map_or(0, |before| self.ends[before]);
        (self.albedo[n], &self.shares[begin..self.ends[n]])
    }
}

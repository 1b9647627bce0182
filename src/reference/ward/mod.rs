//! The irradiance cache of Ward, Rubinstein and Clear 1988 on the CPU, with the gradients of Ward and Heckbert 1992: what
//! splatting on the GPU claims to replace.
//!
//! Records are made first, coarse to fine over the image, and all of them before the first pixel is interpolated, so that
//! a late record reaches early pixels too.

mod cache;
mod hemisphere;
mod octree;

pub use cache::{Cache, Record};
pub use hemisphere::{Grid, Measurement};

use super::tracer::Tracer;
use super::view::Pixel;
use glam::DVec3;
use rayon::prelude::*;

/// Which weight interpolates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weight {
    /// Ward 1988: unbounded at the record, a step at the border of its zone.
    #[default]
    Ward,
    /// After Tabellion and Lamorlette 2004: 1 at the record, 0 at the border.
    Bounded,
}

/// Which gradients extrapolate records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gradients {
    /// Records are constant.
    None,
    /// With the normal.
    Rotation,
    /// With the place.
    Translation,
    /// With both.
    #[default]
    Both,
}

/// How the cache is filled and read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Ward's a: the error that is allowed, and a record's reach as a part of its distance R.
    pub accuracy: f64,
    /// Rays of a record.
    pub rays: u32,
    /// Smallest zone of influence, radius in pixels.
    pub min_radius: f64,
    /// Largest zone of influence, radius in pixels.
    pub max_radius: f64,
    /// Which weight interpolates.
    pub weight: Weight,
    /// Which gradients extrapolate.
    pub gradients: Gradients,
    /// Limit R by E / ‖∇_t E‖.
    pub gradient_limit: bool,
    /// Limit R by the neighbours' (Křivánek et al. 2006).
    pub neighbour_clamping: bool,
    /// Reflections between the light and the first hit, at least 1.
    pub bounces: u32,
    /// Same seed, same records, whatever the number of threads.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            accuracy: 0.2,
            rays: 1024,
            min_radius: 1.5,
            max_radius: 50.0,
            weight: Weight::Ward,
            gradients: Gradients::Both,
            gradient_limit: true,
            neighbour_clamping: true,
            bounces: 1,
            seed: 0,
        }
    }
}

/// Distance in pixels between the candidates of the first, coarsest level; halved at each level.
const COARSEST: u32 = 32;
/// Records computed side by side. A fixed number, so that the outcome does not depend on the number of threads.
const BATCH: usize = 64;
/// Candidates tested side by side.
const SCAN: usize = 1024;

/// Fills a cache for the pixels of an image of the given width. `progress` hears the part of the work done, 0 to 1.
pub fn fill(
    tracer: &Tracer,
    pixels: &[Pixel],
    width: u32,
    settings: &Settings,
    mut progress: impl FnMut(f64, usize),
) -> Cache {
    let (center, half) = bounds(pixels);
    let mut cache = Cache::new(*settings, center, half);
    let grid = Grid::new(settings.rays);
    let order = coarse_to_fine(pixels, width);
    // Neighbour clamping shrinks zones that earlier candidates relied on: go over them again until nothing is missing.
    // A record always covers its own pixel, so this ends.
    loop {
        let before = cache.records.len();
        fill_once(tracer, pixels, settings, &grid, &order, &mut cache, &mut progress);
        if cache.records.len() == before {
            return cache;
        }
    }
}

fn fill_once(
    tracer: &Tracer,
    pixels: &[Pixel],
    settings: &Settings,
    grid: &Grid,
    order: &[u32],
    cache: &mut Cache,
    progress: &mut impl FnMut(f64, usize),
) {
    let mut next = 0;
    while next < order.len() {
        let scanned = &order[next..order.len().min(next + SCAN)];
        let is_missing: Vec<bool> = scanned.par_iter().map(|&i| missing(cache, &pixels[i as usize])).collect();
        let places: Vec<usize> = (0..scanned.len()).filter(|&k| is_missing[k]).collect();
        let batch = &places[..places.len().min(BATCH)];
        let measured: Vec<_> = batch
            .par_iter()
            .filter_map(|&k| {
                let pixel = scanned[k];
                let surface = pixels[pixel as usize].reflector()?;
                let (m, rays) = grid.measure(tracer, surface, settings.bounces, settings.seed, u64::from(pixel));
                tracer.count_rays(rays);
                Some((pixel, surface, m))
            })
            .collect();
        for (pixel, surface, m) in measured {
            cache.insert(surface.position, surface.normal, m, pixel, pixels[pixel as usize].footprint);
        }
        next += if places.len() > BATCH { batch[BATCH - 1] + 1 } else { scanned.len() };
        progress(next as f64 / order.len() as f64, cache.records.len());
    }
}

fn missing(cache: &Cache, pixel: &Pixel) -> bool {
    pixel.reflector().is_some_and(|surface| !cache.covers(surface.position, surface.normal))
}

/// Irradiance and number of records at every pixel; zero where nothing reflects.
pub fn interpolate(cache: &Cache, pixels: &[Pixel]) -> Vec<(DVec3, u32)> {
    let at = |pixel: &Pixel| pixel.reflector().and_then(|s| cache.irradiance(s.position, s.normal)).unwrap_or_default();
    pixels.par_iter().map(at).collect()
}

/// Pixels that reflect, level by level; within a level in a scattered but fixed order, so that the records of one batch
/// stand far apart.
fn coarse_to_fine(pixels: &[Pixel], width: u32) -> Vec<u32> {
    let level = |i: u32| {
        let low_bits = (i % width) | (i / width) | COARSEST;
        COARSEST.trailing_zeros() - low_bits.trailing_zeros()
    };
    let mut order: Vec<u32> = (0..pixels.len() as u32).filter(|&i| pixels[i as usize].reflector().is_some()).collect();
    // Multiplying by an odd number permutes 32-bit numbers; the golden ratio spreads neighbours.
    order.sort_by_key(|&i| (level(i), i.wrapping_mul(0x9e37_79b1), i));
    order
}

/// A cube around all places where irradiance is asked for.
fn bounds(pixels: &[Pixel]) -> (DVec3, f64) {
    let places = || pixels.iter().filter_map(Pixel::reflector).map(|s| s.position);
    let low = places().fold(DVec3::INFINITY, DVec3::min);
    let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
    if low.x > high.x {
        return (DVec3::ZERO, 1.0);
    }
    ((low + high) * 0.5, 0.5 * (high - low).max_element().max(f64::MIN_POSITIVE))
}

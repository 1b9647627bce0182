//! The path tracer's progress over an image: batches of paths for all pixels, until a stop rule holds.

use super::film::{Estimate, Sums};
use super::path::{Layers, Path};
use super::sampler::Sampler;
use super::surface::SurfacePoint;
use super::tracer::Tracer;
use super::view::{Pixel, View};
use glam::DVec3;
use rayon::prelude::*;

/// Largest batch: beyond it one sequence's better spread gains little.
const MAX_BATCH: u32 = 1024;
/// Fewest batches of a run with a given total: their spread is the standard error.
const MIN_BATCHES: u32 = 4;

/// What is computed and from which random numbers; not how long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Reflections between the light and the first hit; [`Settings::ALL_BOUNCES`] for no limit.
    pub bounces: u32,
    /// Same seed, same image, whatever the number of threads.
    pub seed: u64,
    /// Paths a pixel in one batch; see [`batch_for`].
    pub batch: u32,
}

impl Settings {
    /// No limit on reflections; Russian roulette ends paths without bias.
    pub const ALL_BOUNCES: u32 = u32::MAX;
}

/// Batch size for an image of that many pixels where no total number of paths is given: a batch should pass within
/// seconds, since runs end between batches.
pub fn open_batch(pixels: u64) -> u32 {
    if pixels <= 1 << 18 { 16 } else { 4 }
}

/// Batch size for a total number of paths a pixel: a power of two.
pub fn batch_for(spp: u32) -> u32 {
    let largest = (spp / MIN_BATCHES).max(1);
    (1 << largest.ilog2()).min(MAX_BATCH)
}

/// An image under way.
pub struct Progressive<'a, 'b> {
    /// The scene.
    pub tracer: &'a Tracer<'b>,
    /// The view.
    pub view: View,
    /// What is computed.
    pub settings: Settings,
    /// First hits.
    pub pixels: Vec<Pixel>,
    /// Direct light of punctual lights at the first hits, where it is exact.
    punctual: Option<Vec<DVec3>>,
    pub(super) sums: Vec<Sums>,
    pub(super) batches: u32,
}

impl<'a, 'b> Progressive<'a, 'b> {
    /// Finds the first hits; no path is traced yet.
    pub fn new(tracer: &'a Tracer<'b>, view: View, settings: Settings) -> Self {
        let pixels = view.pixels(tracer);
        let exact = Path::punctual_is_exact(tracer);
        let punctual = exact.then(|| pixels.par_iter().map(|pixel| punctual(tracer, pixel)).collect());
        let sums = vec![Sums::default(); pixels.len()];
        Self { tracer, view, settings, pixels, punctual, sums, batches: 0 }
    }

    /// Traces one batch of paths from every pixel.
    pub fn advance(&mut self) {
        let (tracer, settings, batch) = (self.tracer, self.settings, self.batches);
        let in_paths = self.punctual.is_none();
        self.sums.par_chunks_mut(64).zip(self.pixels.par_chunks(64)).enumerate().for_each(|(chunk, (sums, pixels))| {
            let mut rays = 0;
            for (i, (sum, pixel)) in sums.iter_mut().zip(pixels).enumerate() {
                let Some(surface) = pixel.reflector() else { continue };
                let stream = (chunk * 64 + i) as u64;
                sum.add(&trace_batch(tracer, surface, &settings, stream, batch, in_paths, &mut rays));
            }
            tracer.count_rays(rays);
        });
        self.batches += 1;
    }

    /// Paths traced from every pixel.
    pub fn spp(&self) -> u64 {
        u64::from(self.batches) * u64::from(self.settings.batch)
    }

    /// Irradiance at a pixel's first hit; zero where nothing reflects.
    pub fn estimate(&self, index: usize) -> Estimate {
        if self.batches == 0 || self.pixels[index].reflector().is_none() {
            return Estimate::default();
        }
        let mut estimate = self.sums[index].estimate(self.batches);
        if let Some(punctual) = &self.punctual {
            estimate.mean[0] += punctual[index];
        }
        estimate
    }

    /// Mean standard error of a pixel over the mean of what is estimated: indirect irradiance, or direct where no
    /// reflection is asked for. Infinite before two batches.
    pub fn relative_error(&self) -> f64 {
        let (mut error, mut mean) = (0.0, 0.0);
        for i in 0..self.pixels.len() {
            let estimate = self.estimate(i);
            let direct = self.settings.bounces == 0;
            error += if direct { estimate.stderr[0] } else { estimate.stderr_indirect }.element_sum();
            mean += if direct { estimate.mean[0] } else { estimate.indirect() }.element_sum();
        }
        match (self.batches, mean > 0.0) {
            (0 | 1, _) => f64::INFINITY,
            (_, true) => error / mean,
            (_, false) => 0.0,
        }
    }
}

fn punctual(tracer: &Tracer, pixel: &Pixel) -> DVec3 {
    let Some(surface) = pixel.reflector() else { return DVec3::ZERO };
    Path::new(tracer, Sampler::new(0, 0, 0, 0)).punctual(surface)
}

fn trace_batch(
    tracer: &Tracer,
    surface: &SurfacePoint,
    settings: &Settings,
    stream: u64,
    batch: u32,
    punctual_at_first: bool,
    rays: &mut u64,
) -> Layers {
    let mut mean = Layers::default();
    for i in 0..settings.batch {
        let mut path = Path::new(tracer, Sampler::new(settings.seed, stream, batch, i));
        let layers = path.irradiance(surface, settings.bounces, punctual_at_first);
        mean.iter_mut().zip(layers).for_each(|(sum, layer)| *sum += layer);
        *rays += path.rays;
    }
    mean.map(|sum| sum / f64::from(settings.batch))
}

/// Irradiance at any place: on the side of `normal` of a surface that need not be part of the scene.
///
/// `spp` paths in batches; same seed, same result.
pub fn irradiance_at(tracer: &Tracer, position: DVec3, normal: DVec3, settings: &Settings, spp: u32) -> Estimate {
    let surface = SurfacePoint {
        position,
        ray_origin: position,
        geometric: normal,
        normal,
        albedo: DVec3::ZERO,
        emission: DVec3::ZERO,
        emitter: false,
        triangle: u32::MAX,
    };
    let (mut sums, mut rays) = (Sums::default(), 0);
    let batches = spp.div_ceil(settings.batch);
    for batch in 0..batches {
        sums.add(&trace_batch(tracer, &surface, settings, 0, batch, true, &mut rays));
    }
    tracer.count_rays(rays);
    sums.estimate(batches)
}

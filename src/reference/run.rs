//! From a scene to a picture in one call.

use super::cost::{Cost, Meter};
use super::picture::picture;
use super::progressive::{Progressive, Settings, batch_for, open_batch};
use super::tracer::Tracer;
use super::view::View;
use super::ward as cache;
use crate::image::Picture;
use crate::scene::{Camera, Scene};
use glam::DVec3;
use std::time::Duration;

/// When to end; whichever comes first. Without any the run would not end: [`Progressive::run`] stops after one batch.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stop {
    /// Paths a pixel, rounded up to whole batches.
    pub spp: Option<u32>,
    /// Mean standard error of a pixel / mean (see [`Progressive::relative_error`]).
    pub relative_error: Option<f64>,
    /// Time on the clock.
    pub time: Option<Duration>,
}

/// Fewest batches before their spread is believed.
const BELIEVED_BATCHES: u32 = 8;

impl Progressive<'_, '_> {
    /// Traces batches until a stop rule holds; `after_batch` hears of each, and ends the run early by an error.
    pub fn run<E>(&mut self, stop: &Stop, mut after_batch: impl FnMut(&Self) -> Result<(), E>) -> Result<Cost, E> {
        let meter = Meter::start(self.tracer);
        while !self.is_done(stop, meter.cost(self.tracer).wall) {
            self.advance();
            after_batch(self)?;
        }
        Ok(meter.cost(self.tracer))
    }

    fn is_done(&self, stop: &Stop, wall: Duration) -> bool {
        let open = stop.spp.is_none() && stop.relative_error.is_none() && stop.time.is_none();
        let exact = |limit: f64| self.batches >= BELIEVED_BATCHES && self.relative_error() <= limit;
        (open && self.batches > 0)
            || stop.spp.is_some_and(|spp| self.spp() >= u64::from(spp))
            || stop.time.is_some_and(|time| wall >= time)
            || stop.relative_error.is_some_and(exact)
    }
}

/// Path-traces an image. `settings.batch` is chosen to suit `stop`.
pub fn path_trace(
    scene: &Scene,
    camera: &Camera,
    size: (u32, u32),
    settings: Settings,
    stop: &Stop,
) -> (Picture, Cost) {
    let tracer = Tracer::new(scene);
    let pixels = u64::from(size.0) * u64::from(size.1);
    let batch = stop.spp.map_or_else(|| open_batch(pixels), batch_for);
    let mut run = Progressive::new(&tracer, View::new(camera, size.0, size.1), Settings { batch, ..settings });
    let never = |_: &Progressive| Ok::<(), std::convert::Infallible>(());
    match run.run(stop, never) {
        Ok(cost) => (run.picture(), cost),
    }
}

/// An image whose indirect light comes from an irradiance cache.
pub struct Cached {
    /// The layers of [`picture`], and `records.Y`: records that each pixel was interpolated from.
    pub picture: Picture,
    /// The records.
    pub cache: cache::Cache,
    /// Cost of making the records.
    pub fill: Cost,
    /// Cost of interpolating between them.
    pub interpolate: Cost,
    /// Cost of the direct light, which the cache has no part in.
    pub direct: Cost,
}

/// Renders by the irradiance cache; direct light by `direct_spp` paths a pixel. `progress` hears the part of the records'
/// work done, 0 to 1, and their number.
pub fn ward(
    tracer: &Tracer,
    view: View,
    settings: &cache::Settings,
    direct_spp: u32,
    progress: impl FnMut(f64, usize),
) -> Cached {
    let direct_settings = Settings { bounces: 0, seed: settings.seed, batch: batch_for(direct_spp) };
    let mut direct = Progressive::new(tracer, view, direct_settings);
    let stop = Stop { spp: Some(direct_spp), ..Stop::default() };
    let Ok(direct_cost) = direct.run(&stop, |_| Ok::<(), std::convert::Infallible>(()));
    let meter = Meter::start(tracer);
    let records = cache::fill(tracer, &direct.pixels, direct.view.width, settings, progress);
    let fill = meter.cost(tracer);
    let meter = Meter::start(tracer);
    let found = cache::interpolate(&records, &direct.pixels);
    let interpolate = meter.cost(tracer);
    let indirect: Vec<DVec3> = found.iter().map(|(e, _)| *e).collect();
    let lit: Vec<DVec3> = (0..found.len()).map(|i| direct.estimate(i).mean[0]).collect();
    let mut picture = picture(tracer, &direct.view, &direct.pixels, &lit, &indirect);
    picture.insert_scalar("records.Y", found.iter().map(|(_, count)| *count as f32));
    Cached { picture, cache: records, fill, interpolate, direct: direct_cost }
}

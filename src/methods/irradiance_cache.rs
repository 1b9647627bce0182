//! Irradiance-cache splatting (Gautron, Křivánek, Bouatouch and Pattanaik 2005; S0): records in rounds, from coarse to
//! fine, until every visible pixel is covered.

mod lattices;
mod settings;

pub use settings::{CONTRAST_SIZE, CacheSettings};

use super::Ground;
use super::captures::Captures;
use super::work::{Meter, Work};
use crate::passes::clamp_records::{ClampRecords, Reach};
use crate::passes::find_uncovered::{FindUncovered, Lattice, Need};
use crate::passes::gbuffer::Targets;
use crate::passes::integrate::{Integrate, Limits};
use crate::passes::place_records::{PlaceRecords, Placement};
use crate::passes::splat::{Outputs, Seen, Splat, View};
use crate::vk::gpu_types::{Payload, Record};
use crate::vk::pass::{Recorder, Recording};
use crate::vk::{Buffer, Device, Memory, Result};
use lattices::lattices;
use std::sync::Arc;

/// Smallest radius of a zone of influence in pixels: a record covers its neighbours, whatever the settings.
const SMALLEST_RADIUS: f32 = 2.0;

/// Where the cache is looked at from, for placing and splatting.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Placement of records but for the fields that change from batch to batch.
    pub placement: Placement,
    /// Camera of the splats.
    pub view: View,
}

/// What a run of the cache did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheStats {
    /// Records captured.
    pub records: u64,
    /// Rounds that found something to do.
    pub rounds: u32,
    /// What its passes did, if that was counted.
    pub work: Option<Work>,
}

/// What a scene makes of the cache.
#[derive(Clone, Copy)]
pub struct Features<'a> {
    /// Background, if it shines.
    pub sky: Option<&'a Buffer>,
    /// Captures are rasterised in compute, as the plan says.
    pub in_compute: bool,
    /// The number of records of each pixel is kept.
    pub counts_records: bool,
    /// What the passes do is counted.
    pub counts_work: bool,
}

/// Passes and buffers of the cache.
pub struct IrradianceCache {
    settings: CacheSettings,
    captures: Captures,
    find: FindUncovered,
    place: PlaceRecords,
    integrate: Integrate,
    clamp: Option<ClampRecords>,
    /// Smallest radius of a zone in pixels.
    min_radius: f32,
    meter: Option<Meter>,
    /// Splats and their sums.
    pub splat: Splat,
    _records: Buffer,
    _payloads: Buffer,
}

impl IrradianceCache {
    /// Builds what a cache over the visible surfaces `gbuffer` needs.
    pub fn new(
        device: &Arc<Device>,
        ground: &Ground<'_>,
        gbuffer: &Targets,
        features: Features<'_>,
        settings: CacheSettings,
    ) -> Result<Self> {
        let geometry = ground.geometry;
        let Features { sky, in_compute, counts_records, counts_work } = features;
        let meter = || Meter::new(device, gbuffer.position.desc.size);
        let meter = counts_work.then(meter).transpose()?;
        let captures = Captures::new(
            device,
            ground,
            in_compute,
            settings.captures(),
            (sky, settings.gradients.translation),
            meter.as_ref().map(|meter| &meter.drawn),
        )?;
        let capacity = captures.capacity;
        let records = u64::from(capacity) * size_of::<Record>() as u64;
        let records = Buffer::new(device, "records", records, Memory::Device)?;
        let payloads = u64::from(capacity) * size_of::<Payload>() as u64 * if sky.is_some() { 2 } else { 1 };
        let payloads = Buffer::new(device, "records", payloads, Memory::Device)?;
        let tally = counts_records || counts_work || settings.contrast > 0.0;
        let outputs = Outputs { sky: sky.is_some(), tally, fragments: counts_work };
        let both = (&records, &payloads);
        let has_gradients = settings.gradients.rotation || settings.gradients.translation;
        let height = gbuffer.position.desc.size[1] as f32;
        let min_radius = (settings.min_radius * height).max(SMALLEST_RADIUS);
        let limits = Limits {
            accuracy: settings.accuracy,
            min_radius,
            max_radius: (settings.max_radius * height).max(min_radius),
            scene_radius: geometry.radius,
        };
        let quantities = (settings.gradients, settings.radius);
        let integrate = Integrate::new(device, geometry, &captures.captured(), both, sky, quantities, limits)?;
        let Captures { gathered, size, .. } = &captures;
        let (distances, stride) = gathered.distances();
        let seen = Seen { frames: captures.frames(), distances, size: *size, stride };
        let seen = settings.rejects_hidden().then_some(seen);
        let splat = Splat::new(device, gbuffer, both, outputs, has_gradients, settings.weight, seen)?;
        let find = FindUncovered::new(device, gbuffer, &splat.sums, settings.contrast > 0.0)?;
        let place = PlaceRecords::new(device, gbuffer, &find.found, captures.frames(), &records)?;
        let reach = Reach { min: limits.min_radius, max: limits.max_radius };
        let clamp = || ClampRecords::new(device, gbuffer, &find.found, both, sky.is_some(), reach);
        let clamp = settings.clamped.then(clamp).transpose()?;
        let (_records, _payloads) = (records, payloads);
        Ok(Self { settings, captures, find, place, integrate, clamp, min_radius, meter, splat, _records, _payloads })
    }

    /// Fills the cache until every pixel is covered. `progress` hears the records so far and the share of rounds done.
    pub fn run(
        &self,
        recorder: &mut Recorder,
        ground: &Ground<'_>,
        viewpoint: &Viewpoint,
        mut progress: impl FnMut(u64, f32),
    ) -> Result<CacheStats> {
        let mut stats = CacheStats::default();
        let lattices = lattices();
        recorder.submit(|recording| {
            self.captures.prepare(recording)?;
            recording.pass("splat", |c| {
                self.splat.record_clear(c);
                if let Some(meter) = &self.meter {
                    meter.drawn.record_clear(c);
                }
                Ok(())
            })?;
            if let Some(clamp) = &self.clamp {
                recording.pass("clamp_records", |c| {
                    clamp.record_clear(c);
                    Ok(())
                })?;
            }
            self.find(recording, lattices[0])
        })?;
        for (index, lattice) in lattices.iter().enumerate() {
            let mut left = self.find.count();
            stats.rounds += u32::from(left > 0);
            loop {
                // A pixel may be found again, as its records go on to disagree: no more are put than there were pixels.
                let found = self.find.count().min(left).min(self.settings.batch.unwrap_or(u32::MAX));
                left = if found == 0 { 0 } else { left - found };
                let next = if left > 0 { Some(lattice) } else { lattices.get(index + 1) };
                self.round(recorder, ground, viewpoint, found, next.copied())?;
                stats.records += u64::from(found);
                if left == 0 {
                    break;
                }
            }
            progress(stats.records, (index + 1) as f32 / lattices.len() as f32);
        }
        self.captures.check(recorder)?;
        if let Some(meter) = &self.meter {
            let Captures { texels, drawn_whole, .. } = self.captures;
            stats.work = Some(meter.read(recorder, &self.splat, stats.records, (texels, drawn_whole))?);
        }
        Ok(stats)
    }

    fn find(&self, recording: &mut Recording<'_>, lattice: Lattice) -> Result<()> {
        recording.pass("find_uncovered", |c| {
            self.find.record(c, lattice, self.need(lattice));
            Ok(())
        })
    }

    /// Where records disagree, smaller ones are put between them: as long as the lattice is no finer than their zones.
    fn need(&self, lattice: Lattice) -> Need {
        let refines = (lattice.stride / 2) as f32 >= self.min_radius;
        let contrast = if refines { self.settings.told_contrast() } else { 0.0 };
        Need { covered: self.settings.covered, contrast }
    }

    /// Captures and splats what was found, a submission a batch; the last one looks for the next round's pixels.
    fn round(
        &self,
        recorder: &mut Recorder,
        ground: &Ground<'_>,
        viewpoint: &Viewpoint,
        found: u32,
        next: Option<Lattice>,
    ) -> Result<()> {
        let capacity = self.captures.capacity;
        let batches = found.div_ceil(capacity).max(1);
        for batch in 0..batches {
            let first = batch * capacity;
            let count = (found - first.min(found)).min(capacity);
            recorder.submit(|recording| {
                if count > 0 {
                    let placement = Placement { first, count, scale: self.captures.scale(), ..viewpoint.placement };
                    self.batch(recording, ground, placement, &viewpoint.view)?;
                }
                match next.filter(|_| batch + 1 == batches) {
                    Some(lattice) => self.find(recording, lattice),
                    None => Ok(()),
                }
            })?;
        }
        Ok(())
    }

    fn batch(
        &self,
        recording: &mut Recording<'_>,
        ground: &Ground<'_>,
        placement: Placement,
        view: &View,
    ) -> Result<()> {
        let Placement { first, count, .. } = placement;
        recording.pass("place_records", |c| {
            self.place.record(c, placement);
            Ok(())
        })?;
        self.captures.record(recording, ground, count)?;
        recording.pass("integrate", |c| {
            self.integrate.record(c, count);
            Ok(())
        })?;
        if let Some(clamp) = &self.clamp {
            recording.pass("clamp_records", |c| {
                clamp.record(c, first, count);
                Ok(())
            })?;
        }
        recording.pass("splat", |c| {
            self.splat.record(c, view, count);
            Ok(())
        })
    }
}

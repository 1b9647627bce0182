//! Irradiance-cache splatting (Gautron, Křivánek, Bouatouch and Pattanaik 2005; S0): records in rounds, from coarse to
//! fine, until every visible pixel is covered.
//!
//! Records are kept ([`super::records`]): a view first uses those that there are, and adds what it lacks. A new record's reach is
//! clamped by the older ones and by its own batch.
//!
//! Clamping both ways at the end and splatting all records anew (Křivánek et al. 2006) was measured and does not pay. Sponza,
//! 256×256, against E_256x256.exr: one way 9,468 records, 2.45 %; both ways 3.81 %, with 2,576 pixels below the coverage that they had;
//! with these filled 10,750 records, 2.31 %, which is what more records give by themselves (2.45 % · √(9,468/10,750) = 2.30 %), and in
//! the living room 2.75 % instead of 2.72 % with a tenth more records. Splatting with 1.4 times the radius that covers: 2.57 %.
//! Command: `hemicube render sponza.gltf -o s.exr --width 256 --height 256 --layers all`, then `hemicube compare s.exr E_256x256.exr
//! --layer irradiance=b1 --mask mask`.

mod filling;
mod lattices;
mod settings;
mod stand_in;

pub use settings::{CONTRAST_SIZE, CacheSettings};

use super::Ground;
use super::captures::Captures;
use super::records::Records;
use super::work::{Meter, Work};
use crate::passes::clamp_records::{ClampRecords, Footprint, Reach};
use crate::passes::find_uncovered::{FindUncovered, Lattice, Need};
use crate::passes::gbuffer::Targets;
use crate::passes::index_records::IndexRecords;
use crate::passes::integrate::{Integrate, Limits};
use crate::passes::keep_records::{Batch, KeepRecords};
use crate::passes::place_records::{PlaceRecords, Placement};
use crate::passes::splat::{Contribution, Outputs, Source, Splat, View};
use crate::vk::gpu_types::{Payload, Record};
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Memory, Result};
use filling::Filling;
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
    /// Size of a pixel on surfaces.
    pub footprint: Footprint,
}

/// What a run of the cache did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheStats {
    /// Records captured.
    pub records: u64,
    /// Records that there were before.
    pub reused: u64,
    /// Rounds that found something to do.
    pub rounds: u32,
    /// It was stopped before every pixel had its records: others stand in there.
    pub unfinished: bool,
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
    keep: KeepRecords,
    index: IndexRecords,
    clamp: ClampRecords,
    /// Limits of zones.
    reach: Reach,
    meter: Option<Meter>,
    /// Splats and their sums.
    pub splat: Splat,
    records: Buffer,
    payloads: Buffer,
}

impl IrradianceCache {
    /// Builds what a cache over the visible surfaces `gbuffer` needs. Records will be kept in `store`, or in one of the same shape.
    ///
    /// # Errors
    /// The device refuses a pipeline or has no memory left.
    pub fn new(
        device: &Arc<Device>,
        ground: &Ground<'_>,
        gbuffer: &Targets,
        store: &Records,
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
        let shape = store.shape();
        let capacity = u64::from(captures.capacity);
        let records = Buffer::new(device, "records", capacity * size_of::<Record>() as u64, Memory::Device)?;
        let payloads = capacity * u64::from(shape.payloads) * size_of::<Payload>() as u64;
        let payloads = Buffer::new(device, "records", payloads, Memory::Device)?;
        let limits = Limits { scene_radius: geometry.radius };
        let (both, quantities) = ((&records, &payloads), (settings.gradients, settings.radius));
        let integrate = Integrate::new(device, geometry, &captures.captured(), both, sky, quantities, limits)?;
        let piece = store.pieces().next().expect("a store has a piece");
        let batch = batch_of(&captures, both);
        let keep = KeepRecords::new(device, shape.payloads, shape.horizon, (&batch, &piece))?;

        let source = Source {
            records: piece.records,
            payloads: piece.payloads,
            horizons: piece.horizons,
            // Any buffer tells what is bound there.
            zones: &records,
        };
        let tally = counts_records || counts_work || settings.contrast > 0.0;
        let outputs = Outputs { sky: sky.is_some(), tally, fragments: counts_work };
        let gradients = settings.gradients.rotation || settings.gradients.translation;
        let contribution = Contribution { gradients, weight: settings.weight, horizon: shape.horizon };
        let splat = Splat::new(device, gbuffer, &source, outputs, contribution)?;
        let find = FindUncovered::new(device, gbuffer, &splat.sums, settings.contrast > 0.0)?;
        let place = PlaceRecords::new(device, gbuffer, &find.found, captures.frames(), &records)?;

        let height = gbuffer.position.desc.size[1] as f32;
        let min_radius = (settings.min_radius * height).max(SMALLEST_RADIUS);
        let max_radius = (settings.max_radius * height).max(min_radius);
        let reach = Reach { accuracy: settings.accuracy, min: min_radius, max: max_radius };
        let index = IndexRecords::new(device, store.index())?;
        let clamp = ClampRecords::new(device, (store.index(), &records), settings.clamped)?;
        Ok(Self {
            settings,
            captures,
            find,
            place,
            integrate,
            keep,
            index,
            clamp,
            reach,
            meter,
            splat,
            records,
            payloads,
        })
    }

    /// Fills the cache until every pixel is covered, with what `store` holds and with new records, which it keeps. `progress` hears the
    /// new records so far and the share of rounds done. Once `stop` says so, no more records are made, and those that there are stand in.
    ///
    /// # Errors
    /// The device fails, has no memory left or ends the loops of captures.
    pub fn run(
        &self,
        recorder: &mut Recorder,
        ground: &Ground<'_>,
        (gbuffer, viewpoint): (&Targets, &Viewpoint),
        store: &mut Records,
        (stop, progress): (&dyn Fn() -> bool, impl FnMut(u64, f32)),
    ) -> Result<CacheStats> {
        Filling::new(self, ground, (gbuffer, viewpoint), (store, stop))?.run(recorder, progress)
    }

    fn batch(&self) -> Batch<'_> {
        batch_of(&self.captures, (&self.records, &self.payloads))
    }

    /// Where records disagree, smaller ones are put between them: as long as the lattice is no finer than their zones.
    fn need(&self, lattice: Lattice) -> Need {
        let refines = (lattice.stride / 2) as f32 >= self.reach.min;
        let contrast = if refines { self.settings.told_contrast() } else { 0.0 };
        Need { covered: self.settings.covered, contrast }
    }
}

fn batch_of<'a>(captures: &'a Captures, (records, payloads): (&'a Buffer, &'a Buffer)) -> Batch<'a> {
    let (distances, stride) = captures.gathered.distances();
    Batch { frames: captures.frames(), records, payloads, distances, stride }
}

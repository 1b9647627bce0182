//! A view uses the records that there are, and adds those that it lacks.

use super::lattices::lattices;
use super::{CacheStats, IrradianceCache, Viewpoint};
use crate::methods::Ground;
use crate::methods::captures::Captures;
use crate::methods::records::{Records, copy};
use crate::passes::clamp_records::{Reach, Whose};
use crate::passes::find_uncovered::Lattice;
use crate::passes::gbuffer::Targets;
use crate::passes::keep_records::Piece;
use crate::passes::place_records::Placement;
use crate::passes::splat::{Source, View};
use crate::vk::pass::{Recorder, Recording};
use crate::vk::{Buffer, DescriptorSet, Device, Memory, Result};
use std::ops::Range;
use std::sync::Arc;

/// A cache on its way to cover a view.
pub struct Filling<'a> {
    pub(super) cache: &'a IrradianceCache,
    ground: &'a Ground<'a>,
    pub(super) gbuffer: &'a Targets,
    pub(super) viewpoint: &'a Viewpoint,
    pub(super) store: &'a mut Records,
    /// Whether it is to end.
    stop: &'a dyn Fn() -> bool,
    bound: Bound,
    stats: CacheStats,
}

/// The store as the passes are given it, and the zones of its records in the view.
struct Bound {
    zones: Buffer,
    index: DescriptorSet,
    clamp: DescriptorSet,
    /// A piece each.
    keep: Vec<DescriptorSet>,
    splat: Vec<DescriptorSet>,
}

impl Bound {
    fn new(cache: &IrradianceCache, gbuffer: &Targets, store: &Records, device: &Arc<Device>) -> Result<Self> {
        let index = store.index();
        let zones = Buffer::new(device, "zones of records", u64::from(index.capacity) * 4, Memory::Device)?;
        let batch = cache.batch();
        let source = |piece: &Piece<'_>| {
            let (records, payloads, horizons) = (piece.records, piece.payloads, piece.horizons);
            cache.splat.set(gbuffer, &Source { records, payloads, horizons, zones: &zones })
        };
        Ok(Self {
            index: cache.index.set(index)?,
            clamp: cache.clamp.set(index, &zones)?,
            keep: store.pieces().map(|piece| cache.keep.set(&batch, &piece)).collect::<Result<_>>()?,
            splat: store.pieces().map(|piece| source(&piece)).collect::<Result<_>>()?,
            zones,
        })
    }
}

impl<'a> Filling<'a> {
    /// Nothing is done yet.
    pub fn new(
        cache: &'a IrradianceCache,
        ground: &'a Ground<'a>,
        (gbuffer, viewpoint): (&'a Targets, &'a Viewpoint),
        (store, stop): (&'a mut Records, &'a dyn Fn() -> bool),
    ) -> Result<Self> {
        let bound = Bound::new(cache, gbuffer, store, store.device())?;
        let stats = CacheStats { reused: u64::from(store.count()), ..CacheStats::default() };
        Ok(Self { cache, ground, gbuffer, viewpoint, store, stop, bound, stats })
    }

    /// Covers the view.
    pub fn run(mut self, recorder: &mut Recorder, mut progress: impl FnMut(u64, f32)) -> Result<CacheStats> {
        let (cache, lattices) = (self.cache, lattices());
        self.begin(recorder, lattices[0])?;
        self.rounds(recorder, &lattices, &mut progress)?;
        if self.stats.unfinished {
            self.stand_in(recorder)?;
        }
        cache.captures.check(recorder)?;
        if let Some(meter) = &cache.meter {
            let Captures { texels, drawn_whole, .. } = cache.captures;
            self.stats.work = Some(meter.read(recorder, &cache.splat, self.stats.records, (texels, drawn_whole))?);
        }
        Ok(self.stats)
    }

    /// Splats what there is, and looks for the first round's pixels.
    fn begin(&self, recorder: &mut Recorder, first: Lattice) -> Result<()> {
        let cache = self.cache;
        recorder.submit(|recording| {
            cache.captures.prepare(recording)?;
            recording.pass("splat", |c| {
                cache.splat.record_clear(c);
                cache.find.record_clear(c);
                if let Some(meter) = &cache.meter {
                    meter.drawn.record_clear(c);
                }
                Ok(())
            })?;
            if self.store.count() > 0 {
                self.apply(recording, 0..self.store.count(), Whose::Old)?;
                recording.pass("find_uncovered", |c| {
                    cache.find.record_settled(c, cache.settings.covered);
                    Ok(())
                })?;
            }
            self.find(recording, first)
        })
    }

    /// Puts records on the pixels of each lattice that need one; the first has been looked at.
    fn rounds(
        &mut self,
        recorder: &mut Recorder,
        lattices: &[Lattice],
        progress: &mut impl FnMut(u64, f32),
    ) -> Result<()> {
        let (find, most) = (&self.cache.find, self.cache.settings.batch.unwrap_or(u32::MAX));
        for (index, lattice) in lattices.iter().enumerate() {
            let mut left = find.count();
            self.stats.rounds += u32::from(left > 0);
            loop {
                // A pixel may be found again while its records disagree. No more records are put than pixels were found at first.
                let found = find.count().min(left).min(most);
                left = if found == 0 { 0 } else { left - found };
                let next = if left > 0 { Some(lattice) } else { lattices.get(index + 1) };
                self.round(recorder, found, next.copied())?;
                if self.stats.unfinished {
                    return Ok(());
                }
                if left == 0 {
                    break;
                }
            }
            progress(self.stats.records, (index + 1) as f32 / lattices.len() as f32);
        }
        Ok(())
    }

    /// Captures, keeps and splats what was found, a submission a batch; the last one looks for the next round's pixels.
    fn round(&mut self, recorder: &mut Recorder, found: u32, next: Option<Lattice>) -> Result<()> {
        let capacity = self.cache.captures.capacity;
        let batches = found.div_ceil(capacity).max(1);
        for batch in 0..batches {
            let first = batch * capacity;
            let count = (found - first.min(found)).min(capacity);
            if count > 0 && self.store.count() > 0 && (self.stop)() {
                self.stats.unfinished = true;
                return Ok(());
            }
            self.reserve(count)?;
            recorder.submit(|recording| {
                if count > 0 {
                    self.batch(recording, first, count)?;
                }
                match next.filter(|_| batch + 1 == batches) {
                    Some(lattice) => self.find(recording, lattice),
                    None => Ok(()),
                }
            })?;
            self.stats.records += u64::from(count);
        }
        Ok(())
    }

    fn reserve(&mut self, count: u32) -> Result<()> {
        if self.store.reserve(count)? {
            let device = self.store.device().clone();
            let bound = Bound::new(self.cache, self.gbuffer, self.store, &device)?;
            copy(&device, &self.bound.zones, &bound.zones)?;
            self.bound = bound;
        }
        Ok(())
    }

    fn find(&self, recording: &mut Recording<'_>, lattice: Lattice) -> Result<()> {
        recording.pass("find_uncovered", |c| {
            self.cache.find.record(c, lattice, self.cache.need(lattice));
            Ok(())
        })
    }

    fn batch(&mut self, recording: &mut Recording<'_>, first: u32, count: u32) -> Result<()> {
        let cache = self.cache;
        let placement = Placement { first, count, scale: cache.captures.scale(), ..self.viewpoint.placement };
        recording.pass("place_records", |c| {
            cache.place.record(c, placement);
            Ok(())
        })?;
        cache.captures.record(recording, self.ground, count)?;
        recording.pass("integrate", |c| {
            cache.integrate.record(c, count);
            Ok(())
        })?;
        let number = self.store.count();
        let runs = self.store.take(count);
        recording.pass("keep_records", |c| {
            runs.iter().for_each(|(piece, run)| cache.keep.record(c, &self.bound.keep[*piece], *run));
            Ok(())
        })?;
        self.apply(recording, number..number + count, Whose::New { indexed: self.store.count() })
    }

    /// Finds the zones of a range of records, and splats them.
    fn apply(&self, recording: &mut Recording<'_>, range: Range<u32>, whose: Whose) -> Result<()> {
        let (cache, bound) = (self.cache, &self.bound);
        if let (Whose::New { indexed }, true) = (whose, cache.settings.clamped) {
            recording.pass("index_records", |c| {
                cache.index.record(c, self.store.index(), &bound.index, indexed);
                Ok(())
            })?;
        }
        self.splat(recording, (range, whose), (cache.reach, &self.viewpoint.view))
    }

    /// Splats a range of records, their zones within these limits.
    pub(super) fn splat(
        &self,
        recording: &mut Recording<'_>,
        (range, whose): (Range<u32>, Whose),
        (reach, view): (Reach, &View),
    ) -> Result<()> {
        let (cache, bound) = (self.cache, &self.bound);
        recording.pass("clamp_records", |c| {
            cache.clamp.record(c, &bound.clamp, (&self.viewpoint.footprint, reach), range.clone(), whose);
            Ok(())
        })?;
        recording.pass("splat", |c| {
            for (piece, part) in self.store.by_piece(range) {
                cache.splat.record(c, view, &bound.splat[piece], part, self.store.first_of(piece));
            }
            Ok(())
        })
    }
}

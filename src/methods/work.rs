//! What the passes of a cache did, counted, to hold against what the device does at most ([`super::rates`]).

use crate::passes::counter::Counter;
use crate::passes::splat::{Splat, Tally};
use crate::vk::pass::Recorder;
use crate::vk::{Device, Result};
use std::sync::Arc;

/// What the passes of a cache did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Triangles times views that captures drew: what culling left.
    pub triangle_views: u64,
    /// Texels of captures that were looked up and integrated.
    pub texels: u64,
    /// Fragments of splats.
    pub fragments: u64,
    /// Those of them to which a record gave a weight.
    pub weighted_fragments: u64,
}

/// Counts it.
pub(super) struct Meter {
    /// Triangles times views after culling.
    pub drawn: Counter,
    tally: Tally,
}

impl Meter {
    pub(super) fn new(device: &Arc<Device>, size: [u32; 2]) -> Result<Self> {
        Ok(Self { drawn: Counter::new(device)?, tally: Tally::new(device, size)? })
    }

    /// Reads the counts of `records` records, each of so many `texels` and, if nothing is culled, of `drawn_whole` triangles
    /// times views.
    pub(super) fn read(
        &self,
        recorder: &mut Recorder,
        splat: &Splat,
        records: u64,
        (texels, drawn_whole): (u32, u32),
    ) -> Result<Work> {
        recorder.submit(|recording| {
            recording.pass("readback", |c| {
                self.drawn.record_readback(c);
                self.tally.record_readback(c, splat);
                Ok(())
            })
        })?;
        let (fragments, weighted_fragments) = self.tally.read();
        let triangle_views = self.drawn.read() + records * u64::from(drawn_whole);
        Ok(Work { triangle_views, texels: records * u64::from(texels), fragments, weighted_fragments })
    }
}

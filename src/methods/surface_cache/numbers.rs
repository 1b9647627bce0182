//! Captures that show which side of which surface cell each texel sees.
//!
//! No pass of its own: while places are captured, cells hold their sides' numbers in place of their light, as bits of floats that
//! no device takes for denormal ones, and the passes that look light up hand them on as they are.

use crate::math::capture::{Projection, Table};
use crate::methods::Ground;
use crate::methods::captures::{Captures, CapturesDesc};
use crate::passes::look_up::LookUp;
use crate::vk::gpu_types::Frame;
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Memory, Result};
use std::sync::Arc;

/// As `TAG` of `glsl/inc/gathered.glsl`.
const TAG: u32 = 0x4000_0000;
/// A texel that sees no surface.
pub(super) const NOTHING: u32 = u32::MAX;

/// How places look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looking {
    /// Texels a side of a hemicube's top.
    pub size: u32,
    /// Whether captures run in compute.
    pub in_compute: bool,
    /// Most that coarse triangles in compute may be wrong by, in texels.
    pub lod_error: f32,
    /// Whether whole workgroups share each view in compute.
    pub shared: bool,
}

/// What the texels of one capture see.
pub(super) struct Seen<'a>(&'a [[f32; 4]]);

impl Seen<'_> {
    /// The side that texel `i` sees, or [`NOTHING`].
    pub(super) fn side(&self, i: usize) -> u32 {
        let bits = self.0[i][0].to_bits();
        if bits & TAG == 0 { NOTHING } else { bits ^ TAG }
    }

    /// 1/distance of what it sees.
    pub(super) fn inverse_distance(&self, i: usize) -> f32 {
        self.0[i][3]
    }
}

/// The captures, and what reads them back.
pub(super) struct Numbers {
    captures: Captures,
    look_up: Option<LookUp>,
    readback: Buffer,
}

impl Numbers {
    /// Writes the numbers of `sides` sides over the light of the surface, and builds what captures them.
    pub(super) fn new(device: &Arc<Device>, ground: &Ground<'_>, sides: usize, looking: Looking) -> Result<Self> {
        let number = |side: u32| [f32::from_bits(TAG | side), 0.0, 0.0];
        let numbers: Vec<[f32; 3]> = (0..sides as u32).map(number).collect();
        ground.geometry.cell_radiance.upload(&numbers)?;
        let Looking { size, in_compute, lod_error, shared } = looking;
        let projection = Projection::Hemicube;
        let desc = CapturesDesc { projection, far: None, size, lod_error, shared, may_sum: false };
        let captures = Captures::of(device, ground, in_compute, desc, (None, false), None)?;
        let table = projection.table(size);
        let gathered = &captures.gathered;
        let look_up = captures
            .by_render()
            .map(|capture| LookUp::new(device, ground.geometry, capture, (projection, &table), gathered, None))
            .transpose()?;
        let readback = Buffer::new(device, "gathered radiance", gathered.buffer().size, Memory::Readback)?;
        Ok(Self { captures, look_up, readback })
    }

    /// The texels of a capture, in the order of what [`Self::capture`] gives.
    pub(super) fn table(&self) -> Table {
        self.captures.projection.table(self.captures.size)
    }

    /// Captures at all `frames`, in batches; `hear` gets what each sees, in order.
    pub(super) fn capture(
        &self,
        recorder: &mut Recorder,
        ground: &Ground<'_>,
        frames: &[Frame],
        mut hear: impl FnMut(Seen<'_>),
    ) -> Result<()> {
        let texels = self.captures.texels as usize;
        for batch in frames.chunks(self.captures.capacity as usize) {
            self.captures.frames().upload(batch)?;
            recorder.submit(|recording| {
                let count = batch.len() as u32;
                self.captures.record(recording, ground, count)?;
                if let Some(look_up) = &self.look_up {
                    recording.pass("look_up", |c| {
                        look_up.record(c, count);
                        Ok(())
                    })?;
                }
                recording.pass("readback", |c| {
                    c.copy_buffer(self.captures.gathered.buffer(), &self.readback, (batch.len() * texels * 16) as u64);
                    Ok(())
                })
            })?;
            let values: Vec<[f32; 4]> = self.readback.read(batch.len() * texels);
            values.chunks(texels).for_each(|of_one| hear(Seen(of_one)));
        }
        self.captures.check(recorder)
    }
}

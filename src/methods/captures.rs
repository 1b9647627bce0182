//! How records look at the scene: the capture passes, one interface.

use super::Ground;
use crate::passes::capture::{Capture, CaptureDesc, Views, pays_to_cull};
use crate::passes::capture_compute::CaptureCompute;
use crate::passes::integrate::Captured;
use crate::scene::{Part, Scene};
use crate::vk::pass::Recording;
use crate::vk::{Buffer, Device, Result};
use std::sync::Arc;

/// How far a capture stands off its surface, relative to the scene's size: a few units in the last place of positions.
pub const LIFT: f32 = 4e-6;
/// Near distance of captures, relative to the scene's size.
pub const NEAR: f32 = LIFT * 0.25;

/// How records look at the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CaptureMode {
    /// In compute where that fits and the device is a CPU, whose vertex stage runs on one core; else by render passes.
    #[default]
    Auto,
    /// Multi-view render passes.
    Hemicube,
    /// In compute where that fits (no alpha masks, at most 2¹⁹ triangles), whatever the device.
    Compute,
}

impl CaptureMode {
    /// Whether captures of `scene` at `size` texels a side run in compute: wished for, and possible there.
    pub fn in_compute(self, device: &Device, scene: &Scene, size: u32) -> bool {
        let wanted = self == Self::Compute || (self == Self::Auto && device.is_cpu());
        let masked = |part: &Part| scene.materials[part.material as usize].alpha_cutoff.is_some();
        wanted && !scene.parts.iter().any(masked) && CaptureCompute::holds(device, scene.triangles.len(), size)
    }
}

/// The pass that captures, boxed for their sizes differ.
pub enum Captures {
    /// Render passes.
    Render(Box<Capture>),
    /// Compute.
    Compute(Box<CaptureCompute>),
}

impl Captures {
    /// Builds captures of `size` texels a side, and says how many records a batch holds.
    pub fn new(device: &Arc<Device>, ground: &Ground<'_>, in_compute: bool, size: u32) -> Result<(Self, u32)> {
        let geometry = ground.geometry;
        if in_compute {
            let capacity = batch_size(size);
            return Ok((Self::Compute(Box::new(CaptureCompute::new(device, geometry, size, capacity)?)), capacity));
        }
        let desc = CaptureDesc {
            name: "capture",
            views: Views::Hemicube,
            size,
            capacity: batch_size(size),
            identity: true,
            culled: pays_to_cull(device, geometry.triangle_count),
        };
        let capture = Capture::new(device, ground.scene, geometry, ground.textures, desc)?;
        let capacity = capture.desc.capacity;
        Ok((Self::Render(Box::new(capture)), capacity))
    }

    /// Frames to look from.
    pub fn frames(&self) -> &Buffer {
        match self {
            Self::Render(capture) => &capture.frames,
            Self::Compute(capture) => &capture.frames,
        }
    }

    /// What [`crate::passes::integrate`] reads.
    pub fn captured(&self) -> Captured<'_> {
        match self {
            Self::Render(capture) => Captured::Render(capture),
            Self::Compute(capture) => Captured::Compute(capture),
        }
    }

    /// Captures the first `count` frames.
    pub fn record(&self, recording: &mut Recording<'_>, ground: &Ground<'_>, count: u32) -> Result<()> {
        match self {
            Self::Compute(capture) => recording.pass("capture_compute", |c| {
                capture.record(c, count);
                Ok(())
            }),
            Self::Render(capture) => {
                if capture.is_culled() {
                    recording.pass("cull", |c| {
                        capture.record_cull(c, count);
                        Ok(())
                    })?;
                }
                recording.pass("capture", |c| {
                    capture.record(c, ground.geometry, ground.textures, count);
                    Ok(())
                })
            }
        }
    }
}

/// Frames of a batch: about 64 MB of texels with all that goes with them.
fn batch_size(capture_size: u32) -> u32 {
    ((64 << 20) / (capture_size * capture_size * (5 * 8 + 3 * 16))).clamp(1, 1024)
}

//! How a cache is built.

use crate::math::capture::Projection;
use crate::methods::captures::{CaptureMode, CaptureSettings};
use crate::methods::records::Shape;
use crate::passes::integrate::{Gradients, Radius};
use crate::passes::keep_records::Horizon;
use crate::passes::splat::Weight;

/// Texels a side from which captures tell the usual [`CacheSettings::contrast`] from their own error.
pub const CONTRAST_SIZE: f32 = 32.0;

/// How the cache is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CacheSettings {
    /// Ward's a: zones of influence have the radius a·R.
    pub accuracy: f32,
    /// How records look at the scene.
    pub capture: CaptureMode,
    /// Texels a side of a capture; of a hemicube's top.
    pub capture_size: u32,
    /// Most that coarse triangles may be wrong by in captures in compute, in texels; 0: all triangles are drawn.
    pub lod_error: f32,
    /// Whether whole workgroups share each view in compute, though one subgroup could draw it: some devices end one's loops.
    pub share_views: bool,
    /// Gradients to extrapolate with.
    pub gradients: Gradients,
    /// What R is.
    pub radius: Radius,
    /// Smallest radius of a zone of influence as a share of the image's height; never below two pixels.
    pub min_radius: f32,
    /// Largest radius as a share of the image's height; never below the smallest.
    pub max_radius: f32,
    /// Weight of a record at a point.
    pub weight: Weight,
    /// Sum of weights from which a pixel counts as covered.
    pub covered: f32,
    /// √(1 − n·n_k) at which a record's weight has fallen to zero.
    pub normal_limit: f32,
    /// Points are rejected that something hides from a record, where its capture tells: hemicubes do, to the horizon.
    pub hidden: bool,
    /// Zones of new records are clamped by those of their neighbours.
    pub clamped: bool,
    /// Relative standard deviation of what the records of a pixel say above which they are too few; 0: never. Coarse captures
    /// do not tell as little: [`Self::told_contrast`].
    pub contrast: f32,
    /// Most records between two looks for pixels that need one; none: all that a lattice needs.
    pub batch: Option<u32>,
    /// Seed of the hemicubes' turns.
    pub seed: u32,
}

impl CacheSettings {
    /// How captures are made.
    pub fn captures(&self) -> CaptureSettings {
        let Self { capture, capture_size, lod_error, share_views, .. } = *self;
        CaptureSettings { mode: capture, size: capture_size, lod_error, shared: share_views }
    }

    /// What a store keeps of the records of such a cache.
    pub fn kept(&self, has_sky: bool) -> Shape {
        let horizon = self.rejects_hidden().then_some(Horizon { size: self.capture_size });
        Shape { payloads: if has_sky { 2 } else { 1 }, horizon }
    }

    /// The contrast from which records of captures of this size can be told to disagree: c · max(1, [`CONTRAST_SIZE`]/N) with N
    /// texels a side.
    ///
    /// A texel counts as a whole for what its centre sees, so that a sum over texels is wrong where a border passes. A border
    /// passes about N texels, each of which is wrong by a share of its weight, and that falls as 1/N²: together N/N² = 1/N, the
    /// order that the stability suite finds. Records of coarse captures disagree by that without being too few. Finer ones could
    /// be asked for less than c, but c is what matters of a disagreement that more records do remove.
    pub fn told_contrast(&self) -> f32 {
        self.contrast * (CONTRAST_SIZE / self.capture_size as f32).max(1.0)
    }

    /// Whether captures tell what is hidden, and are asked to.
    pub fn rejects_hidden(&self) -> bool {
        self.hidden && self.capture.projection() == Projection::Hemicube
    }
}

//! A view that was stopped before every pixel had its records shows what there is: records stand in where none reaches.

use super::filling::Filling;
use crate::passes::clamp_records::{Reach, Whose};
use crate::passes::splat::View;
use crate::vk::Result;
use crate::vk::pass::Recorder;
use std::f32::consts::PI;

/// Records that stand in at a pixel, on average.
const LAYERS: f32 = 8.0;
/// Records that stand in anywhere: the first ones lie all over the image.
const FIRST: u32 = 16;
/// Radius of their zones in diagonals of the image: from a near record to what lies far behind it.
const FAR: f32 = 16.0;
/// Limits of √(1 − n·n_k): any normal on the same side, and any at all.
const SAME_SIDE: f32 = 1.5;
const ANY: f32 = 0.0;

impl Filling<'_> {
    /// Splats what there is with wide zones, with so little weight that nothing changes where records reach.
    pub(super) fn stand_in(&self, recorder: &mut Recorder) -> Result<()> {
        let [width, height] = self.gbuffer.position.desc.size.map(|side| side as f32);
        let count = self.store.count();
        let wide = (LAYERS * width * height / (PI * count as f32)).sqrt().max(self.cache.reach.max);
        let (first, whole) = (count.min(FIRST), FAR * width.hypot(height));
        let steps = [(count, wide, SAME_SIDE, 1e-3), (first, whole, SAME_SIDE, 1e-6), (first, whole, ANY, 1e-9)];
        recorder.submit(|recording| {
            for (count, pixels, normal_limit, share) in steps {
                let reach = Reach { min: pixels, max: pixels, ..self.cache.reach };
                let view = View { normal_limit, share, ..self.viewpoint.view };
                self.splat(recording, (0..count, Whose::Old), (reach, &view))?;
            }
            Ok(())
        })
    }
}

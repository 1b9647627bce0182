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
const FIRST: u32 = 32;
/// Limit of √(1 − n·n_k) there: any normal on the same side.
const ANY_NORMAL: f32 = 1.5;

impl Filling<'_> {
    /// Splats what there is with wide zones, with so little weight that nothing changes where records reach.
    pub(super) fn stand_in(&self, recorder: &mut Recorder) -> Result<()> {
        let [width, height] = self.gbuffer.position.desc.size.map(|side| side as f32);
        let count = self.store.count();
        let wide = (LAYERS * width * height / (PI * count as f32)).sqrt().max(self.cache.reach.max);
        let steps = [(count, wide, 1e-3), (count.min(FIRST), 2.0 * width.hypot(height), 1e-6)];
        recorder.submit(|recording| {
            for (count, pixels, share) in steps {
                let reach = Reach { min: pixels, max: pixels, ..self.cache.reach };
                let view = View { normal_limit: ANY_NORMAL, share, ..self.viewpoint.view };
                self.splat(recording, (0..count, Whose::Old), (reach, &view))?;
            }
            Ok(())
        })
    }
}

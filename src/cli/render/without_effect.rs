//! Flags that do nothing in this run: each gets a note.

use super::Kind;
use super::args::RenderArgs;
use crate::cli::choices::CaptureArg;

impl RenderArgs {
    /// A note for each given flag that has no effect on a picture of this `kind`.
    pub(super) fn without_effect(&self, kind: Kind) -> Vec<String> {
        let (linear, exr) = (kind.is_linear(), kind == Kind::Exr);
        let (plane, slices) = (self.capture == CaptureArg::Plane, self.capture == CaptureArg::Slices);
        let background = self.scene.background.is_some();
        let flags = [
            ("--exposure", self.exposure.is_some() && linear, "the file holds radiance"),
            ("--tone", self.tone.is_some() && linear, "the file holds radiance"),
            ("--layers", self.layers.is_some() && !exr, "only an EXR has layers"),
            ("--aperture", self.aperture.is_some() && !plane, "it belongs to --capture plane"),
            ("--compensation", self.compensation.is_some() && !plane, "it belongs to --capture plane"),
            ("--slices", self.slices.is_some() && !slices, "it belongs to --capture slices"),
            ("--slices-near", self.slices_near.is_some() && !slices, "it belongs to --capture slices"),
            ("--background-rotation", self.scene.background_rotation != 0.0 && !background, "there is no --background"),
            ("--background-strength", self.scene.background_strength != 1.0 && !background, "there is no --background"),
        ];
        let given = flags.into_iter().filter(|(_, in_vain, _)| *in_vain);
        given.map(|(flag, _, why)| format!("{flag} has no effect: {why}")).collect()
    }
}

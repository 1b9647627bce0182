//! What captures where captures in compute turn out not to.

use super::memory::TooLarge;
use super::plan::Plan;
use super::{RenderError, Settings};
use crate::methods::captures::CaptureMode;
use crate::vk::Error as VulkanError;

const LOOPS_ENDED: &str = "the device ended the loops of captures in compute before all was drawn";

/// What captures instead of what was planned.
pub(super) enum Fallback {
    /// Whole workgroups, for the device had ended the loops of captures in compute.
    Workgroups,
    /// Render passes, for that reason.
    RenderPasses,
    /// Render passes, for captures in compute took too much memory.
    TooLarge(TooLarge),
}

impl Fallback {
    /// Where the device ended the loops of captures in compute, which workgroups `shared` or not; the error where nothing is left.
    pub(super) fn of_loops(shared: bool, settings: &Settings) -> Result<Self, RenderError> {
        match (shared, settings.cache.capture) {
            (false, _) => Ok(Self::Workgroups),
            (true, CaptureMode::Auto) => Ok(Self::RenderPasses),
            (true, _) => Err(VulkanError::LoopsEnded { shared }.into()),
        }
    }

    /// Where the scene is too large; the error where nothing is left.
    pub(super) fn of_memory(error: TooLarge, settings: &Settings) -> Result<Self, RenderError> {
        if settings.cache.capture == CaptureMode::Auto { Ok(Self::TooLarge(error)) } else { Err(error.into()) }
    }

    /// Changes the settings so.
    pub(super) fn apply(&self, settings: &mut Settings) {
        match self {
            Self::Workgroups => settings.cache.share_views = true,
            Self::RenderPasses | Self::TooLarge(_) => settings.cache.capture = CaptureMode::Hemicube,
        }
    }

    /// The plan as it is then.
    pub(super) fn plan(&self, plan: Plan) -> Plan {
        if matches!(self, Self::Workgroups) { plan } else { plan.of_render_passes(&self.why()) }
    }

    /// What the user is told.
    pub(super) fn warning(&self) -> String {
        let by = match self {
            Self::Workgroups => "whole workgroups drew the frame anew",
            Self::RenderPasses => "render passes drew the frame anew; --capture hemicube takes them at once",
            Self::TooLarge(_) => "render passes drew the frame",
        };
        format!("{}, and {by}", self.why())
    }

    fn why(&self) -> String {
        match self {
            Self::TooLarge(error) => format!("captures in compute do not fit: {error}"),
            Self::Workgroups | Self::RenderPasses => LOOPS_ENDED.into(),
        }
    }
}

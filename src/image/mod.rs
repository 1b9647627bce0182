//! Pictures: layered float images, EXR and PNG files, tone mapping, error metrics.

use std::collections::BTreeMap;

/// A float image of named channels (`R`, `direct.G`, `N.X`, `Z`, …), each `width × height`, row 0 at the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Channel name as in the EXR file, to its pixels.
    pub channels: BTreeMap<String, Vec<f32>>,
}

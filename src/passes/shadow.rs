//! What receivers of shadowed light read: `glsl/inc/shadow.glsl`.

use super::capture::Capture;
use crate::vk::{Binding, Buffer, Image, Sampler};

/// Kinds of light samples (`glsl/shared/types.glsl`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// Radiant intensity from a point.
    Point,
    /// The same within a cone.
    Spot,
    /// A piece of an emissive triangle.
    Area,
}

impl LightKind {
    /// Value of the shaders' `LIGHT_KIND`.
    pub fn code(self) -> u32 {
        match self {
            Self::Directional => 0,
            Self::Point => 1,
            Self::Spot => 2,
            Self::Area => 3,
        }
    }
}

/// How far receivers stand off their surface.
#[derive(Clone, Copy, Debug)]
pub struct Lift {
    /// Centre and radius of the scene's core.
    pub ball: [f32; 4],
    /// Relative to the radius within it, to the distance from its centre beyond.
    pub share: f32,
}

/// A batch of light samples and their shadow views.
pub struct Shadow<'a> {
    /// Kind of the samples.
    pub kind: LightKind,
    /// Their views, with identities.
    pub capture: &'a Capture,
    /// The samples.
    pub lights: &'a Buffer,
    /// Reads their depths, nearest.
    pub sampler: &'a Sampler,
    /// All triangles and their neighbours.
    pub triangles: &'a Image,
    /// Number of triangles without an alpha mask.
    pub opaque: u32,
    /// They are the receivers' own surface, not a coarser one that stands for it.
    pub own: bool,
}

impl Shadow<'_> {
    /// Bindings 0–4 of the receivers' set.
    pub fn bindings(&self) -> [Binding<'_>; 5] {
        [
            Binding::Storage(self.lights),
            Binding::Storage(&self.capture.frames),
            Binding::Sampled(&self.capture.depth, self.sampler.raw()),
            Binding::Texels(&self.capture.identity),
            Binding::Texels(self.triangles),
        ]
    }

    /// Constants LIGHT_KIND, SHADOW_VIEWS, SHADOW_SIZE, SHADOW_COLUMNS, SHADOW_ROWS and SHADOW_OPAQUE.
    pub fn constants(&self) -> [u32; 6] {
        let Capture { desc, columns, depth, .. } = self.capture;
        [self.kind.code(), desc.views.code(), desc.size, *columns, depth.desc.size[1] / desc.size, self.opaque]
    }
}

//! The views of a frame: `glsl/inc/views.glsl`.

/// The views of a frame (`glsl/shared/types.glsl`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Views {
    /// Five faces, the sides cut at the horizon.
    Hemicube,
    /// Six faces.
    Cube,
    /// One perspective view along the axis.
    Plane,
    /// One parallel view along the axis.
    Orthographic,
    /// One view of all above the axis's horizon, projected onto the disc below it.
    Hemisphere,
}

impl Views {
    /// Number of views.
    pub fn count(self) -> u32 {
        match self {
            Self::Hemicube => 5,
            Self::Cube => 6,
            Self::Plane | Self::Orthographic | Self::Hemisphere => 1,
        }
    }

    /// Value of the shaders' `VIEWS`.
    pub fn code(self) -> u32 {
        match self {
            Self::Hemicube => 0,
            Self::Cube => 1,
            Self::Plane => 2,
            Self::Orthographic => 3,
            Self::Hemisphere => 4,
        }
    }
}

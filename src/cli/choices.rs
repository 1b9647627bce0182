//! The values of flags that several subcommands have.

use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE, SLICES, SLICES_NEAR};

/// `--capture`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CaptureArg {
    /// Compute if it fits, else render passes
    Auto,
    /// Multi-view hemicubes by render passes
    Hemicube,
    /// One perspective view along the normal
    Plane,
    /// One view, projected from the hemisphere onto its disc; needs small triangles
    Hemisphere,
    /// Hemicubes rasterised in compute, in shared memory
    Compute,
    /// The hemisphere's projection, rasterised in compute; any triangles
    ComputeHemisphere,
    /// Hemicubes in compute for near triangles; slices of voxels replace distant ones
    Slices,
}

/// What `--capture` leaves to other flags.
#[derive(Clone, Copy, Debug)]
pub struct CaptureOptions {
    /// Full angle that a plane sees along each axis, in degrees.
    pub aperture: f64,
    /// Whether the texels at a plane's border stand for what it does not see.
    pub compensated: bool,
    /// Voxels of slices along the scene's longest side.
    pub slices: u32,
    /// How many voxels away triangles are drawn as they are beside slices.
    pub slices_near: f32,
}

impl Default for CaptureOptions {
    fn default() -> Self {
        Self { aperture: PLANE_APERTURE, compensated: true, slices: SLICES, slices_near: SLICES_NEAR }
    }
}

impl CaptureArg {
    /// Takes all but `auto`: what something is measured by has a name.
    pub fn by_name() -> impl TypedValueParser<Value = Self> {
        let all = Self::value_variants().iter().filter(|capture| **capture != Self::Auto);
        PossibleValuesParser::new(all.filter_map(Self::to_possible_value)).try_map(|name| Self::from_str(&name, false))
    }

    /// How a record captures the scene.
    pub fn mode(self, options: &CaptureOptions) -> CaptureMode {
        let CaptureOptions { aperture, compensated, slices, slices_near } = *options;
        match self {
            Self::Auto => CaptureMode::Auto,
            Self::Hemicube => CaptureMode::Hemicube,
            Self::Plane => CaptureMode::Plane { aperture, compensated },
            Self::Hemisphere => CaptureMode::Hemisphere,
            Self::Compute => CaptureMode::Compute,
            Self::ComputeHemisphere => CaptureMode::ComputeHemisphere,
            Self::Slices => CaptureMode::Slices { across: slices, near: slices_near },
        }
    }
}

/// `--gradients`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GradientsArg {
    /// Constant irradiance in each zone
    None,
    /// By the normal's turn
    Rotation,
    /// By the point's move
    Translation,
    /// Both
    Both,
}

impl GradientsArg {
    /// Whether that by the normal's turn, and that by the point's move, is among them.
    pub fn has(self) -> [bool; 2] {
        [Self::Rotation, Self::Translation].map(|kind| [kind, Self::Both].contains(&self))
    }
}

/// `--weight`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WeightArg {
    /// Bounded, zero at the zone's border (Tabellion and Lamorlette 2004)
    Bounded,
    /// Ward, Rubinstein and Clear 1988
    Ward,
}

/// The value of a flag that chooses `value`.
pub fn name_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().into())
}

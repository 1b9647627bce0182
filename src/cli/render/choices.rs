//! The values of flags that choose among a few.

use clap::ValueEnum;

/// `--capture`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CaptureArg {
    /// In compute on a CPU device where that fits, else by render passes
    Auto,
    /// Multi-view hemicubes by render passes
    Hemicube,
    /// One perspective view along the normal, of --aperture
    Plane,
    /// One view projected onto the disc below the hemisphere; wants triangles that are small as seen from everywhere
    Hemisphere,
    /// Hemicubes rasterised in compute, in shared memory
    Compute,
    /// The hemisphere's projection rasterised in compute; triangles stay as they are
    ComputeHemisphere,
    /// Hemicubes in compute of what is near; what is far is seen as slices of voxels (--slices, --slices-near)
    Slices,
}

/// `--compensation`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompensationArg {
    /// The texels at the border stand for what lies between them and the horizon
    On,
    /// What is not seen is black
    Off,
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

/// `--radius`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RadiusArg {
    /// Harmonic mean distance of what the record sees, limited by its gradient (Ward 1988)
    Harmonic,
    /// Where the second derivatives of the irradiance make extrapolation wrong; harmonic without a translation gradient
    Hessian,
}

/// `--weight`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WeightArg {
    /// Bounded, zero at the zone's border (Tabellion and Lamorlette 2004)
    Bounded,
    /// Ward, Rubinstein and Clear 1988
    Ward,
}

/// `--neighbours`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NeighboursArg {
    /// It does not: what shortens one zone is near the other (Křivánek et al. 2006)
    Clamp,
    /// It may
    Free,
}

/// `--hidden`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HiddenArg {
    /// The record does not light the point: no light passes thin walls
    Reject,
    /// It does, if place and normal fit
    Allow,
}

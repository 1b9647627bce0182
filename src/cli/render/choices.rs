//! The values of flags that choose among a few.

use clap::ValueEnum;

/// `--compensation`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompensationArg {
    /// The texels at the border stand for what lies between them and the horizon
    On,
    /// What is not seen is black
    Off,
}

/// `--radius`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RadiusArg {
    /// Harmonic mean distance of what the record sees, limited by its gradient (Ward 1988)
    Harmonic,
    /// Where the second derivatives of the irradiance make extrapolation wrong; harmonic without a translation gradient
    Hessian,
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

/// `--bounce-solver`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SolverArg {
    /// One bounce after the other
    Plain,
    /// GMRES (Saad and Schultz 1986)
    Accelerated,
}

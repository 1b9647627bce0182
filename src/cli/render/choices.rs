//! The values of flags that choose among a few.

use clap::ValueEnum;

/// `--compensation`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompensationArg {
    /// Texels at the border are weighted for the directions between them and the horizon
    On,
    /// Directions outside the plane are black
    Off,
}

/// `--radius`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RadiusArg {
    /// Harmonic mean distance of the surfaces around the record, limited by its gradient (Ward 1988)
    Harmonic,
    /// By the second derivatives of the irradiance (Jarosz et al. 2012); harmonic without a translation gradient
    Hessian,
}

/// `--neighbours`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NeighboursArg {
    /// Shorten a new record's radius to fit its neighbours (Křivánek et al. 2006)
    Clamp,
    /// No clamping
    Free,
}

/// `--hidden`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HiddenArg {
    /// The record does not contribute: no light passes through thin walls
    Reject,
    /// The record contributes if position and normal fit
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

//! Volumes in the formats of engines: a uniform grid of samples, in each engine's own units, order and axes.
//!
//! | engine | file | value |
//! |---|---|---|
//! | Bevy | KTX2, a 3D texture with shared exponents ([`bevy`]) | E/π on six faces of a cube, fitted to Bevy's own rule |
//! | three.js | JSON | coefficients of the radiance, for `LightProbe.sh.fromArray` |
//! | Godot | `.tres`, a `LightmapGIData` ([`godot`]) | coefficients of the radiance over π, with tetrahedra |
//! | Unity | JSON | E/π as a polynomial, the x axis flipped as glTFast flips it, for `SphericalHarmonicsL2` |

pub mod bevy;
pub mod godot;
pub mod measures;
pub mod rgb9e5;
#[cfg(test)]
mod tests;

use super::reader::ReadSettings;
use super::{Interpolation, Reader, State, Volume};
use crate::image::write::{WriteError, write_atomic};
use crate::math::sh;
use glam::{DVec3, UVec3};
use serde_json::{Value, json};
use std::path::Path;

/// An engine whose format can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Bevy's `IrradianceVolume`.
    Bevy,
    /// three.js' `LightProbe`s.
    Three,
    /// Godot's `LightmapGIData`.
    Godot,
    /// Unity's `SphericalHarmonicsL2`.
    Unity,
}

impl Engine {
    /// The extension of the engine's file, without a dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Bevy => "ktx2",
            Self::Godot => "tres",
            Self::Three | Self::Unity => "json",
        }
    }
}

/// Nine coefficients of the radiance, W·sr⁻¹·m⁻², for the three colour channels.
pub type Light = [DVec3; 9];

/// A uniform grid of samples: rows along x, then y, then z; the outermost samples lie on the faces of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Number of samples along each axis.
    pub counts: UVec3,
    /// Position of the first sample, in the scene's coordinates.
    pub low: DVec3,
    /// Distance of neighbouring samples along each axis.
    pub spacing: DVec3,
    /// Light of the samples.
    pub lights: Vec<Light>,
}

impl Grid {
    /// The grid of a volume's finest cells. Engines interpolate between all samples, so one inside of geometry gets the mean of its
    /// neighbours instead of darkness.
    pub fn of(volume: &Volume) -> Self {
        let lattice = &volume.lattice;
        let cells = lattice.divisions << lattice.levels;
        let counts = cells + 1;
        let known = super::tree::corners_of(lattice);
        let reader = Reader::new(volume);
        let settings = ReadSettings { interpolation: Interpolation::default(), guard: true };
        let mut lights: Vec<Option<Light>> = Vec::new();
        for i in 0..counts.element_product() {
            let corner = UVec3::new(i % counts.x, i / counts.x % counts.y, i / counts.x / counts.y);
            let sample = known.get(&corner).map(|number| &volume.samples[*number as usize]);
            lights.push(match sample {
                Some(sample) if sample.state == State::Inside => None,
                Some(sample) => Some(nine(sample.coefficients.iter().map(|c| c.as_dvec3()))),
                None => reader.read(lattice.place(corner), settings).ok().map(|read| nine(read.into_iter())),
            });
        }
        let lights = filled(lights, counts);
        Self { counts, low: lattice.low, spacing: lattice.size(lattice.levels), lights }
    }

    /// Position of a sample, in the scene's coordinates.
    pub fn place(&self, number: usize) -> DVec3 {
        let (n, i) = (self.counts, number as u32);
        self.low + UVec3::new(i % n.x, i / n.x % n.y, i / n.x / n.y).as_dvec3() * self.spacing
    }

    fn places(&self) -> Vec<[f64; 3]> {
        (0..self.lights.len()).map(|i| self.place(i).to_array()).collect()
    }
}

/// The first nine coefficients, filled up with zeros.
fn nine(coefficients: impl Iterator<Item = DVec3>) -> Light {
    let mut light = [DVec3::ZERO; 9];
    light.iter_mut().zip(coefficients).for_each(|(to, from)| *to = from);
    light
}

/// Fills gaps with the mean of their neighbours along the axes, round by round.
fn filled(mut lights: Vec<Option<Light>>, counts: UVec3) -> Vec<Light> {
    let steps = [1, counts.x as usize, (counts.x * counts.y) as usize];
    let neighbours = |i: usize| {
        let at = [i % steps[1], i % steps[2] / steps[1], i / steps[2]];
        (0..3).flat_map(move |axis| {
            let less = (at[axis] > 0).then(|| i - steps[axis]);
            let more = (at[axis] + 1 < counts[axis] as usize).then(|| i + steps[axis]);
            less.into_iter().chain(more)
        })
    };
    while lights.iter().any(Option::is_none) {
        let before = lights.clone();
        for (i, light) in lights.iter_mut().enumerate().filter(|(_, light)| light.is_none()) {
            let known: Vec<&Light> = neighbours(i).filter_map(|n| before[n].as_ref()).collect();
            if !known.is_empty() {
                let mean = |c: usize| known.iter().map(|light| light[c]).sum::<DVec3>() / known.len() as f64;
                *light = Some(std::array::from_fn(mean));
            }
        }
        if lights == before {
            break;
        }
    }
    lights.into_iter().map(Option::unwrap_or_default).collect()
}

/// Writes a grid in the format of an engine: the whole file, or nothing.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, grid: &Grid, engine: Engine) -> Result<(), WriteError> {
    write_atomic(path, |sink| match engine {
        Engine::Bevy => sink.write_all(&bevy::file(grid)),
        Engine::Three => writeln!(sink, "{}", three(grid)),
        Engine::Godot => sink.write_all(godot::resource(grid).as_bytes()),
        Engine::Unity => writeln!(sink, "{}", unity(grid)),
    })
}

fn three(grid: &Grid) -> Value {
    let probe = |light: &Light| light.iter().flat_map(DVec3::to_array).map(|v| v as f32).collect::<Vec<_>>();
    json!({
        "engine": "three",
        "about": "radiance as spherical harmonics: new THREE.SphericalHarmonics3().fromArray(probes[i])",
        "counts": grid.counts.to_array(), "low": grid.low.to_array(), "spacing": grid.spacing.to_array(),
        "positions": grid.places(),
        "probes": grid.lights.iter().map(probe).collect::<Vec<_>>(),
    })
}

fn unity(grid: &Grid) -> Value {
    let probe = |light: &Light| {
        let light = measures::unity(light);
        let channel = |c: usize| light.iter().map(|v| v[c] as f32).collect::<Vec<_>>();
        [0, 1, 2].map(channel)
    };
    let flipped: Vec<[f64; 3]> = grid.places().into_iter().map(|[x, y, z]| [-x, y, z]).collect();
    json!({
        "engine": "unity",
        "about": "SphericalHarmonicsL2 sh: sh[channel, i] = probes[n][channel][i]; x is flipped, as by glTFast",
        "counts": grid.counts.to_array(),
        "positions": flipped,
        "probes": grid.lights.iter().map(probe).collect::<Vec<_>>(),
    })
}

/// E/π in a direction, by harmonics.
pub fn e_over_pi(light: &Light, n: DVec3) -> DVec3 {
    let channel = |c: usize| sh::irradiance(&light.map(|v| v[c]), n) / std::f64::consts::PI;
    DVec3::from([0, 1, 2].map(channel))
}

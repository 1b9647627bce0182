//! The places of the surface cache: where they are, how far each reaches, and what each sees.

use super::numbers::{NOTHING, Seen};
use super::sides::{Point, Sides};
use crate::math::capture::Table;
use crate::methods::probes::{Place as Looking, frame};
use crate::passes::geometry::Geometry;
use crate::vk::gpu_types::Frame;
use glam::{DVec2, IVec3, Vec3};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// Azimuths that texels next to the horizon are looked up by.
const AZIMUTHS: usize = 256;
/// A place reaches this share of the harmonic mean distance of what it sees, as a record of the picture does (Ward 1988).
const ACCURACY: f32 = 0.35;
/// Nor less than this share of the largest reach.
const LEAST: f32 = 0.5;
/// Distance of a point from a plane, relative to the distance of places, that rounding may make.
const GRAIN: f32 = 1e-4;

/// A place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) point: Point,
    /// Distance at which its weight has fallen to zero.
    pub(super) reach: f32,
    tangent: Vec3,
    bitangent: Vec3,
}

/// All places and what they see.
pub(super) struct Places {
    pub(super) all: Vec<Place>,
    /// The side that each texel of each place sees.
    pub(super) seen: Vec<u32>,
    /// Weight of each texel of a capture: the integral of the cosine over its directions.
    pub(super) weights: Vec<f32>,
    /// Texels next to the horizon, and the one of each azimuth.
    horizon: Vec<usize>,
    by_azimuth: Vec<usize>,
    /// Triangle plus 1 that each texel next to the horizon of each place sees; 0 where there is none.
    walls: Vec<u32>,
    voxels: HashMap<IVec3, Vec<u32>>,
    /// Side of a voxel: no place reaches further.
    pub(super) voxel: f32,
}

impl Places {
    /// None yet; no place will reach further than `voxel`.
    pub(super) fn new(table: &Table, voxel: f32) -> Self {
        let is_low = |i: &usize| table.texels[*i].layer > 0 && is_last_row(table, *i);
        let horizon: Vec<usize> = (0..table.texels.len()).filter(is_low).collect();
        let nearest = |bin: usize| {
            let way = azimuth_middle(bin);
            let along = |slot: &usize| {
                let d = table.texels[horizon[*slot]].direction;
                DVec2::new(d.x, d.y).normalize().dot(way)
            };
            (0..horizon.len()).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or(0)
        };
        let by_azimuth = (0..AZIMUTHS).map(nearest).collect();
        let weights = table.texels.iter().map(|t| t.weight() as f32).collect();
        let (all, seen, walls, voxels) = (Vec::new(), Vec::new(), Vec::new(), HashMap::new());
        Self { all, seen, weights, horizon, by_azimuth, walls, voxels, voxel }
    }

    /// Where a place is to look from; every one is turned by another angle.
    pub(super) fn frame(&self, point: &Point, number: usize, geometry: &Geometry) -> Frame {
        let Point { position, normal, geometric } = *point;
        // Golden angles: no two neighbours look along the same axes.
        let turn = (number as f32 * 0.618_034).fract() * TAU;
        frame(&Looking { position, normal, geometric, turn }, geometry, 1.0)
    }

    /// Adds a place that was captured; its reach follows from the distances that it sees.
    pub(super) fn add(&mut self, point: Point, frame: &Frame, seen: &Seen<'_>, sides: &Sides<'_>) {
        let most = self.voxel;
        let axis = |a: [f32; 4]| Vec3::new(a[0], a[1], a[2]);
        let closeness: f32 = (0..self.weights.len()).map(|i| self.weights[i] * seen.inverse_distance(i)).sum();
        let wanted = if closeness > 0.0 { ACCURACY * PI / closeness } else { most };
        let reach = wanted.clamp(LEAST * most, most);
        let number = self.all.len() as u32;
        self.voxels.entry(self.voxel_of(point.position)).or_default().push(number);
        self.all.push(Place { point, reach, tangent: axis(frame.tangent), bitangent: axis(frame.bitangent) });
        self.seen.extend((0..self.weights.len()).map(|i| seen.side(i)));
        let wall = |i: &usize| {
            Some(seen.side(*i)).filter(|side| *side != NOTHING).map_or(0, |s| sides.triangle(sides.of_cell(s)) + 1)
        };
        self.walls.extend(self.horizon.iter().map(wall));
    }

    /// What the texels of a place see.
    pub(super) fn seen_by(&self, place: usize) -> &[u32] {
        &self.seen[place * self.weights.len()..][..self.weights.len()]
    }

    pub(super) fn voxel_of(&self, position: Vec3) -> IVec3 {
        (position / self.voxel).floor().as_ivec3()
    }

    /// Calls `hear` with every place that may reach into a voxel.
    pub(super) fn near(&self, voxel: IVec3, mut hear: impl FnMut(u32)) {
        for z in -1..=1 {
            for (y, x) in [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 0), (0, 1), (1, -1), (1, 0), (1, 1)] {
                self.voxels.get(&(voxel + IVec3::new(x, y, z))).into_iter().flatten().for_each(|place| hear(*place));
            }
        }
    }

    /// Whether something that the place sees next to its horizon stands between it and a point: the plane of the triangle that it
    /// sees there separates the two.
    pub(super) fn hides(&self, place: u32, point: Vec3, sides: &Sides<'_>) -> bool {
        let at = &self.all[place as usize];
        let way = point - at.point.position;
        let (x, y) = (way.dot(at.tangent), way.dot(at.bitangent));
        let slot = self.by_azimuth[azimuth_bin(x, y)];
        let wall = self.walls[place as usize * self.horizon.len() + slot];
        if wall == 0 {
            return false;
        }
        let (corner, normal) = sides.plane(wall - 1);
        let (from, to) = ((at.point.position - corner).dot(normal), (point - corner).dot(normal));
        let grain = GRAIN * self.voxel;
        (from > grain && to < -grain) || (from < -grain && to > grain)
    }
}

/// Azimuths are told apart by the point where they leave the square |x| + |y| = 1, which takes no arctangent.
fn azimuth_bin(x: f32, y: f32) -> usize {
    let along = y / (x.abs() + y.abs()).max(f32::MIN_POSITIVE);
    let turn = if x >= 0.0 { 1.0 + along } else { 3.0 - along };
    ((turn * (AZIMUTHS as f32 / 4.0)) as usize).min(AZIMUTHS - 1)
}

/// A unit vector in the middle of a bin.
fn azimuth_middle(bin: usize) -> DVec2 {
    let turn = 4.0 * (bin as f64 + 0.5) / AZIMUTHS as f64;
    let way = if turn <= 2.0 {
        DVec2::new(1.0 - (turn - 1.0).abs(), turn - 1.0)
    } else {
        DVec2::new((turn - 3.0).abs() - 1.0, 3.0 - turn)
    };
    way.normalize()
}

/// Whether a texel of a side face is one of its lowest.
fn is_last_row(table: &Table, i: usize) -> bool {
    let texel = &table.texels[i];
    !table.texels.iter().any(|other| other.layer == texel.layer && other.y > texel.y)
}

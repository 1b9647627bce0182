//! Sets of light samples that are drawn alike, and the frames that their shadows are looked at from.

use super::far_view::Seen;
use crate::math::core::Core;
use crate::passes::geometry::Geometry;
use crate::passes::shadow::LightKind;
use crate::passes::views::Views;
use crate::vk::gpu_types::{EmitterFace, Frame, LightSample};
use glam::{Vec3, Vec4};
use std::ops::Range;

/// Samples that share a kind, a kind of shadow view and a shadow size.
#[derive(Clone, Debug)]
pub struct LightSet {
    /// What is sampled, in words.
    pub name: &'static str,
    /// Kind of all samples.
    pub kind: LightKind,
    /// Views of their shadows.
    pub views: Views,
    /// Texels a side of a shadow view.
    pub shadow_size: u32,
    /// Where each sample looks from.
    pub frames: Vec<Frame>,
    /// The samples.
    pub samples: Vec<LightSample>,
    /// Emissive triangles whose samples these are, one after the other; empty where samples stand for several triangles.
    pub faces: Vec<Face>,
    /// Lights the surface cells only.
    pub cells_only: bool,
    /// Of how many samples a surface cell takes one, others than its neighbours do.
    pub stride: u32,
}

impl LightSet {
    pub(super) fn empty(name: &'static str, kind: LightKind, views: Views, shadow_size: u32) -> Self {
        Self {
            name,
            kind,
            views,
            shadow_size,
            frames: vec![],
            samples: vec![],
            faces: vec![],
            cells_only: false,
            stride: 1,
        }
    }

    /// Scale that leaves two texels around each face of a cube, so that what lies beyond its edge is seen from both sides.
    pub(super) fn guard(&self) -> f32 {
        1.0 - 4.0 / self.shadow_size as f32
    }

    pub(super) fn push(&mut self, frame: Frame, sample: LightSample) {
        self.frames.push(frame);
        self.samples.push(sample);
    }
}

/// A side of an emissive triangle that has samples of its own.
#[derive(Clone, Debug)]
pub struct Face {
    /// Corners, counter-clockwise seen from where it shines.
    pub corners: [Vec3; 3],
    /// Its samples in the set.
    pub samples: Range<u32>,
}

impl Face {
    /// The faces of a batch that holds the samples `batch` of the set.
    pub fn of_batch(faces: &[Self], batch: &Range<u32>) -> Vec<EmitterFace> {
        let in_batch = |face: &Self| {
            let (first, end) = (face.samples.start.max(batch.start), face.samples.end.min(batch.end));
            (first < end).then(|| {
                let [a, b, c] = face.corners;
                let share = (end - first) as f32 / face.samples.len() as f32;
                EmitterFace {
                    a: with(a, share),
                    b: with(b, f32::from_bits(first - batch.start)),
                    c: with(c, f32::from_bits(end - first)),
                }
            })
        };
        faces.iter().filter_map(in_batch).collect()
    }
}

/// How finely lights are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSettings {
    /// Samples of all emissive triangles together; more where each triangle needs one of its own.
    pub area_samples: u32,
    /// Parallel lights that stand for the sky on the surface cells.
    pub sky_samples: u32,
    /// Texels a side of the shadow view of an area sample; punctual lights have larger ones in proportion.
    pub shadow_size: u32,
}

/// Extent of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Lowest and highest corner of the bounding box.
    pub bounds: [Vec3; 2],
    /// Half its diagonal.
    pub radius: f32,
    /// What of it lies together.
    pub core: Core,
}

impl Extent {
    /// That of a surface.
    pub fn of(geometry: &Geometry) -> Self {
        Self { bounds: geometry.bounds, radius: geometry.radius, core: geometry.core }
    }

    /// Near distance of a light at `place`: nearer nothing casts a shadow.
    pub(super) fn near(&self, place: Vec3) -> f32 {
        NEAR * self.core.scale_at(place)
    }
}

/// Near distance of lights relative to the size of what is near them.
const NEAR: f32 = 1.0 / 65536.0;

pub(super) fn parallel_sample(direction: Vec3, irradiance: Vec3) -> LightSample {
    LightSample { direction: with(direction, 0.0), power: with(irradiance, 0.0), ..Default::default() }
}

/// A view along `direction` that holds the whole bounding box. Its origin is at the far end, where the reversed depth is 0.
pub(super) fn parallel_frame(direction: Vec3, extent: Extent) -> Frame {
    let (tangent, bitangent) = direction.any_orthonormal_pair();
    // any_orthonormal_pair gives (a, b) with a × b = direction up to sign; the views need t × b = n.
    let bitangent = if tangent.cross(bitangent).dot(direction) > 0.0 { bitangent } else { -bitangent };
    let [low, high] = extent.bounds;
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let reach = |axis: Vec3| (axis.abs().dot(half) * 1.001).max(extent.radius * 1e-4);
    let origin = centre + direction * reach(direction);
    Frame {
        origin: with(origin, 0.0),
        tangent: with(tangent, 1.0 / reach(tangent)),
        bitangent: with(bitangent, 1.0 / reach(bitangent)),
        normal: with(direction, 0.5 / reach(direction)),
        horizon: [0.0, 0.0, 0.0, 1.0],
    }
}

/// A view along `direction` of a ball, deep enough for all that stands before it. Its far end is the ball's: depths near 0, which
/// single precision tells apart best, are those in the ball.
pub(super) fn parallel_view(direction: Vec3, extent: Extent, centre: Vec3, radius: f32) -> Frame {
    let whole = parallel_frame(direction, extent);
    let reach = 1.02 * radius;
    let origin = centre + direction * reach;
    let front = Vec3::from_slice(&whole.origin[..3]) - direction / whole.normal[3];
    let depth = (origin - front).dot(direction).max(2.0 * reach);
    let [tangent, bitangent] = [whole.tangent, whole.bitangent].map(|[x, y, z, _]| [x, y, z, 1.0 / reach]);
    Frame { origin: with(origin, 0.0), tangent, bitangent, normal: with(direction, 1.0 / depth), ..whole }
}

pub(super) fn frame(origin: Vec3, axis: Vec3, near: f32, scale: f32) -> Frame {
    let tangent = axis.any_orthonormal_vector();
    Frame {
        origin: with(origin, near),
        tangent: with(tangent, scale),
        bitangent: with(axis.cross(tangent), scale),
        normal: with(axis, 1.0),
        horizon: [0.0, 0.0, 0.0, 1.0],
    }
}

/// The sample with the shell that `seen` is for.
pub(super) fn for_shell(sample: LightSample, seen: Seen<'_>) -> LightSample {
    let [inner, outer] = match seen {
        Seen::Around(shell) => shell,
        Seen::Towards(receivers) => receivers.shell,
    };
    LightSample { shell: [inner, outer, 0.0, 0.0], ..sample }
}

pub(super) fn with(v: Vec3, w: f32) -> [f32; 4] {
    Vec4::from((v, w)).to_array()
}

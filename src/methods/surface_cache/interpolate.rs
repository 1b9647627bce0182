//! Irradiance of a patch from that of places near it.
//!
//! Weights are those of a linear fit in the tangent plane (moving least squares, Lancaster and Salkauskas 1981), with negative
//! ones set to zero and their sum to 1: the irradiance of a patch is a mean of that of places, so that energy never grows.

use super::places::{Place, Places};
use super::sides::{Point, Sides};
use glam::IVec3;

/// Sum of weights from which a patch counts as covered.
pub(super) const COVERED: f32 = 0.2;
/// Cosine between normals at which a weight has fallen to zero.
const LEAST_COSINE: f32 = 0.5;
/// A place lies on another surface where it is further off the plane between the two than this share of its distance.
const STEEPEST: f32 = 0.2;
/// Added to the second moments, as a share of the reach: places in a row tell nothing about what lies across it.
const STIFFNESS: f32 = 0.02;

/// Weights of places at points of the surface, one after the other; quick where these lie close to each other.
pub(super) struct Interpolator<'a> {
    places: &'a Places,
    sides: &'a Sides<'a>,
    /// Voxel that the places in `near` are of; triangle and side that the candidates are of.
    voxel: Option<IVec3>,
    near: Vec<u32>,
    at: Option<(u32, u32)>,
    candidates: Vec<u32>,
    /// Where the places of `weights` lie in the point's tangent plane.
    offsets: Vec<[f32; 2]>,
    /// Places and their weights at the last point.
    pub(super) weights: Vec<Weight>,
}

/// What a place gives to a point and to what lies near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weight {
    pub(super) place: u32,
    /// Share of its irradiance.
    pub(super) value: f32,
    /// How that changes along the axes of the tangent plane.
    pub(super) slope: [f32; 2],
}

impl<'a> Interpolator<'a> {
    pub(super) fn new(places: &'a Places, sides: &'a Sides<'a>) -> Self {
        let (near, candidates, offsets, weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { places, sides, voxel: None, near, at: None, candidates, offsets, weights }
    }

    /// Finds the weights at the middle of a patch's side; returns how well that is covered, 0 for not at all.
    pub(super) fn find(&mut self, side: u32) -> f32 {
        let point = self.sides.point(side);
        self.choose_candidates(side, &point);
        self.weights.clear();
        self.offsets.clear();
        let (tangent, bitangent) = point.normal.any_orthonormal_pair();
        let (mut fit, mut covered) = (Fit::default(), 0.0);
        for index in 0..self.candidates.len() {
            let number = self.candidates[index];
            let place = &self.places.all[number as usize];
            let weight = kernel(place, &point);
            if weight > 0.0 && !self.places.hides(number, point.position, self.sides) {
                covered += weight;
                let way = place.point.position - point.position;
                let offset = [way.dot(tangent), way.dot(bitangent)];
                fit.add(offset, STIFFNESS * place.reach * place.reach, weight);
                self.weights.push(Weight { place: number, value: weight, slope: [0.0; 2] });
                self.offsets.push(offset);
            }
        }
        if covered < COVERED {
            return self.take_all(&point);
        }
        self.make_linear(&fit);
        covered
    }

    /// Weights of a linear fit from those of the kernel.
    fn make_linear(&mut self, fit: &Fit) {
        let rows = fit.inverse();
        for (weight, [u, v]) in self.weights.iter_mut().zip(&self.offsets) {
            let [value, along_u, along_v] = rows.map(|row| weight.value * (row[0] + row[1] * u + row[2] * v));
            (weight.value, weight.slope) = (value.max(0.0), [along_u, along_v]);
        }
        self.divide(self.weights.iter().map(|weight| weight.value).sum());
    }

    /// Where no place on the same surface reaches, as on ornaments and among leaves: all near ones that face about the same way.
    fn take_all(&mut self, point: &Point) -> f32 {
        self.weights.clear();
        let most = self.places.voxel;
        let mut sum = 0.0;
        for number in &self.candidates {
            let place = &self.places.all[*number as usize].point;
            let (distance, cosine) = (place.position.distance(point.position), place.normal.dot(point.normal));
            if distance < most && cosine > 0.0 && !self.places.hides(*number, point.position, self.sides) {
                let weight = (1.0 - distance / most) * cosine * cosine;
                self.weights.push(Weight { place: *number, value: weight, slope: [0.0; 2] });
                sum += weight;
            }
        }
        self.divide(sum);
        sum
    }

    fn divide(&mut self, sum: f32) {
        self.weights.iter_mut().for_each(|weight| weight.value /= sum);
    }

    fn choose_candidates(&mut self, side: u32, point: &Point) {
        let (places, voxel) = (self.places, self.places.voxel_of(point.position));
        if self.voxel != Some(voxel) {
            self.near.clear();
            places.near(voxel, |place| self.near.push(place));
            (self.voxel, self.at) = (Some(voxel), None);
        }
        let at = (self.sides.triangle(side), side % 2);
        if self.at != Some(at) {
            self.candidates.clear();
            let faces = |place: &&u32| places.all[**place as usize].point.normal.dot(point.geometric) > 0.0;
            self.candidates.extend(self.near.iter().filter(faces));
            self.at = Some(at);
        }
    }
}

/// Weight of a place at a point, by distance and normals; 0 where it lies on another surface.
fn kernel(place: &Place, point: &Point) -> f32 {
    let way = point.position - place.point.position;
    let squared = way.length_squared();
    let cosine = place.point.normal.dot(point.normal);
    if squared >= place.reach * place.reach || cosine <= LEAST_COSINE {
        return 0.0;
    }
    let distance = squared.sqrt();
    let off = way.dot(place.point.normal + point.normal).abs() * 0.5;
    if off > STEEPEST * distance + 1e-3 * place.reach {
        return 0.0;
    }
    (1.0 - distance / place.reach) * (cosine - LEAST_COSINE) / (1.0 - LEAST_COSINE)
}

/// Moments of weighted places about a point.
#[derive(Clone, Copy, Default)]
struct Fit {
    sum: f32,
    u: f32,
    v: f32,
    uu: f32,
    uv: f32,
    vv: f32,
}

impl Fit {
    fn add(&mut self, [u, v]: [f32; 2], least: f32, weight: f32) {
        self.sum += weight;
        self.u += weight * u;
        self.v += weight * v;
        self.uu += weight * (u * u + least);
        self.uv += weight * u * v;
        self.vv += weight * (v * v + least);
    }

    /// The inverse of the moments' matrix by rows: with f, g and h the fit at the offset (x, y) is
    /// Σ w·E·(f·q + x g·q + y h·q), q = (1, u, v).
    fn inverse(&self) -> [[f32; 3]; 3] {
        let Self { sum, u, v, uu, uv, vv } = *self;
        let first = [uu * vv - uv * uv, uv * v - u * vv, u * uv - uu * v];
        let determinant = sum * first[0] + u * first[1] + v * first[2];
        if determinant <= 0.0 {
            return [[sum.recip(), 0.0, 0.0], [0.0; 3], [0.0; 3]];
        }
        let mixed = u * v - sum * uv;
        [first, [first[1], sum * vv - v * v, mixed], [first[2], mixed, sum * uu - u * u]]
            .map(|r| r.map(|f| f / determinant))
    }
}

//! Light that is looked for: punctual lights and points on emitting triangles.

use super::surface::{Plane, position, single};
use crate::math::sampling::{self, Discrete};
use crate::scene::emission::{piece_at, piece_corners};
use crate::scene::{Emitter, Light, Scene};
use glam::DVec3;

/// Emitting triangles, chosen in proportion to their power.
#[derive(Default)]
pub struct Emitters {
    emitters: Vec<(Emitter, Plane)>,
    /// Of those that do not shine alike all over: which of their pieces to choose.
    pieces: Vec<Option<Pieces>>,
    choice: Option<Discrete>,
    /// Per scene triangle: its place in `emitters`, or `u32::MAX`.
    place: Vec<u32>,
}

/// The pieces of a triangle, chosen in proportion to their radiance, now and then evenly.
struct Pieces {
    level: u32,
    choice: Discrete,
}

/// Share of points on uneven triangles that are chosen evenly: what shines between the pieces' centres is found as well.
const EVENLY: f64 = 0.1;
/// Pieces of all uneven triangles together.
const MOST_PIECES: u64 = 1 << 22;

impl Pieces {
    /// Of a triangle, and its mean radiance, a sum over the channels.
    fn of(scene: &Scene, triangle: u32, most: u32) -> (Self, f64) {
        let level = scene.emission_level(triangle, most);
        let radiance: Vec<f64> =
            scene.emission_of_pieces(triangle, level).iter().map(|r| f64::from(r.element_sum())).collect();
        let mean = radiance.iter().sum::<f64>() / radiance.len() as f64;
        let even = if mean > 0.0 { EVENLY / (1.0 - EVENLY) * mean } else { 1.0 };
        let choice = Discrete::new(radiance.iter().map(|r| r + even)).expect("each piece can be chosen");
        (Self { level, choice }, mean)
    }

    /// A point by two numbers of its own and one that also chose the triangle; weights of the second and third vertex.
    fn sample(&self, pick: f64, u: f64, v: f64) -> (f64, f64) {
        let [a, b, c] = piece_corners(self.choice.sample(pick).0 as u32, self.level);
        let (second, third) = sampling::triangle(u, v);
        let at = a * (1.0 - second - third) + b * second + c * third;
        (at.y, at.z)
    }

    /// Density relative to an even choice.
    fn density(&self, (b1, b2): (f64, f64)) -> f64 {
        let piece = piece_at(DVec3::new(1.0 - b1 - b2, b1, b2), self.level);
        self.choice.probability(piece as usize) * f64::from(1u32 << (2 * self.level))
    }
}

/// A point on an emitting triangle.
pub struct EmitterSample {
    /// Relative to the scene's origin.
    pub position: DVec3,
    /// Radiance towards the point that asked, W·sr⁻¹·m⁻²; 0 on a dark side.
    pub radiance: DVec3,
    /// Cosine at the emitter towards the point that asked, in absolute value.
    pub cos: f64,
    /// Per unit of area.
    pub density: f64,
}

impl Emitters {
    /// Tabulates the triangles that emit, and of those with a texture or a mask where they do.
    pub fn new(scene: &Scene) -> Self {
        let with_plane = |e: Emitter| (e, Plane::new(scene, e.triangle));
        let emitters: Vec<_> = scene.emitters().into_iter().map(with_plane).collect();
        let varies = |(e, _): &(Emitter, Plane)| scene.emission_varies(e.triangle);
        let varying = emitters.iter().filter(|e| varies(e)).count() as u64;
        let level = ((MOST_PIECES / varying.max(1)).max(1).ilog2() / 2).min(9);
        let pieces = |e: &(Emitter, Plane)| varies(e).then(|| Pieces::of(scene, e.0.triangle, level));
        let pieces: Vec<Option<(Pieces, f64)>> = emitters.iter().map(pieces).collect();
        let mean = |e: &Emitter, pieces: &Option<(Pieces, f64)>| match pieces {
            Some((_, mean)) => *mean,
            None => e.radiance.as_dvec3().element_sum(),
        };
        let power = emitters.iter().zip(&pieces).map(|((e, plane), pieces)| plane.area * mean(e, pieces));
        let mut place = vec![u32::MAX; scene.triangles.len()];
        emitters.iter().enumerate().for_each(|(i, (e, _))| place[e.triangle as usize] = i as u32);
        let choice = Discrete::new(power);
        let pieces = pieces.into_iter().map(|found| found.map(|(pieces, _)| pieces)).collect();
        Self { choice, pieces, emitters, place }
    }

    /// Whether no triangle emits.
    pub fn is_empty(&self) -> bool {
        self.choice.is_none()
    }

    /// A point on an emitter, as seen from `from`.
    pub fn sample(&self, scene: &Scene, from: DVec3, [pick, u, v]: [f64; 3]) -> Option<EmitterSample> {
        let choice = self.choice.as_ref()?;
        let (i, rest) = choice.sample(pick);
        let (Emitter { triangle, double_sided, .. }, plane) = self.emitters[i];
        let at = match &self.pieces[i] {
            Some(pieces) => pieces.sample(rest, u, v),
            None => sampling::triangle(u, v),
        };
        let position = position(scene, triangle, at);
        let cos = plane.front.dot(from - position) / (from - position).length();
        let dark = cos <= 0.0 && !double_sided || !scene.is_present(triangle, single(at));
        let radiance = if dark { DVec3::ZERO } else { scene.surface(triangle, single(at)).emission.as_dvec3() };
        let density = choice.probability(i) / plane.area * self.pieces[i].as_ref().map_or(1.0, |p| p.density(at));
        Some(EmitterSample { position, radiance, cos: cos.abs(), density })
    }

    /// Density of [`Emitters::sample`] at a point of `triangle`, per unit of area; 0 if it is never chosen.
    pub fn density(&self, triangle: u32, at: (f64, f64)) -> f64 {
        let (Some(choice), i) = (&self.choice, self.place[triangle as usize] as usize) else { return 0.0 };
        let Some((_, plane)) = self.emitters.get(i) else { return 0.0 };
        choice.probability(i) / plane.area * self.pieces[i].as_ref().map_or(1.0, |pieces| pieces.density(at))
    }
}

/// Light from a punctual light at a point: direction to it, distance, and irradiance on a surface that faces it (W·m⁻²).
pub fn arrive(light: &Light, at: DVec3) -> (DVec3, f64, DVec3) {
    let from_point = |position: glam::Vec3| {
        let offset = position.as_dvec3() - at;
        let distance = offset.length();
        (offset / distance, distance)
    };
    match *light {
        Light::Directional { direction, irradiance } => {
            (-direction.as_dvec3().normalize(), f64::INFINITY, irradiance.as_dvec3())
        }
        Light::Point { position, intensity } => {
            let (to_light, distance) = from_point(position);
            (to_light, distance, intensity.as_dvec3() / (distance * distance))
        }
        Light::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            let (to_light, distance) = from_point(position);
            let cos = -to_light.dot(direction.as_dvec3().normalize());
            let inside = f64::from(u8::from(cos > cos_outer));
            let edge = if cos_inner > cos_outer { (cos - cos_outer) / (cos_inner - cos_outer) } else { inside };
            let edge = edge.clamp(0.0, 1.0);
            (to_light, distance, intensity.as_dvec3() * (edge * edge / (distance * distance)))
        }
    }
}

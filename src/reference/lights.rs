//! Light that is looked for: punctual lights and points on emitting triangles.

use super::surface::{Plane, position, single};
use crate::math::sampling::{self, Discrete};
use crate::scene::{Emitter, Light, Scene};
use glam::DVec3;

/// Emitting triangles, chosen in proportion to their power.
#[derive(Default)]
pub struct Emitters {
    emitters: Vec<(Emitter, Plane)>,
    choice: Option<Discrete>,
    /// Per scene triangle: its place in `emitters`, or `u32::MAX`.
    place: Vec<u32>,
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
    /// Tabulates the triangles that emit. One whose texture hides its light from the estimate of its power is left to be
    /// found by chance.
    pub fn new(scene: &Scene) -> Self {
        let with_plane = |e: Emitter| (e, Plane::new(scene, e.triangle));
        let emitters: Vec<_> = scene.emitters().into_iter().map(with_plane).collect();
        let power = emitters.iter().map(|(e, plane)| plane.area * e.radiance.as_dvec3().element_sum());
        let mut place = vec![u32::MAX; scene.triangles.len()];
        emitters.iter().enumerate().for_each(|(i, (e, _))| place[e.triangle as usize] = i as u32);
        Self { choice: Discrete::new(power), emitters, place }
    }

    /// Whether no triangle emits.
    pub fn is_empty(&self) -> bool {
        self.choice.is_none()
    }

    /// A point on an emitter, as seen from `from`.
    pub fn sample(&self, scene: &Scene, from: DVec3, [pick, u, v]: [f64; 3]) -> Option<EmitterSample> {
        let choice = self.choice.as_ref()?;
        let (i, _) = choice.sample(pick);
        let (Emitter { triangle, double_sided, .. }, plane) = self.emitters[i];
        let at = sampling::triangle(u, v);
        let position = position(scene, triangle, at);
        let cos = plane.front.dot(from - position) / (from - position).length();
        let dark = cos <= 0.0 && !double_sided || !scene.is_present(triangle, single(at));
        let radiance = if dark { DVec3::ZERO } else { scene.surface(triangle, single(at)).emission.as_dvec3() };
        let density = choice.probability(i) / plane.area;
        Some(EmitterSample { position, radiance, cos: cos.abs(), density })
    }

    /// Density of [`Emitters::sample`] on `triangle`, per unit of area; 0 if it is never chosen.
    pub fn density(&self, triangle: u32) -> f64 {
        match (&self.choice, self.place[triangle as usize]) {
            (Some(choice), i) if i != u32::MAX => choice.probability(i as usize) / self.emitters[i as usize].1.area,
            _ => 0.0,
        }
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
            let (inner, outer) = (f64::from(cos_inner), f64::from(cos_outer));
            let edge = ((cos - outer) / (inner - outer)).clamp(0.0, 1.0);
            (to_light, distance, intensity.as_dvec3() * (edge * edge / (distance * distance)))
        }
    }
}

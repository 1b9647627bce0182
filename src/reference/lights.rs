//! Light that is looked for: punctual lights and points on emitting triangles.

use super::surface::{Interpolation, triangle_plane};
use crate::math::sampling::{self, Discrete};
use crate::scene::{Light, Scene};
use glam::DVec3;

/// Points per triangle at which a textured emitter's power is estimated.
const POWER_SAMPLES: u32 = 64;

/// Emitting triangles, chosen in proportion to their power.
#[derive(Default)]
pub struct Emitters {
    triangles: Vec<u32>,
    choice: Option<Discrete>,
    /// Per scene triangle: its place in `triangles`, or `u32::MAX`.
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
    /// Finds the triangles whose material emits. `material_of` has one entry a triangle.
    pub fn new(scene: &Scene, material_of: &[u32]) -> Self {
        let emits = |t: &u32| scene.materials[material_of[*t as usize] as usize].emission != glam::Vec3::ZERO;
        let triangles: Vec<u32> = (0..scene.triangles.len() as u32).filter(emits).collect();
        let choice = Discrete::new(triangles.iter().map(|&t| power(scene, material_of, t)));
        let mut place = vec![u32::MAX; scene.triangles.len()];
        triangles.iter().enumerate().for_each(|(i, &t)| place[t as usize] = i as u32);
        Self { triangles, choice, place }
    }

    /// Whether no triangle emits.
    pub fn is_empty(&self) -> bool {
        self.choice.is_none()
    }

    /// A point on an emitter, as seen from `from`.
    pub fn sample(
        &self,
        scene: &Scene,
        material_of: &[u32],
        from: DVec3,
        [pick, u, v]: [f64; 3],
    ) -> Option<EmitterSample> {
        let choice = self.choice.as_ref()?;
        let (i, _) = choice.sample(pick);
        let triangle = self.triangles[i];
        let material = &scene.materials[material_of[triangle as usize] as usize];
        let at = Interpolation::new(scene, triangle, sampling::triangle(u, v));
        let (front, twice_area, _) = triangle_plane(scene, triangle);
        let position = at.position(scene);
        let cos = front.dot(from - position) / (from - position).length();
        let dark = cos <= 0.0 && !material.double_sided;
        let absent = material.alpha_cutoff.is_some_and(|cutoff| at.base_color(scene, material).w < cutoff);
        let radiance = if dark || absent { DVec3::ZERO } else { at.emission(scene, material) };
        let density = choice.probability(i) / (0.5 * twice_area);
        Some(EmitterSample { position, radiance, cos: cos.abs(), density })
    }

    /// Density of [`Emitters::sample`] on `triangle`, per unit of area; 0 if it does not emit.
    pub fn density(&self, scene: &Scene, triangle: u32) -> f64 {
        match (&self.choice, self.place[triangle as usize]) {
            (Some(choice), i) if i != u32::MAX => {
                choice.probability(i as usize) / (0.5 * triangle_plane(scene, triangle).1)
            }
            _ => 0.0,
        }
    }
}

/// Area × mean radiance, up to a common factor. Never 0 for a textured emitter, whose bright texels the samples may miss.
fn power(scene: &Scene, material_of: &[u32], triangle: u32) -> f64 {
    let material = &scene.materials[material_of[triangle as usize] as usize];
    let area = triangle_plane(scene, triangle).1;
    let full = material.emission.as_dvec3().element_sum();
    if material.emission_texture.is_none() {
        return area * full;
    }
    let radiance = |i| {
        let [u, v, _, _] = sobol_burley::sample_4d(i, 0, triangle).map(f64::from);
        Interpolation::new(scene, triangle, sampling::triangle(u, v)).emission(scene, material).element_sum()
    };
    let mean = (0..POWER_SAMPLES).map(radiance).sum::<f64>() / f64::from(POWER_SAMPLES);
    area * mean.max(0.01 * full)
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

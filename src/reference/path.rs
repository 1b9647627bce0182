//! One path of light: the irradiance it brings to a point, split by the number of reflections on the way.
//!
//! Direct light at every vertex comes from two techniques: a point on an emitter or a map's texel (next-event
//! estimation), and the cosine-distributed direction that also continues the path; Veach's power heuristic weighs them.

use super::lights::arrive;
use super::sampler::Sampler;
use super::surface::SurfacePoint;
use super::tracer::Tracer;
use crate::math::sampling::{cosine_hemisphere, frame, power_heuristic};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// Irradiance by number of reflections: 0, 1, 2, 3 and more. W·m⁻².
pub type Layers = [DVec3; 4];

/// Up to this many punctual lights each gets its shadow ray; of more, one is chosen.
const EXACT_LIGHTS: usize = 4;
/// Reflections before Russian roulette may end a path.
const SURE_BOUNCES: u32 = 3;

/// What a direction brings: radiance of an emitter or the sky (weighted), and the surface to continue from.
struct Arrival {
    radiance: DVec3,
    next: Option<SurfacePoint>,
    distance: f64,
}

/// One path and the number of rays it took.
pub struct Path<'a, 'b> {
    tracer: &'a Tracer<'b>,
    sampler: Sampler,
    /// Rays traced so far.
    pub rays: u64,
}

impl<'a, 'b> Path<'a, 'b> {
    /// A path that draws its numbers from `sampler`.
    pub fn new(tracer: &'a Tracer<'b>, sampler: Sampler) -> Self {
        Self { tracer, sampler, rays: 0 }
    }

    /// Estimates irradiance on the side of `first` with up to `bounces` reflections.
    ///
    /// Punctual lights that `first` sees itself are left out where `punctual_at_first` is false: they have no noise, so
    /// the caller adds them once (see [`Path::punctual`]).
    pub fn irradiance(&mut self, first: &SurfacePoint, bounces: u32, punctual_at_first: bool) -> Layers {
        let mut layers = Layers::default();
        let mut vertex = *first;
        let mut throughput = DVec3::ONE;
        for bounce in 0..=bounces {
            let a = self.sampler.next4();
            let b = if self.draws_light() { self.sampler.next4() } else { [0.0; 4] };
            let mut direct = self.emitters(&vertex, [a[2], b[0], b[1]]) + self.sky_map(&vertex, [b[2], b[3]]);
            if bounce > 0 || punctual_at_first {
                direct += self.punctual(&vertex);
            }
            let last = bounce == bounces;
            let arrival = if last && !self.direction_finds_light() {
                None
            } else {
                self.look(&vertex, cosine_direction(vertex.normal, a[0], a[1]))
            };
            if let Some(arrival) = &arrival {
                direct += arrival.radiance * PI;
            }
            layers[bounce.min(3) as usize] += throughput * direct;
            let Some(next) = arrival.and_then(|arrival| arrival.next).filter(|_| !last) else { break };
            throughput *= next.albedo;
            let survival = if bounce + 1 < SURE_BOUNCES { 1.0 } else { throughput.max_element().min(1.0) };
            if survival <= a[3] {
                break;
            }
            throughput /= survival;
            vertex = next;
        }
        layers
    }

    /// Radiance that arrives along `direction` after 1 to `bounces` reflections, and the distance to where it left
    /// (infinite for the sky).
    pub fn indirect_radiance(&mut self, from: &SurfacePoint, direction: DVec3, bounces: u32) -> (DVec3, f64) {
        let Some(Arrival { next, distance, .. }) = self.look(from, direction) else {
            return (DVec3::ZERO, f64::INFINITY);
        };
        let Some(surface) = next.filter(|surface| bounces > 0 && surface.albedo != DVec3::ZERO) else {
            return (DVec3::ZERO, distance);
        };
        let layers = self.irradiance(&surface, bounces - 1, true);
        (layers.iter().sum::<DVec3>() * surface.albedo * FRAC_1_PI, distance)
    }

    /// Whether [`Path::punctual`] has no noise.
    pub fn punctual_is_exact(tracer: &Tracer) -> bool {
        tracer.scene.lights.len() <= EXACT_LIGHTS
    }

    /// Irradiance from the punctual lights; exact when there are few.
    pub fn punctual(&mut self, vertex: &SurfacePoint) -> DVec3 {
        let lights = &self.tracer.scene.lights;
        if Self::punctual_is_exact(self.tracer) {
            return (0..lights.len()).map(|i| self.shadowed(vertex, i)).sum();
        }
        let pick = self.sampler.next4()[0];
        match self.choose_light(vertex, pick) {
            Some((light, probability)) => self.shadowed(vertex, light) / probability,
            None => DVec3::ZERO,
        }
    }

    /// One punctual light, in proportion to what it would bring unhindered, and its probability.
    fn choose_light(&self, vertex: &SurfacePoint, pick: f64) -> Option<(usize, f64)> {
        let count = self.tracer.scene.lights.len();
        let reach = |i| self.unshadowed(vertex, i).2.element_sum();
        let total: f64 = (0..count).map(reach).sum();
        let mut rest = pick * total;
        let chosen = (0..count).find(|&i| {
            rest -= reach(i);
            rest < 0.0
        })?;
        Some((chosen, reach(chosen) / total))
    }

    fn unshadowed(&self, vertex: &SurfacePoint, light: usize) -> (DVec3, f64, DVec3) {
        let (direction, distance, irradiance) = arrive(&self.tracer.scene.lights[light], vertex.position);
        (direction, distance, irradiance * cosine(vertex, direction))
    }

    fn shadowed(&mut self, vertex: &SurfacePoint, light: usize) -> DVec3 {
        let (direction, distance, irradiance) = self.unshadowed(vertex, light);
        // A light in the very plane or place of the surface gives no number; neither does it give light.
        let lit = irradiance.is_finite() && irradiance.element_sum() > 0.0;
        if lit && self.free(vertex, direction, distance) { irradiance } else { DVec3::ZERO }
    }

    fn free(&mut self, vertex: &SurfacePoint, direction: DVec3, distance: f64) -> bool {
        self.rays += 1;
        self.tracer.free(vertex.ray_origin, direction, distance)
    }

    /// Irradiance from emitting triangles by a point on one of them.
    fn emitters(&mut self, vertex: &SurfacePoint, numbers: [f64; 3]) -> DVec3 {
        let Tracer { scene, emitters, .. } = self.tracer;
        let Some(sample) = emitters.sample(scene, vertex.position, numbers) else { return DVec3::ZERO };
        let offset = sample.position - vertex.position;
        let distance2 = offset.length_squared();
        let cos = cosine(vertex, offset / distance2.sqrt());
        if cos <= 0.0 || sample.cos <= 0.0 || sample.radiance == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let density = sample.density * distance2 / sample.cos; // per steradian
        let value = sample.radiance * (cos / density * power_heuristic(density, cos * FRAC_1_PI));
        self.rays += 1;
        if self.tracer.sees(vertex.ray_origin, sample.position) { value } else { DVec3::ZERO }
    }

    /// Irradiance from an environment map by one of its texels.
    fn sky_map(&mut self, vertex: &SurfacePoint, [u, v]: [f64; 2]) -> DVec3 {
        let Some(sample) = self.tracer.sky.sample(u, v) else { return DVec3::ZERO };
        let cos = cosine(vertex, sample.direction);
        if cos <= 0.0 || !self.free(vertex, sample.direction, f64::INFINITY) {
            return DVec3::ZERO;
        }
        sample.radiance * (cos / sample.density * power_heuristic(sample.density, cos * FRAC_1_PI))
    }

    /// Whether some light is sampled by place or texel.
    fn draws_light(&self) -> bool {
        !self.tracer.emitters.is_empty() || self.tracer.sky.is_map()
    }

    fn direction_finds_light(&self) -> bool {
        !self.tracer.emitters.is_empty() || !self.tracer.sky.is_black()
    }

    /// What is seen in a direction drawn with density cosθ/π. `None` below the geometric surface, which sees nothing.
    fn look(&mut self, vertex: &SurfacePoint, direction: DVec3) -> Option<Arrival> {
        if direction.dot(vertex.geometric) <= 0.0 {
            return None;
        }
        let density = direction.dot(vertex.normal) * FRAC_1_PI;
        self.rays += 1;
        let Some(hit) = self.tracer.hit(vertex.ray_origin, direction) else {
            let weight = power_heuristic(density, self.tracer.sky.density(direction));
            let radiance = self.tracer.sky.radiance(direction) * weight;
            return Some(Arrival { radiance, next: None, distance: f64::INFINITY });
        };
        let next = self.tracer.surface(&hit, direction);
        let mut radiance = next.emission;
        if radiance != DVec3::ZERO {
            let cos = next.geometric.dot(direction).abs();
            let by_area = self.tracer.emitters.density(next.triangle, hit.barycentric);
            radiance *= power_heuristic(density, by_area * hit.t * hit.t / cos);
        }
        Some(Arrival { radiance, next: Some(next), distance: hit.t })
    }
}

/// Cosine at the shading normal, 0 for directions below the triangle itself.
fn cosine(vertex: &SurfacePoint, direction: DVec3) -> f64 {
    if direction.dot(vertex.geometric) > 0.0 { direction.dot(vertex.normal).max(0.0) } else { 0.0 }
}

fn cosine_direction(normal: DVec3, u: f64, v: f64) -> DVec3 {
    let (x, y) = frame(normal);
    let local = cosine_hemisphere(u, v);
    (x * local.x + y * local.y + normal * local.z).normalize()
}

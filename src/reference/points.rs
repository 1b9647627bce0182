//! Light at points in space by path tracing, as a reference for irradiance volumes.

use super::path::Path;
use super::progressive::Settings;
use super::sampler::Sampler;
use super::tracer::Tracer;
use crate::math::sampling::uniform_sphere;
use crate::math::sh;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// Light at a point, for the three colour channels: light that surfaces reflect, and the sky's. The direct light of emitters and of
/// punctual lights is left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointLight {
    /// Radiance as spherical harmonics ([`sh`]), W·sr⁻¹·m⁻².
    pub coefficients: Vec<DVec3>,
    /// Irradiance on surfaces that face along +x, −x, +y, −y, +z, −z, W·m⁻²: by the cosine itself, not by harmonics.
    pub irradiance: [DVec3; 6],
    /// Standard error of the irradiances, all directions and channels together, relative to them.
    pub error: f64,
}

/// Paths of a batch: numbers of a stream are well spread over as many.
const BATCH: u32 = 1024;

/// Light at `position`, relative to the scene's origin, that was reflected 1 to `settings.bounces` times, and the sky's own: by
/// `paths` paths or somewhat more, as harmonics of `order`. `stream` tells points apart, so that their errors are independent.
pub fn light_at(
    tracer: &Tracer,
    position: DVec3,
    order: u32,
    settings: &Settings,
    (stream, paths): (u64, u32),
) -> PointLight {
    let batches = paths.div_ceil(BATCH).max(2);
    let count = sh::count(order);
    let (mut sums, mut squares) = (vec![DVec3::ZERO; count + 6], vec![DVec3::ZERO; count + 6]);
    for batch in 0..batches {
        let values = one_batch(tracer, position, order, settings, stream, batch);
        for ((sum, square), value) in sums.iter_mut().zip(&mut squares).zip(values) {
            *sum += value;
            *square += value * value;
        }
    }
    let n = f64::from(batches);
    let mean: Vec<DVec3> = sums.iter().map(|sum| *sum / n).collect();
    let variance = |i: usize| ((squares[i] / n - mean[i] * mean[i]) / (n - 1.0)).max(DVec3::ZERO);
    let irradiance: [DVec3; 6] = std::array::from_fn(|i| mean[count + i]);
    let errors: f64 = (count..count + 6).map(|i| variance(i).to_array().map(f64::sqrt).iter().sum::<f64>()).sum();
    let whole: f64 = irradiance.iter().map(|e| e.element_sum()).sum();
    let error = if whole > 0.0 { errors / whole } else { 0.0 };
    PointLight { coefficients: mean[..count].to_vec(), irradiance, error }
}

/// Means over a batch: coefficients, then irradiances.
fn one_batch(tracer: &Tracer, position: DVec3, order: u32, settings: &Settings, stream: u64, batch: u32) -> Vec<DVec3> {
    let count = sh::count(order);
    let mut sums = vec![DVec3::ZERO; count + 6];
    let mut harmonics = vec![0.0; count];
    let mut rays = 0;
    for i in 0..BATCH {
        let mut sampler = Sampler::new(settings.seed, stream, batch, i);
        let [u, v, ..] = sampler.next4();
        let direction = uniform_sphere(u, v);
        let (radiance, cost) = radiance(tracer, position, direction, settings.bounces, sampler);
        rays += cost;
        sh::evaluate(order, direction, &mut harmonics);
        let share = 4.0 * PI / f64::from(BATCH);
        sums.iter_mut().zip(&harmonics).for_each(|(sum, h)| *sum += share * *h * radiance);
        for (axis, sum) in sums[count..].iter_mut().enumerate() {
            let along = direction[axis / 2] * if axis % 2 == 0 { 1.0 } else { -1.0 };
            *sum += share * along.max(0.0) * radiance;
        }
    }
    tracer.count_rays(rays);
    sums
}

/// Radiance that arrives along a direction, and the rays it took.
fn radiance(tracer: &Tracer, from: DVec3, direction: DVec3, bounces: u32, sampler: Sampler) -> (DVec3, u64) {
    let Some(hit) = tracer.hit(from, direction) else { return (tracer.sky.radiance(direction), 1) };
    let surface = tracer.surface(&hit, direction);
    if bounces == 0 || surface.albedo == DVec3::ZERO {
        return (DVec3::ZERO, 1);
    }
    let mut path = Path::new(tracer, sampler);
    let layers = path.irradiance(&surface, bounces.saturating_sub(1), true);
    (layers.iter().sum::<DVec3>() * surface.albedo * FRAC_1_PI, path.rays + 1)
}

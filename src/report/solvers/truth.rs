//! What a region's irradiance is, and what it should be.

use super::Region;
use crate::math::sequence::triangle_point;
use crate::methods::surface_irradiance::SurfaceIrradiance;
use crate::reference::{Settings, Tracer, irradiance_at};
use crate::scene::Scene;
use glam::DVec3;
use rayon::prelude::*;

/// Paths for a region whose irradiance is traced.
const PATHS: u32 = 1 << 15;

/// Mean over the region, weighted by area, of the first channel.
pub fn mean(scene: &Scene, found: &SurfaceIrradiance, region: &Region) -> f64 {
    // Every triangle has vertices of its own, in order.
    let place = |index: &usize| found.triangles[*index][0] / 3;
    let mut at = vec![0; found.triangles.len()];
    (0..found.triangles.len()).for_each(|index| at[place(&index) as usize] = index);
    let of_side = |(triangle, side): &(u32, usize)| {
        let cells = found.cells(at[*triangle as usize]);
        let sum: f64 = cells.clone().map(|cell| f64::from(found.reflected[cell][*side][0])).sum();
        sum / cells.len() as f64 * f64::from(scene.area(*triangle))
    };
    region.sides.iter().map(of_side).sum::<f64>() / area(scene, region)
}

/// In closed form or by paths.
pub fn expected(scene: &Scene, region: &Region) -> f64 {
    region.mean.unwrap_or_else(|| traced(scene, region))
}

fn traced(scene: &Scene, region: &Region) -> f64 {
    let tracer = Tracer::new(scene);
    let whole = area(scene, region);
    let of_side = |(triangle, side): &(u32, usize)| {
        let share = f64::from(scene.area(*triangle)) / whole;
        let paths = (f64::from(PATHS) * share).ceil().max(1.0) as u32;
        let sum: f64 = (0..paths).into_par_iter().map(|i| one_path(&tracer, (*triangle, *side), i)).sum();
        sum / f64::from(paths) * share
    };
    region.sides.iter().map(of_side).sum()
}

fn one_path(tracer: &Tracer<'_>, (triangle, side): (u32, usize), path: u32) -> f64 {
    let [a, b, c] = tracer.scene.corners(triangle).map(|p| p.as_dvec3());
    let [u, v] = triangle_point(path).as_dvec2().to_array();
    let normal = tracer.scene.geometric_normal(triangle).as_dvec3() * if side == 0 { 1.0 } else { -1.0 };
    let position: DVec3 = a + (b - a) * u + (c - a) * v + normal * 1e-6;
    let seed = u64::from(triangle) << 32 | u64::from(path);
    let settings = Settings { bounces: Settings::ALL_BOUNCES, seed, batch: 1 };
    irradiance_at(tracer, position, normal, &settings, 1).indirect().x
}

fn area(scene: &Scene, region: &Region) -> f64 {
    region.sides.iter().map(|(triangle, _)| f64::from(scene.area(*triangle))).sum()
}

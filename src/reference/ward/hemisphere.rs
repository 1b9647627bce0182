//! What a record measures: stratified rays over the hemisphere, and from them irradiance, both gradients and distance.

use crate::math::sampling::frame;
use crate::reference::path::Path;
use crate::reference::sampler::Sampler;
use crate::reference::surface::SurfacePoint;
use crate::reference::tracer::Tracer;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Indirect light at a point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Measurement {
    /// Irradiance, W·m⁻².
    pub irradiance: DVec3,
    /// ∇_r E per channel, world space: E at normal n is `E + (n_k × n)·∇_r E`. W·m⁻²·rad⁻¹.
    pub rotation: [DVec3; 3],
    /// ∇_t E per channel, world space, in the tangent plane. W·m⁻³.
    pub translation: [DVec3; 3],
    /// Harmonic mean of the distances, cosine-weighted, as its inverse; 0 where only sky is seen.
    pub inverse_distance: f64,
}

/// Rays in a grid of M rings × N sectors of equal cosine-weighted solid angle.
pub struct Grid {
    rings: usize,
    sectors: usize,
}

/// What a ray brought back.
#[derive(Clone, Copy)]
struct Cell {
    radiance: DVec3,
    /// 1 / distance; 0 for the sky.
    nearness: f64,
}

impl Grid {
    /// About `rays` cells, N ≈ πM so that cells are nearly square (Ward and Heckbert 1992).
    pub fn new(rays: u32) -> Self {
        let rings = (f64::from(rays) / PI).sqrt().round().max(1.0);
        let sectors = (f64::from(rays) / rings).round().max(4.0);
        Self { rings: rings as usize, sectors: sectors as usize }
    }

    /// Shoots one jittered ray through every cell and continues it as a path of up to `bounces` reflections.
    pub fn measure(
        &self,
        tracer: &Tracer,
        surface: &SurfacePoint,
        bounces: u32,
        seed: u64,
        stream: u64,
    ) -> (Measurement, u64) {
        let (x, y) = frame(surface.normal);
        let mut rays = 0;
        let mut shoot = |i: usize| {
            let mut sampler = Sampler::new(seed, stream, 0, i as u32);
            let [u, v, _, _] = sampler.next4();
            let sin2 = ((i / self.sectors) as f64 + u) / self.rings as f64;
            let phi = TAU * ((i % self.sectors) as f64 + v) / self.sectors as f64;
            let tangent = sin2.sqrt() * phi.cos() * x + sin2.sqrt() * phi.sin() * y;
            let direction = (tangent + (1.0 - sin2).sqrt() * surface.normal).normalize();
            let mut path = Path::new(tracer, sampler);
            let (radiance, distance) = path.indirect_radiance(surface, direction, bounces);
            rays += path.rays;
            Cell { radiance, nearness: 1.0 / distance }
        };
        let cells: Vec<Cell> = (0..self.rings * self.sectors).map(&mut shoot).collect();
        let world = |g: [DVec2; 3]| g.map(|g| x * g.x + y * g.y);
        let measurement = Measurement {
            irradiance: cells.iter().map(|c| c.radiance).sum::<DVec3>() * (PI / cells.len() as f64),
            rotation: world(self.rotation(&cells)),
            translation: world(self.translation(&cells)),
            inverse_distance: cells.iter().map(|c| c.nearness).sum::<f64>() / cells.len() as f64,
        };
        (measurement, rays)
    }

    /// ∇_r E = ∫ L (n × ω) dω, with n × ω integrated exactly over each cell: finite up to the horizon, unlike the Monte
    /// Carlo form with its tan θ.
    fn rotation(&self, cells: &[Cell]) -> [DVec2; 3] {
        let mut gradient = [DVec2::ZERO; 3];
        for (i, cell) in cells.iter().enumerate() {
            let (ring, sector) = (i / self.sectors, i % self.sectors);
            // ∫ sin²θ dθ
            let over_theta = |t: f64| 0.5 * t - 0.25 * (2.0 * t).sin();
            let height = over_theta(self.theta(ring + 1)) - over_theta(self.theta(ring));
            // ∫ (−sin φ, cos φ) dφ = [(cos φ, sin φ)]
            let width = self.spoke(sector + 1) - self.spoke(sector);
            add(&mut gradient, cell.radiance, width * height);
        }
        gradient
    }

    /// Ward and Heckbert 1992 (Křivánek, Gautron, Bouatouch, Pattanaik 2005, for the cosine): when the point moves,
    /// the border between two cells moves over the farther one, at the speed 1 / (distance of the nearer one).
    fn translation(&self, cells: &[Cell]) -> [DVec2; 3] {
        let mut gradient = [DVec2::ZERO; 3];
        for (i, cell) in cells.iter().enumerate() {
            let (ring, sector) = (i / self.sectors, i % self.sectors);
            let (low, high) = (self.theta(ring), self.theta(ring + 1));
            if ring > 0 {
                let inner = cells[i - self.sectors];
                // ∫ û dφ over the sector
                let across = (self.spoke(sector + 1) - self.spoke(sector)).perp() * -1.0;
                let speed = cell.nearness.max(inner.nearness) * low.sin() * low.cos().powi(2);
                add(&mut gradient, cell.radiance - inner.radiance, across * speed);
            }
            let before = cells[ring * self.sectors + (sector + self.sectors - 1) % self.sectors];
            let speed = cell.nearness.max(before.nearness) * (high.sin() - low.sin());
            add(&mut gradient, cell.radiance - before.radiance, self.spoke(sector).perp() * speed);
        }
        gradient
    }

    /// Polar angle at the inner border of a ring.
    fn theta(&self, ring: usize) -> f64 {
        (ring as f64 / self.rings as f64).sqrt().asin()
    }

    /// Unit vector along the border before a sector.
    fn spoke(&self, sector: usize) -> DVec2 {
        DVec2::from_angle(TAU * sector as f64 / self.sectors as f64)
    }
}

fn add(gradient: &mut [DVec2; 3], radiance: DVec3, direction: DVec2) {
    gradient.iter_mut().zip(radiance.to_array()).for_each(|(g, l)| *g += direction * l);
}

//! The surface as the fit sees it: triangles between unknowns, and the irradiance of their cells.

use super::Off;
use crate::methods::surface_irradiance::SurfaceIrradiance;
use crate::scene::Scene;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// A triangle and the irradiance on it.
pub struct Face {
    /// Unknowns of its corners.
    pub corners: [usize; 3],
    /// Places of its corners.
    pub positions: [DVec3; 3],
    /// Area.
    pub area: f64,
    /// Of each cell, all of one size: weights of the corners at its middle, and its irradiance.
    pub cells: Vec<([f64; 3], DVec3)>,
}

/// All triangles.
pub struct Mesh {
    /// The unknown of each vertex of the scene.
    pub unknowns: Vec<Option<u32>>,
    /// Number of unknowns.
    pub count: usize,
    /// Triangles with an area.
    pub faces: Vec<Face>,
}

impl Mesh {
    pub fn new(scene: &Scene, found: &SurfaceIrradiance) -> Self {
        let (unknowns, count) = weld(scene);
        let double_sided = double_sided(scene, found);
        let face = |(index, corners): (usize, &[u32; 3])| {
            let positions = corners.map(|v| scene.positions[v as usize].as_dvec3());
            let [a, b, c] = positions;
            let area = 0.5 * (b - a).cross(c - a).length();
            let of_corner = |v: u32| unknowns[v as usize].map_or(0, |unknown| unknown as usize);
            let side = side(found, index, double_sided[index]);
            let cell = |cell: usize| {
                let [u, v] = found.middle(index, cell).to_array();
                ([1.0 - u - v, u, v], found.whole(cell, side))
            };
            Face { corners: corners.map(of_corner), positions, area, cells: found.cells(index).map(cell).collect() }
        };
        let faces = found.triangles.iter().enumerate().map(face).filter(|face| face.area > 0.0).collect();
        Self { unknowns, count, faces }
    }

    /// How far values of the unknowns are from the surface's irradiance.
    pub fn off(&self, values: &[DVec3]) -> Off {
        let (mut square, mut squares, mut absolute, mut sum, mut whole) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for face in &self.faces {
            let weight = face.area / face.cells.len() as f64;
            let corners = face.corners.map(|unknown| values[unknown]);
            for (weights, irradiance) in &face.cells {
                let value: DVec3 = corners.iter().zip(weights).map(|(value, w)| *value * *w).sum();
                square += weight * (value - irradiance).length_squared();
                squares += weight * irradiance.length_squared();
                absolute += weight * (value - irradiance).abs().element_sum();
                sum += weight * value.element_sum();
                whole += weight * irradiance.element_sum();
            }
        }
        if whole <= 0.0 {
            return Off { energy: 1.0, ..Off::default() };
        }
        Off { rms: (square / squares).sqrt(), mean: absolute / whole, energy: sum / whole }
    }
}

/// Vertices of one place and normal have one unknown; those that no triangle uses have none.
fn weld(scene: &Scene) -> (Vec<Option<u32>>, usize) {
    let mut unknowns = vec![None; scene.positions.len()];
    let mut known = HashMap::new();
    for vertex in scene.triangles.iter().flatten().map(|v| *v as usize) {
        let bits = |v: Vec3| (v + Vec3::ZERO).to_array().map(f32::to_bits);
        let next = known.len() as u32;
        let unknown = *known.entry((bits(scene.positions[vertex]), bits(scene.normals[vertex]))).or_insert(next);
        unknowns[vertex] = Some(unknown);
    }
    (unknowns, known.len())
}

/// Whether the material of each triangle is double-sided.
fn double_sided(scene: &Scene, found: &SurfaceIrradiance) -> Vec<bool> {
    let mut all = vec![false; found.triangles.len()];
    for part in found.parts.iter().filter(|part| scene.materials[part.material as usize].double_sided) {
        let std::ops::Range { start, end } = part.triangles();
        all[start as usize..end as usize].fill(true);
    }
    all
}

/// The side of a triangle that counts.
fn side(found: &SurfaceIrradiance, triangle: usize, double_sided: bool) -> usize {
    let sum = |side: usize| found.cells(triangle).map(|cell| found.whole(cell, side).element_sum()).sum::<f64>();
    usize::from(double_sided && sum(1) > sum(0))
}

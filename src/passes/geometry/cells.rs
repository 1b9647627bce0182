//! The cells that the surface is cut into.

use crate::math::density::{Density, Eye};
use crate::scene::Scene;

/// How finely the surface is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellBudget {
    /// Cells altogether, about: each triangle has one at least.
    pub count: u32,
    /// Where cells are finer; nowhere without.
    pub eye: Option<Eye>,
}

impl CellBudget {
    /// So many, all of one size.
    pub fn even(count: u32) -> Self {
        Self { count, eye: None }
    }

    fn density(&self, scene: &Scene, triangles: &[[u32; 3]]) -> Density {
        Density::new(triangles.iter().map(|t| corners(scene, t)), self.count, self.eye)
    }
}

/// r² cells a triangle: first cell of each triangle, triangle of each cell, and how densely they lie.
pub(super) fn cut(scene: &Scene, triangles: &[[u32; 3]], budget: &CellBudget) -> (Vec<u32>, Vec<u32>, Density) {
    let density = budget.density(scene, triangles);
    let mut first = Vec::with_capacity(triangles.len() + 1);
    let mut owner = Vec::new();
    for (index, triangle) in triangles.iter().enumerate() {
        first.push(owner.len() as u32);
        let resolution = density.resolution(&corners(scene, triangle), 0.0);
        owner.extend(std::iter::repeat_n(index as u32, resolution.pow(2) as usize));
    }
    first.push(owner.len() as u32);
    (first, owner, density)
}

/// Number of cells that a surface comes to by `budget`.
pub fn count(scene: &Scene, budget: &CellBudget) -> u64 {
    let density = budget.density(scene, &scene.triangles);
    scene.triangles.iter().map(|t| u64::from(density.resolution(&corners(scene, t), 0.0)).pow(2)).sum()
}

fn corners(scene: &Scene, triangle: &[u32; 3]) -> [glam::Vec3; 3] {
    triangle.map(|v| scene.positions[v as usize])
}

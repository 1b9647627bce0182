//! The cells that the surface is cut into.

use crate::scene::Scene;

/// r² cells a triangle, so that all cells have about the same area: first cell of each triangle, triangle of each cell.
/// And the area that cells were to have.
pub(super) fn cut(scene: &Scene, triangles: &[[u32; 3]], budget: u32) -> (Vec<u32>, Vec<u32>, f64) {
    let cell = cell_area(scene, triangles, budget);
    let mut first = Vec::with_capacity(triangles.len() + 1);
    let mut owner = Vec::new();
    for (index, triangle) in triangles.iter().enumerate() {
        first.push(owner.len() as u32);
        owner.extend(std::iter::repeat_n(index as u32, cells_of(scene, triangle, cell)));
    }
    first.push(owner.len() as u32);
    (first, owner, cell)
}

/// Number of cells that a surface which is to be cut into about `budget` comes to: each triangle has one.
pub fn count(scene: &Scene, budget: u32) -> u64 {
    let cell = cell_area(scene, &scene.triangles, budget);
    scene.triangles.iter().map(|t| cells_of(scene, t, cell) as u64).sum()
}

fn cell_area(scene: &Scene, triangles: &[[u32; 3]], budget: u32) -> f64 {
    triangles.iter().map(|t| area(scene, t)).sum::<f64>() / f64::from(budget.max(1))
}

fn cells_of(scene: &Scene, triangle: &[u32; 3], cell: f64) -> usize {
    ((area(scene, triangle) / cell).sqrt().round() as usize).clamp(1, 1024).pow(2)
}

fn area(scene: &Scene, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| scene.positions[v as usize]);
    f64::from((b - a).cross(c - a).length()) * 0.5
}

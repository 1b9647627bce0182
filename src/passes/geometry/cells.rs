//! The cells that the surface is cut into.

use crate::math::density::{Density, Focus};
use crate::scene::{Camera, Lens, Scene};
use glam::Vec3;

/// Cameras of a file near which cells are finer: its first ones.
const MOST_CAMERAS: usize = 16;
/// Share of all cameras together beside that of all detail, which is 1.
const CAMERAS: f32 = 3.0;

/// How finely the surface is cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellBudget {
    /// Cells altogether, about: each triangle has one at least.
    pub count: u32,
    /// Where cells are finer; nowhere without.
    pub foci: Vec<Focus>,
}

impl CellBudget {
    /// So many, all of one size.
    pub fn even(count: u32) -> Self {
        Self { count, foci: Vec::new() }
    }

    /// So many, finer near the detail of `scene` and near the cameras of its file.
    pub fn focused(scene: &Scene, count: u32) -> Self {
        let core = scene.core();
        let is_near = |c: &[Vec3; 3]| !core.is_apart || c.iter().any(|p| p.distance(core.centre) <= core.radius);
        let triangles: Vec<_> = scene.triangles.iter().map(|t| corners(scene, t)).filter(is_near).collect();
        let mut foci = Focus::detail(&triangles, core.radius);
        let perspective = |camera: &&Camera| matches!(camera.lens, Lens::Perspective { .. });
        let cameras = || scene.cameras.iter().filter(perspective).take(MOST_CAMERAS);
        let share = CAMERAS / cameras().count() as f32;
        foci.extend(cameras().map(|camera| {
            let position = camera.camera_to_world.w_axis.truncate().as_vec3();
            Focus { share, ..Focus::camera(position, core.radius) }
        }));
        foci.iter_mut().for_each(|focus| focus.in_core = core.is_apart);
        Self { count, foci }
    }

    fn density(&self, scene: &Scene, triangles: &[[u32; 3]]) -> Density {
        Density::new(triangles.iter().map(|t| corners(scene, t)), self.count, &self.foci)
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

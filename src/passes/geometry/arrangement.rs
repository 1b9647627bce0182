//! A scene's surface as it will be uploaded: all of it on the CPU, so that what it will take is known.

use super::super::cluster_tree::{self, Cells, Detail};
use super::cells::{self, CellBudget};
use super::needs::SurfaceSize;
use super::order::{Order, as_usize, clusters};
use crate::scene::{Part, Scene};

/// The surface's triangles in order, their clusters, cells and tree.
pub struct Arrangement {
    pub(super) order: Order,
    /// Around each cluster.
    pub(super) spheres: Vec<[f32; 4]>,
    /// First cell of each triangle, and the end; coarse triangles of the tree follow.
    pub(super) first_cell: Vec<u32>,
    /// Triangle of each cell.
    pub(super) cell_triangle: Vec<u32>,
    /// First cell of each part, and the end.
    pub(super) part_cells: Vec<u32>,
    pub(super) tree: Option<cluster_tree::Arranged>,
}

impl Arrangement {
    /// Arranges the surface of `scene`, cut into `cells`; with `detail`, in a tree too.
    pub fn new(scene: &Scene, cells: &CellBudget, detail: Option<Detail>) -> Self {
        let order = Order::new(scene);
        let triangles = &order.triangles;
        let (mut first_cell, cell_triangle, density) = cells::cut(scene, triangles, cells);
        let first_of_part = |part: &Part| first_cell[part.first_triangle as usize];
        let part_cells = order.parts.iter().map(first_of_part).chain(first_cell.last().copied()).collect();
        let spheres = order.ranges.iter().flat_map(|r| clusters(scene, &triangles[as_usize(&r.triangles)])).collect();
        let cells = Cells { first: &mut first_cell, density: &density };
        let tree = detail.map(|detail| cluster_tree::Arranged::new(scene, (triangles, &order.parts), cells, detail));
        Self { spheres, first_cell, cell_triangle, part_cells, tree, order }
    }

    /// What counts of its size.
    pub fn size(&self) -> SurfaceSize {
        SurfaceSize {
            cells: self.cell_triangle.len() as u64,
            tree: self.tree.as_ref().map(cluster_tree::Arranged::size),
        }
    }
}

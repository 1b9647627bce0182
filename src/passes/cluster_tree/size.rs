//! What a tree takes of the device's memory.

use super::{Bounds, CHILDREN, CLUSTER, Detail};
use crate::math::levels::MOST_COARSE_CELLS;
use crate::vk::Device;
use glam::Vec4;

/// Bytes of a texel, and of a node without levels of detail and with them.
const TEXEL: u64 = size_of::<Vec4>() as u64;
const NODE: u64 = 2 * TEXEL;

/// Bytes of each of its buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TreeSize {
    /// Boxes of octets.
    pub octets: u64,
    /// Nodes.
    pub nodes: u64,
    /// Corners of triangles.
    pub corners: u64,
    /// Bits of alpha masks.
    pub masks: u64,
    /// What coarse cells show.
    pub shown_cells: u64,
    /// Number of coarse triangles, each of which has a first cell beside those of the surface.
    pub coarse_triangles: u64,
}

impl TreeSize {
    /// Of so many triangles that are drawn as they are, but for alpha masks; with levels of detail it is more.
    pub fn exact(triangles: usize) -> Self {
        let clusters = triangles.div_ceil(CLUSTER) as u64;
        let mut nodes = clusters;
        let mut level = clusters.div_ceil(CHILDREN as u64);
        while level > 1 {
            nodes += level;
            level = level.div_ceil(CHILDREN as u64);
        }
        Self::of(clusters, (nodes + level) * NODE)
    }

    /// What it usually comes to, of so many triangles with so many cells, but for alpha masks.
    pub fn about(detail: Detail, triangles: usize, cells: u64) -> Self {
        if detail == Detail::Exact {
            return Self::exact(triangles);
        }
        // Simplified by halves, a surface's levels have as many triangles as itself. Clusters are not quite full, and groups
        // have five of them, about.
        let clusters = (triangles * 9 / 4).div_ceil(CLUSTER) as u64;
        let shown_cells = u64::from(MOST_COARSE_CELLS) * cells * size_of::<u32>() as u64;
        Self { shown_cells, coarse_triangles: triangles as u64, ..Self::of(clusters, clusters * 5 / 4 * 2 * NODE) }
    }

    fn of(clusters: u64, nodes: u64) -> Self {
        let triangles = clusters * CLUSTER as u64;
        let octets = triangles / CHILDREN as u64 * size_of::<Bounds>() as u64;
        Self { octets, nodes, corners: 3 * TEXEL * triangles, ..Self::default() }
    }

    /// Why it does not fit into the texel buffers of the device, if so.
    pub fn misfit(&self, device: &Device) -> Option<String> {
        let largest = self.corners.max(self.nodes).max(self.octets).max(self.masks).div_ceil(TEXEL);
        let most = device.capabilities.limits.max_texel_buffer_elements;
        let why =
            || format!("the scene's triangles take {largest} texels, and a texel buffer of the device holds {most}");
        (largest > u64::from(most)).then(why)
    }
}

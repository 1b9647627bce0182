//! What a scene's geometry will take of the device's memory, told before any of it is allocated.

use super::super::cluster_tree::{Detail, TreeSize};
use super::{CellBudget, TRIANGLES_IN_ROW, UNSHARED, cells};
use crate::scene::Scene;
use crate::vk::Device;

/// A buffer or an image that will be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Name of its use, as [`crate::vk::MemoryUse::by_use`] has it.
    pub used_for: &'static str,
    /// Bytes, all that have this use together.
    pub bytes: u64,
    /// The largest one of them in bytes.
    pub largest: u64,
    /// Bytes that the device allows one to have.
    pub allowed: u64,
}

/// What counts of a surface's size beside its triangles and vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceSize {
    /// Number of its cells.
    pub cells: u64,
    /// Of its tree, if it has one.
    pub tree: Option<TreeSize>,
}

impl SurfaceSize {
    /// That of `scene`, cut into `cells`, before it is arranged: levels of detail are told by what they usually come to.
    pub fn about(scene: &Scene, cells: &CellBudget, detail: Option<Detail>) -> Self {
        let cells = cells::count(scene, cells);
        Self { cells, tree: detail.map(|detail| TreeSize::about(detail, scene.triangles.len(), cells)) }
    }

    /// The same without levels of detail, alpha masks and all else that only arranging it tells.
    pub fn least(scene: &Scene, cells: &CellBudget, detail: Option<Detail>) -> Self {
        Self::about(scene, cells, detail.map(|_| Detail::Exact))
    }
}

/// What [`super::Geometry::of`] will allocate for `scene`, of that `size`, that grows with it; and the triangles that shadows
/// read, if `lit`.
pub fn needs(device: &Device, scene: &Scene, size: &SurfaceSize, lit: bool) -> Vec<Need> {
    let limits = &device.capabilities.limits;
    let storage = u64::from(limits.max_storage_buffer_range);
    let texels = u64::from(limits.max_texel_buffer_elements) * 16;
    let rows = u64::from(limits.max_image_dimension2_d) * u64::from(3 * TRIANGLES_IN_ROW) * 16;
    let (vertices, triangles) = (scene.positions.len() as u64, scene.triangles.len() as u64);
    let (cells, tree) = (size.cells, size.tree.unwrap_or_default());
    let mut all = Vec::new();
    let mut need = |used_for, buffers: &[u64], allowed| {
        let (bytes, largest) = (buffers.iter().sum(), buffers.iter().copied().max().unwrap_or(0));
        if bytes > 0 {
            all.push(Need { used_for, bytes, largest, allowed });
        }
    };
    need("vertex positions", &[12 * vertices], storage);
    need("vertex normals", &[4 * vertices], storage);
    need("texture coordinates", &scene.uvs.each_ref().map(|uv| 8 * uv.len() as u64), storage);
    need("vertex tangents", &[16 * scene.tangents.len() as u64], storage);
    need("vertex colours", &[16 * scene.colors.len() as u64], storage);
    need("triangle indices", &[12 * triangles], storage);
    need("surface cells", &[4 * (triangles + tree.coarse_triangles), 4 * cells], storage);
    need("surface radiance", &[24 * cells], storage);
    if lit {
        need("linked triangles", &[48 * triangles.next_multiple_of(u64::from(TRIANGLES_IN_ROW))], rows);
    }
    // Vertices that no pass reads as storage: only memory limits them.
    let unshared = if device.capabilities.primitive_id { 0 } else { triangles };
    need(UNSHARED, &[36 * unshared, 12 * unshared], u64::MAX);
    need("capture corners", &[tree.corners], texels);
    need("cluster bounds", &[triangles / 4, tree.octets, tree.nodes], texels);
    need("alpha masks", &[tree.masks], texels);
    need("coarse cells", &[tree.shown_cells], storage);
    all
}

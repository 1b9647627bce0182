//! What a scene's geometry will take of the device's memory, told before any of it is allocated.

use super::super::cluster_tree::Detail;
use super::{CellBudget, TRIANGLES_IN_ROW, cells};
use crate::math::levels::MOST_COARSE_CELLS;
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

/// What [`super::Geometry::new`] will allocate for `scene` that grows with it, its surface cut into `cells`; and the
/// triangles that shadows read, if `lit`. What levels of detail add is told by what they usually come to.
pub fn needs(device: &Device, scene: &Scene, cells: &CellBudget, detail: Option<Detail>, lit: bool) -> Vec<Need> {
    let limits = &device.capabilities.limits;
    let storage = u64::from(limits.max_storage_buffer_range);
    let texels = u64::from(limits.max_texel_buffer_elements) * 16;
    let rows = u64::from(limits.max_image_dimension2_d) * u64::from(3 * TRIANGLES_IN_ROW) * 16;
    let (vertices, triangles) = (scene.positions.len() as u64, scene.triangles.len() as u64);
    let cells = cells::count(scene, cells);
    let has_levels = detail == Some(Detail::Levels);
    // Simplified by halves, a surface's levels have as many triangles as itself. Their clusters are not quite full.
    let coarse = if has_levels { triangles } else { 0 };
    let in_tree = match detail {
        None => 0,
        Some(Detail::Exact) => triangles,
        Some(Detail::Levels) => triangles * 9 / 4,
    };
    // Octets have boxes of two texels, clusters and what holds them two or four; groups have five clusters, about.
    let nodes = if has_levels { in_tree * 5 / 4 } else { in_tree * 4 / 7 };
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
    need("surface cells", &[4 * (triangles + coarse), 4 * cells], storage);
    need("surface radiance", &[24 * cells], storage);
    if lit {
        need("linked triangles", &[48 * triangles.next_multiple_of(u64::from(TRIANGLES_IN_ROW))], rows);
    }
    let unshared = if device.capabilities.primitive_id { 0 } else { triangles };
    let corners = 48 * in_tree.next_multiple_of(u64::from(super::CLUSTER));
    need("capture corners", &[36 * unshared, 12 * unshared, corners], texels);
    need("cluster bounds", &[triangles / 4, in_tree * 4, nodes], texels);
    if has_levels {
        need("coarse cells", &[4 * u64::from(MOST_COARSE_CELLS) * cells], storage);
    }
    all
}

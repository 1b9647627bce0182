//! The scene's geometry on the GPU: vertex streams, triangles in an order made for culling, clusters, surface cells.

mod arrangement;
mod cells;
mod needs;
mod order;

pub use arrangement::Arrangement;
pub use cells::{CellBudget, count as cell_count};
pub use needs::{Need, SurfaceSize, needs};

use super::cluster_tree::{ClusterTree, Detail};
use crate::math::core::Core;
use crate::math::{adjacency, levels};
use crate::scene::{Part, Scene};
use crate::vk::{Binding, Buffer, DescriptorSet, Device, Image, ImageDesc, Memory, Result, SetLayout};
use ash::vk;
use glam::Vec3;
use order::bounds;
use std::ops::Range;
use std::sync::Arc;

/// Triangles of a cluster: culled and drawn together.
pub const CLUSTER: u32 = levels::CLUSTER as u32;

/// Triangles in a row of the image of [`Geometry::linked_triangles`]; `SHADOW_ROW` in `glsl/inc/shadow.glsl`.
const TRIANGLES_IN_ROW: u32 = 1024;

const UNSHARED: &str = "unshared corners";

/// Triangles that are drawn alike in captures: all opaque ones, or those of one masked material.
#[derive(Clone, Debug)]
pub struct DrawRange {
    /// Masked material, or `None` for opaque triangles.
    pub masked: Option<u32>,
    /// Triangles in the geometry's order.
    pub triangles: Range<u32>,
    /// Clusters in the geometry's order.
    pub clusters: Range<u32>,
}

/// Vertex streams that the scene has beyond positions and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Streams {
    /// Texture coordinate sets.
    pub uvs: [bool; 2],
    /// Tangents.
    pub tangents: bool,
    /// Vertex colours.
    pub colors: bool,
}

/// Geometry buffers and what the CPU knows about their order.
pub struct Geometry {
    /// Triangles of each material, in the geometry's order.
    pub parts: Vec<Part>,
    /// Draw ranges: opaque triangles first.
    pub ranges: Vec<DrawRange>,
    /// Triangles, in the geometry's order.
    pub triangles: Vec<[u32; 3]>,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Number of clusters.
    pub cluster_count: u32,
    /// Number of surface cells.
    pub cell_count: u32,
    /// First cell of each part, and the end.
    pub part_cells: Vec<u32>,
    /// Streams it has.
    pub streams: Streams,
    /// Half the diagonal of the bounding box; 1 where there are no triangles.
    pub radius: f32,
    /// Lowest and highest corner of the bounding box.
    pub bounds: [Vec3; 2],
    /// The ball about what lies together in a far larger scene, or about all of it.
    pub core: Core,
    /// Set 0 of `glsl/inc/scene.glsl`.
    pub set: DescriptorSet,
    /// Its layout.
    pub set_layout: SetLayout,
    /// Spheres of the clusters (centre, radius).
    pub clusters: Buffer,
    /// First cell of each triangle, and the end; coarse triangles of the tree follow.
    pub first_cell: Buffer,
    /// Triangle of each cell.
    pub cell_triangle: Buffer,
    /// Radiance to front and back of each cell, six floats.
    pub cell_radiance: Buffer,
    /// Three corners a triangle, without sharing, for devices that cannot tell a shared vertex's triangle.
    corners: Option<Buffer>,
    /// Indices 0, 1, 2, … of these corners.
    corner_indices: Option<Buffer>,
    /// The tree that captures in compute walk.
    pub tree: Option<ClusterTree>,
    /// Vertex positions.
    pub positions: Buffer,
    /// Triangle corners.
    pub indices: Buffer,
    _normals: Buffer,
    _streams: Vec<Buffer>,
    _materials: Buffer,
}

impl Geometry {
    /// Uploads `scene`, its surface cut into `cells`.
    ///
    /// With `detail`, hemicubes are rasterised in compute, from a tree of clusters.
    pub fn new(device: &Arc<Device>, scene: &Scene, cells: &CellBudget, detail: Option<Detail>) -> Result<Self> {
        Self::of(device, scene, Arrangement::new(scene, cells, detail))
    }

    /// Uploads `scene`, whose surface was arranged.
    pub fn of(device: &Arc<Device>, scene: &Scene, arrangement: Arrangement) -> Result<Self> {
        let Arrangement { order, spheres, first_cell, cell_triangle, part_cells, tree } = arrangement;
        let tree = tree.map(|tree| ClusterTree::new(device, tree)).transpose()?;
        let triangles = &order.triangles;
        let positions: Vec<[f32; 3]> = scene.positions.iter().map(|p| p.to_array()).collect();
        let normals: Vec<u32> = scene.normals.iter().map(|n| oct_encode(*n)).collect();
        let positions_buffer = Buffer::with_data(device, "vertex positions", &positions)?;
        let indices = Buffer::with_data(device, "triangle indices", triangles)?;
        let normals = Buffer::with_data(device, "vertex normals", &normals)?;
        let materials: Vec<_> = scene.materials.iter().map(super::material::gpu_material).collect();
        let materials = Buffer::with_data(device, "materials", &materials)?;
        let (streams, extra) = upload_streams(device, scene)?;
        let stream = |index: usize| extra[index].as_ref().unwrap_or(&positions_buffer);
        let bindings = [
            Binding::Storage(&positions_buffer),
            Binding::Storage(&indices),
            Binding::Storage(&normals),
            Binding::Storage(stream(0)),
            Binding::Storage(stream(1)),
            Binding::Storage(stream(2)),
            Binding::Storage(stream(3)),
            Binding::Storage(&materials),
        ];
        let set_layout = SetLayout::new(device, &[vk::DescriptorType::STORAGE_BUFFER; 8])?;
        let set = DescriptorSet::new(&set_layout, &bindings)?;
        let unshared = !device.capabilities.primitive_id;
        let corners = || triangles.iter().flatten().map(|v| positions[*v as usize]).collect::<Vec<_>>();
        let corners = unshared.then(|| Buffer::with_vertices(device, UNSHARED, &corners())).transpose()?;
        let counting = || (0..3 * triangles.len() as u32).collect::<Vec<u32>>();
        let corner_indices = unshared.then(|| Buffer::with_vertices(device, UNSHARED, &counting())).transpose()?;
        let bounds = bounds(&scene.positions);
        Ok(Self {
            parts: order.parts,
            ranges: order.ranges,
            triangle_count: triangles.len() as u32,
            cluster_count: spheres.len() as u32,
            cell_count: cell_triangle.len() as u32,
            part_cells,
            streams,
            radius: if triangles.is_empty() { 1.0 } else { (bounds[1] - bounds[0]).length() * 0.5 },
            bounds,
            core: scene.core(),
            set,
            set_layout,
            clusters: Buffer::with_data(device, "cluster bounds", &spheres)?,
            first_cell: Buffer::with_data(device, "surface cells", &first_cell)?,
            cell_triangle: Buffer::with_data(device, "surface cells", &cell_triangle)?,
            cell_radiance: Buffer::new(device, "surface radiance", cell_triangle.len() as u64 * 24, Memory::Device)?,
            corners,
            corner_indices,
            tree,
            positions: positions_buffer,
            indices,
            _normals: normals,
            _streams: extra.into_iter().flatten().collect(),
            _materials: materials,
            triangles: order.triangles,
        })
    }

    /// Uploads each triangle as three texels in a row: a corner's position, and the triangle across the edge opposite to it.
    ///
    /// An image, because some devices fetch a texel of four words several times faster than words from a buffer.
    pub fn linked_triangles(&self, device: &Arc<Device>, positions: &[Vec3]) -> Result<Image> {
        let across = adjacency::neighbours(&self.triangles, positions);
        let texel = |vertex: u32, across: u32| {
            let [x, y, z] = positions[vertex as usize].to_array().map(f32::to_bits);
            [x, y, z, across]
        };
        let rows = self.triangles.len().div_ceil(TRIANGLES_IN_ROW as usize).max(1) as u32;
        let size = [3 * TRIANGLES_IN_ROW, rows];
        let linked =
            self.triangles.iter().zip(&across).flat_map(|(t, across)| [0, 1, 2].map(|i| texel(t[i], across[i])));
        let mut texels: Vec<[u32; 4]> = linked.collect();
        texels.resize((size[0] * size[1]) as usize, [0; 4]);
        let (format, usage) = (vk::Format::R32G32B32A32_UINT, vk::ImageUsageFlags::SAMPLED);
        let image = Image::new(device, ImageDesc { used_for: "linked triangles", format, size, layers: None, usage })?;
        image.upload(bytemuck::cast_slice(&texels))?;
        Ok(image)
    }

    /// Uploads the triangles across the edges opposite to the corners of each, by their numbers plus 1; 0 where there are none.
    pub fn neighbours(&self, device: &Arc<Device>, positions: &[Vec3]) -> Result<Buffer> {
        let across = adjacency::neighbours(&self.triangles, positions);
        let numbers: Vec<_> = across.into_iter().map(|next| next.map(|n| n.wrapping_add(1))).collect();
        Buffer::with_data(device, "capture neighbours", &numbers)
    }

    /// The vertex and index buffer that captures draw.
    pub fn capture_buffers(&self) -> (&Buffer, &Buffer) {
        match (&self.corners, &self.corner_indices) {
            (Some(corners), Some(indices)) => (corners, indices),
            _ => (&self.positions, &self.indices),
        }
    }
}

fn upload_streams(device: &Arc<Device>, scene: &Scene) -> Result<(Streams, [Option<Buffer>; 4])> {
    let streams = Streams {
        uvs: [!scene.uvs[0].is_empty(), !scene.uvs[1].is_empty()],
        tangents: !scene.tangents.is_empty(),
        colors: !scene.colors.is_empty(),
    };
    let uv = |set: usize| {
        let data: Vec<[f32; 2]> = scene.uvs[set].iter().map(|v| v.to_array()).collect();
        Buffer::with_data(device, "texture coordinates", &data)
    };
    let four = |name, data: &[glam::Vec4]| {
        let data: Vec<[f32; 4]> = data.iter().map(|v| v.to_array()).collect();
        Buffer::with_data(device, name, &data)
    };
    let buffers = [
        streams.uvs[0].then(|| uv(0)).transpose()?,
        streams.uvs[1].then(|| uv(1)).transpose()?,
        streams.tangents.then(|| four("vertex tangents", &scene.tangents)).transpose()?,
        streams.colors.then(|| four("vertex colours", &scene.colors)).transpose()?,
    ];
    Ok((streams, buffers))
}

/// Octahedral unit vector in 2 × 16 bits; twin of `oct_encode` in `glsl/inc/oct.glsl`.
fn oct_encode(v: Vec3) -> u32 {
    let sum = v.x.abs() + v.y.abs() + v.z.abs();
    let (mut x, mut y) = (v.x / sum, v.y / sum);
    if v.z < 0.0 {
        let sign = |s: f32| if s >= 0.0 { 1.0 } else { -1.0 };
        (x, y) = ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y));
    }
    let snorm = |f: f32| u32::from((f.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    snorm(x) | snorm(y) << 16
}

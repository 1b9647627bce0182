//! The scene's triangles as a tree for captures in compute: octets of triangles, clusters of eight octets, groups of up to
//! eight clusters, and so on, up to eight children a node, each with its box, and with levels of detail the bounds of its error.

mod bounds;
mod nodes;
mod size;
mod sort;

use crate::math::adjacency;
use crate::math::density::Density;
use crate::math::levels::{Bound, CLUSTER, Cluster, First, Levels, Surface};
use crate::scene::opacity::{Mask, Opacity};
use crate::scene::{Part, Scene};
use crate::vk::{Buffer, Device, Result, TexelBuffer};
use bounds::Bounds;
use glam::{Vec3, Vec4};
use nodes::{Group, Node, nodes_of};
use rayon::prelude::*;
pub use size::TreeSize;
use sort::{Item, sorted};
use std::ops::Range;
use std::sync::Arc;

/// Children of a node; triangles of an octet, the lowest kind of node.
const CHILDREN: usize = 8;
/// Error of coarse triangles, at distance 1, that the tree is arranged for: the usual one. With another one captures are as
/// right, and a little slower.
const USUAL_ERROR: f32 = 0.025 * 2.0 / 32.0;

/// What is drawn at a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// What is drawn nearby.
    Exact,
    /// Coarser clusters that stand for the opaque ones.
    Levels,
}

/// The tree on the device.
pub struct ClusterTree {
    /// What its walk begins with: eight times the first child of its root, and how many more that has; none of an empty one.
    pub root: Option<u32>,
    /// Number of clusters: the first nodes.
    pub clusters: u32,
    /// Boxes of the octets: lowest and highest corner.
    pub octets: TexelBuffer,
    /// The nodes.
    pub nodes: TexelBuffer,
    /// Three corners a triangle, 64 triangles a cluster, the last ones points where a cluster has fewer; w (bits): its first
    /// surface cell; how many lie along a side, in the upper half, and of its alpha mask; the mask's first texel.
    pub corners: TexelBuffer,
    /// Number of each of these triangles among the scene's; those of coarse ones and of points are greater than any of them.
    order: Vec<u32>,
    /// Bits of alpha masks, where the scene has some.
    pub masks: Option<TexelBuffer>,
    /// Of each coarse cell the cell that it shows, where clusters have levels.
    pub shown_cell: Option<Buffer>,
}

/// Cells of the surface.
pub struct Cells<'a> {
    /// First cell of each triangle, and the end; coarse triangles are added.
    pub first: &'a mut Vec<u32>,
    /// How densely the surface is cut into them.
    pub density: &'a Density,
}

/// The tree before any of it is on the device: what that will take is known.
pub struct Arranged {
    root: Option<u32>,
    octets: Vec<Bounds>,
    nodes: Vec<Vec4>,
    corners: Vec<[Vec4; 3]>,
    order: Vec<u32>,
    masks: Vec<u32>,
    shown_cell: Option<Vec<u32>>,
    coarse_triangles: usize,
}

impl Arranged {
    /// Arranges `triangles` of `scene`, opaque ones first, which `parts` give materials to.
    pub fn new(scene: &Scene, (triangles, parts): (&[[u32; 3]], &[Part]), cells: Cells<'_>, detail: Detail) -> Self {
        let opaque = scene.opaque_count();
        let levels = (detail == Detail::Levels).then(|| {
            let (positions, first_cell) = (&scene.positions, &*cells.first);
            let simplified = &triangles[..opaque as usize];
            let surface = Surface {
                positions,
                triangles: simplified,
                first_cell,
                density: cells.density,
                radius: scene.core().radius,
            };
            let first = First { triangle: triangles.len() as u32, cell: cells.first[triangles.len()] };
            Levels::new(&surface, first)
        });
        let mut all = Triangles {
            positions: &scene.positions,
            corners: triangles.to_vec(),
            first_cell: &[],
            opacity: scene.opacity(triangles, parts),
        };
        let end = triangles.len() as u32;
        let Some(levels) = levels else {
            all.first_cell = cells.first;
            let groups = Group::in_order(&all.with_bounds(all.clusters(0..end)));
            return Self::of(all, &groups, None);
        };
        all.corners.extend(&levels.triangles);
        cells.first.extend(&levels.first_cell[1..]);
        all.first_cell = cells.first;
        let mut clusters = levels.clusters;
        clusters.par_iter_mut().for_each(|c| all.sort(&mut c.triangles));
        clusters.extend(all.clusters(opaque..end));
        let groups = Group::by_visits(&all.with_bounds(clusters), USUAL_ERROR);
        let coarse_triangles = levels.triangles.len();
        Self { coarse_triangles, ..Self::of(all, &groups, Some(levels.shown_cell)) }
    }

    fn of(triangles: Triangles<'_>, groups: &[Group], shown_cell: Option<Vec<u32>>) -> Self {
        let clusters = || groups.iter().flat_map(|g| &g.clusters);
        let mut corners = Vec::with_capacity(clusters().count() * CLUSTER);
        let mut order = Vec::with_capacity(corners.capacity());
        for (cluster, _) in clusters() {
            corners.extend(cluster.triangles.iter().map(|t| triangles.named(*t)));
            let last = corners.last().map_or(Vec4::ZERO, |[a, ..]: &[Vec4; 3]| a.truncate().extend(0.0));
            corners.resize(corners.len().next_multiple_of(CLUSTER), [last; 3]);
            order.extend(&cluster.triangles);
            order.resize(corners.len(), adjacency::NONE);
        }
        let octets: Vec<_> = corners.chunks(CHILDREN).map(|c| Bounds::of_corners(c.as_flattened())).collect();
        let nodes = nodes_of(groups);
        Self {
            root: nodes.last().map(Node::children),
            octets,
            nodes: nodes.iter().flat_map(|n| n.texels(shown_cell.is_some())).collect(),
            corners,
            order,
            masks: triangles.opacity.words,
            shown_cell,
            coarse_triangles: 0,
        }
    }

    /// What it will take of the device.
    pub fn size(&self) -> TreeSize {
        let Self { root: _, octets, nodes, corners, order: _, masks, shown_cell, coarse_triangles } = self;
        TreeSize {
            octets: size_of_val(&octets[..]) as u64,
            nodes: size_of_val(&nodes[..]) as u64,
            corners: size_of_val(&corners[..]) as u64,
            masks: size_of_val(&masks[..]) as u64,
            shown_cells: size_of_val(shown_cell.as_deref().unwrap_or_default()) as u64,
            coarse_triangles: *coarse_triangles as u64,
        }
    }
}

impl ClusterTree {
    /// Uploads what was arranged.
    pub fn new(device: &Arc<Device>, arranged: Arranged) -> Result<Self> {
        let Arranged { root, octets, nodes, corners, order, masks, shown_cell, .. } = arranged;
        let new_masks = || TexelBuffer::with_data(device, "alpha masks", &masks);
        let shown = |cells: Vec<u32>| Buffer::with_data(device, "coarse cells", &cells);
        Ok(Self {
            root,
            clusters: (corners.len() / CLUSTER) as u32,
            octets: TexelBuffer::with_data(device, "cluster bounds", &octets)?,
            nodes: TexelBuffer::with_data(device, "cluster bounds", &nodes)?,
            corners: TexelBuffer::with_data(device, "capture corners", &corners)?,
            order,
            masks: (!masks.is_empty()).then(new_masks).transpose()?,
            shown_cell: shown_cell.map(shown).transpose()?,
        })
    }

    /// The triangles across the edges opposite to the corners of each, by their places in [`Self::corners`] plus 1, as bits; 0
    /// where there are none. `across`: the same by the scene's numbers.
    pub fn neighbours(&self, device: &Arc<Device>, across: &[[u32; 3]]) -> Result<TexelBuffer> {
        let mut places = vec![0; across.len()];
        for (place, triangle) in (1..).zip(&self.order) {
            if let Some(of) = places.get_mut(*triangle as usize) {
                *of = place;
            }
        }
        let place = |triangle: u32| f32::from_bits(places.get(triangle as usize).copied().unwrap_or(0));
        let texel = |triangle: &u32| {
            across.get(*triangle as usize).map_or(Vec4::ZERO, |next| Vec3::from(next.map(place)).extend(0.0))
        };
        let texels: Vec<Vec4> = self.order.iter().map(texel).collect();
        TexelBuffer::with_data(device, "capture neighbours", &texels)
    }

    /// Whether some clusters stand for others at a distance.
    pub fn has_levels(&self) -> bool {
        self.shown_cell.is_some()
    }
}

/// Triangles of a tree.
struct Triangles<'a> {
    positions: &'a [Vec3],
    /// Corners of all triangles, coarse ones included.
    corners: Vec<[u32; 3]>,
    /// First cell of each, and the end.
    first_cell: &'a [u32],
    /// Alpha masks; coarse triangles have none.
    opacity: Opacity,
}

impl Triangles<'_> {
    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.corners[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// As the shader reads a triangle.
    fn named(&self, triangle: u32) -> [Vec4; 3] {
        let [a, b, c] = self.corners(triangle);
        let Mask { n, first } = self.opacity.masks.get(triangle as usize).copied().unwrap_or_default();
        let [cell, end] = [0, 1].map(|i| self.first_cell[triangle as usize + i]);
        let sides = (end - cell).isqrt() << 16 | n;
        [a.extend(f32::from_bits(cell)), b.extend(f32::from_bits(sides)), c.extend(f32::from_bits(first))]
    }

    fn bounds(&self, cluster: &Cluster) -> Bounds {
        cluster.triangles.iter().fold(Bounds::EMPTY, |b, t| b.joined(Bounds::of(&self.corners(*t))))
    }

    fn with_bounds(&self, clusters: Vec<Cluster>) -> Vec<(Cluster, Bounds)> {
        clusters.into_par_iter().map(|c| (self.bounds(&c), c)).map(|(bounds, c)| (c, bounds)).collect()
    }

    /// Brings neighbours together.
    fn sort(&self, triangles: &mut [u32]) {
        let item = |t: &u32| Item { bounds: Bounds::of(&self.corners(*t)), reach: None };
        let order = sorted(&triangles.iter().map(item).collect::<Vec<_>>());
        let sorted: Vec<u32> = order.iter().map(|i| triangles[*i as usize]).collect();
        triangles.copy_from_slice(&sorted);
    }

    /// Clusters of some triangles, of one level, neighbours after each other.
    fn clusters(&self, range: Range<u32>) -> Vec<Cluster> {
        let mut triangles: Vec<u32> = range.collect();
        self.sort(&mut triangles);
        let cluster =
            |piece: &[u32]| Cluster { triangles: piece.to_vec(), level: 0, own: Bound::EXACT, coarser: Bound::NEVER };
        triangles.chunks(CLUSTER).map(cluster).collect()
    }
}

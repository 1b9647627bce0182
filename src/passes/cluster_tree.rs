//! The scene's triangles as a tree for captures in compute: octets of triangles, clusters of eight octets, and so on, eight
//! children a node, each with its box, and with levels of detail the bounds of its error.

use super::geometry::CLUSTER;
use crate::math::levels::{Bound, Cluster, First, Levels, Surface};
use crate::scene::opacity::{Mask, Opacity};
use crate::scene::{Part, Scene};
use crate::vk::{Buffer, Device, Result, TexelBuffer};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use std::ops::Range;
use std::sync::Arc;

/// Children of a node; triangles of an octet, the lowest kind of node.
const CHILDREN: usize = 8;
/// Levels that a device walks, at most: 8¹⁰ triangles.
pub const MOST_LEVELS: usize = 10;

/// Texels of the corners' buffer that a triangle takes.
const CORNERS: u64 = 3;

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
    /// First node of each level, octets first, and the end.
    pub first: Vec<u32>,
    /// Boxes of the nodes: lowest and highest corner.
    pub boxes: TexelBuffer,
    /// Of the nodes from clusters on, where clusters have levels: the box of all that they stand for and of what replaces
    /// them; w of their highest corners are the errors: where there are several, the least and the largest.
    pub errors: Option<TexelBuffer>,
    /// Three corners a triangle, 64 triangles a cluster, the last ones points where a cluster has fewer; w (bits): number
    /// of the triangle, then its alpha mask.
    pub corners: TexelBuffer,
    /// Bits of alpha masks, where the scene has some.
    pub masks: Option<TexelBuffer>,
    /// Of each coarse cell the cell that it shows, where clusters have levels.
    pub shown_cell: Option<Buffer>,
}

/// Cells of the surface.
pub struct Cells<'a> {
    /// First cell of each triangle, and the end; coarse triangles are added.
    pub first: &'a mut Vec<u32>,
    /// Area of a cell, about.
    pub area: f64,
}

impl ClusterTree {
    /// Whether so many triangles fit into a buffer of the device.
    pub fn holds(device: &Device, triangles: usize) -> bool {
        triangles as u64 * CORNERS <= u64::from(device.capabilities.limits.max_texel_buffer_elements)
    }

    /// Arranges `triangles` of `scene`, opaque ones first, which `parts` give materials to.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        (triangles, parts): (&[[u32; 3]], &[Part]),
        cells: Cells<'_>,
        detail: Detail,
    ) -> Result<Self> {
        let opaque = scene.opaque_count();
        let levels = (detail == Detail::Levels).then(|| {
            let (positions, first_cell) = (&scene.positions, &*cells.first);
            let surface =
                Surface { positions, triangles: &triangles[..opaque as usize], first_cell, cell_area: cells.area };
            let first = First { triangle: triangles.len() as u32, cell: cells.first[triangles.len()] };
            Levels::new(&surface, first)
        });
        let mut all = Triangles {
            positions: &scene.positions,
            corners: triangles.to_vec(),
            opacity: scene.opacity(triangles, parts),
        };
        let end = triangles.len() as u32;
        let Some(levels) = levels else {
            return Self::of(device, &all, all.clusters(0..end), None);
        };
        all.corners.extend(&levels.triangles);
        cells.first.extend(&levels.first_cell[1..]);
        let mut clusters = levels.clusters;
        clusters.extend(all.clusters(opaque..end));
        Self::of(device, &all, all.in_groups(clusters), Some(&levels.shown_cell))
    }

    fn of(
        device: &Arc<Device>,
        triangles: &Triangles<'_>,
        clusters: Vec<Cluster>,
        shown_cell: Option<&Vec<u32>>,
    ) -> Result<Self> {
        let mut corners = Vec::with_capacity(clusters.len() * CLUSTER as usize);
        for cluster in &clusters {
            corners.extend(cluster.triangles.iter().map(|t| triangles.named(*t)));
            let last = corners.last().map_or(Vec4::ZERO, |[a, ..]: &[Vec4; 3]| a.truncate().extend(0.0));
            corners.resize(corners.len().next_multiple_of(CLUSTER as usize), [last; 3]);
        }
        let octets = corners.chunks(CHILDREN).map(|c| Bounds::of_corners(c.as_flattened())).collect();
        let (first, boxes) = levels_of(octets, |boxes| boxes.iter().fold(Bounds::EMPTY, |all, b| all.joined(*b)));
        let errors: Vec<_> = clusters.iter().map(|c| Errors { own: c.own.into(), coarser: c.coarser.into() }).collect();
        let errors = shown_cell.map(|_| levels_of(errors, Errors::around).1);
        let words = &triangles.opacity.words;
        let masks = || TexelBuffer::with_data(device, "alpha masks", words);
        let shown = |cells: &Vec<u32>| Buffer::with_data(device, "coarse cells", cells);
        Ok(Self {
            first,
            boxes: TexelBuffer::with_data(device, "cluster bounds", &boxes)?,
            errors: errors.map(|errors| TexelBuffer::with_data(device, "cluster bounds", &errors)).transpose()?,
            corners: TexelBuffer::with_data(device, "capture corners", &corners)?,
            masks: (!words.is_empty()).then(masks).transpose()?,
            shown_cell: shown_cell.map(shown).transpose()?,
        })
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
        [a.extend(f32::from_bits(triangle)), b.extend(f32::from_bits(n)), c.extend(f32::from_bits(first))]
    }

    fn bounds(&self, cluster: &Cluster) -> Bounds {
        cluster.triangles.iter().fold(Bounds::EMPTY, |b, t| b.joined(Bounds::of(&self.corners(*t))))
    }

    /// Clusters of some triangles, of one level, neighbours after each other.
    fn clusters(&self, range: Range<u32>) -> Vec<Cluster> {
        let boxes: Vec<_> = range.clone().map(|t| Bounds::of(&self.corners(t))).collect();
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        sort(&boxes, &mut order);
        let cluster = |piece: &[u32]| Cluster {
            triangles: piece.iter().map(|t| range.start + t).collect(),
            level: 0,
            own: Bound::EXACT,
            coarser: Bound::NEVER,
        };
        order.chunks(CLUSTER as usize).map(cluster).collect()
    }

    /// Clusters by level, neighbours after each other, and so their triangles.
    fn in_groups(&self, mut clusters: Vec<Cluster>) -> Vec<Cluster> {
        for cluster in &mut clusters {
            let boxes: Vec<_> = cluster.triangles.iter().map(|t| Bounds::of(&self.corners(*t))).collect();
            let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
            sort(&boxes, &mut order);
            cluster.triangles = order.iter().map(|i| cluster.triangles[*i as usize]).collect();
        }
        clusters.sort_by_key(|c| c.level);
        let mut grouped = Vec::with_capacity(clusters.len());
        for level in clusters.chunk_by(|a, b| a.level == b.level) {
            let boxes: Vec<_> = level.iter().map(|c| self.bounds(c)).collect();
            let mut order: Vec<u32> = (0..level.len() as u32).collect();
            sort(&boxes, &mut order);
            grouped.extend(order.iter().map(|i| level[*i as usize].clone()));
        }
        grouped
    }
}

/// All levels of a tree above `leaves`, one after the other, up to the root: a node is what `join` makes of its children.
/// And where each begins, and the end.
fn levels_of<T: Copy>(leaves: Vec<T>, join: impl Fn(&[T]) -> T) -> (Vec<u32>, Vec<T>) {
    let mut first = vec![0];
    let mut nodes = leaves;
    while nodes.len() > first[first.len() - 1] as usize + 1 {
        let level = nodes[first[first.len() - 1] as usize..].chunks(CHILDREN).map(&join).collect::<Vec<_>>();
        first.push(nodes.len() as u32);
        nodes.extend(level);
    }
    first.push(nodes.len() as u32);
    (first, nodes)
}

/// When a node is shown, as `glsl/capture_compute` reads it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Errors {
    own: Bounds,
    coarser: Bounds,
}

impl Errors {
    /// Of several: errors that hold for some of them, or none.
    fn around(nodes: &[Self]) -> Self {
        let mut all = nodes[0];
        for node in nodes {
            let least = all.own.high.w.min(node.own.high.w);
            all.own = all.own.joined(node.own);
            all.coarser = all.coarser.joined(node.coarser);
            all.own.high.w = least;
        }
        all
    }
}

impl From<Bound> for Bounds {
    fn from(b: Bound) -> Self {
        Self { low: b.low.extend(0.0), high: b.high.extend(b.error) }
    }
}

/// An axis-aligned box, as `glsl/capture_compute` reads it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Bounds {
    low: Vec4,
    high: Vec4,
}

impl Bounds {
    const EMPTY: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    fn of(points: &[Vec3]) -> Self {
        points.iter().map(|p| p.extend(0.0)).fold(Self::EMPTY, |b, p| b.with(p, p))
    }

    /// Of corners as the device has them.
    fn of_corners(corners: &[Vec4]) -> Self {
        corners.iter().fold(Self::EMPTY, |b, p| b.with(*p, *p))
    }

    fn around(boxes: &[Self], which: &[u32]) -> Self {
        which.iter().fold(Self::EMPTY, |b, i| b.joined(boxes[*i as usize]))
    }

    fn joined(self, other: Self) -> Self {
        self.with(other.low, other.high)
    }

    fn with(self, low: Vec4, high: Vec4) -> Self {
        Self { low: self.low.min(low), high: self.high.max(high) }
    }

    /// Half its surface area.
    fn area(self) -> f32 {
        let d = self.high - self.low;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// Orders what lies in `boxes` so that neighbours come together: halves of halves, cut where nodes are full.
fn sort(boxes: &[Bounds], order: &mut [u32]) {
    if order.len() <= CHILDREN {
        // What is drawn side by side: of like size, it takes like time.
        order.sort_by(|a, b| boxes[*b as usize].area().total_cmp(&boxes[*a as usize].area()));
        return;
    }
    let node = CHILDREN.pow((order.len() - 1).ilog(CHILDREN));
    let middle = order.len().div_ceil(node).div_ceil(2) * node;
    halve(boxes, order, middle);
    let (front, back) = order.split_at_mut(middle);
    rayon::join(|| sort(boxes, front), || sort(boxes, back));
}

/// Brings `middle` of the triangles to the front, so that both halves have small boxes: along an axis, or the larger ones
/// by themselves (surface area heuristic, Goldsmith and Salmon 1987).
fn halve(boxes: &[Bounds], order: &mut [u32], middle: usize) {
    let key = |by: usize, i: u32| {
        let b = &boxes[i as usize];
        if by < 3 { b.low[by] + b.high[by] } else { (b.low - b.high).min_element() }
    };
    let candidate = |by: usize| {
        let mut half = order.to_vec();
        half.select_nth_unstable_by(middle, |a, b| key(by, *a).total_cmp(&key(by, *b)));
        let cost = |part: &[u32]| Bounds::around(boxes, part).area() * part.len() as f32;
        let (front, back) = half.split_at(middle);
        (cost(front) + cost(back), half)
    };
    let best = (0..4).map(candidate).min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are four candidates");
    order.copy_from_slice(&best.1);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of small squares and one large triangle over all of it.
    fn sheet(side: u32) -> Vec<Bounds> {
        let square = |i: u32| {
            let low = Vec3::new((i % side) as f32, 0.0, (i / side) as f32);
            Bounds::of(&[low, low + Vec3::X + Vec3::Z])
        };
        let all = Bounds::of(&[Vec3::ZERO, Vec3::splat(side as f32)]);
        (0..side * side).map(square).chain([all]).collect()
    }

    #[test]
    fn every_triangle_is_in_one_compact_cluster() {
        let boxes = sheet(64);
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        sort(&boxes, &mut order);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..boxes.len() as u32), "an order of all triangles");
        let areas: Vec<f32> = order.chunks(64).map(|c| Bounds::around(&boxes, c).area()).collect();
        // 64 squares cover 64 at least; only the cluster of the large one may be large.
        let large = areas.iter().filter(|area| **area > 128.0).count();
        assert!(large <= 1, "{large} clusters are large: {areas:?}");
    }
}

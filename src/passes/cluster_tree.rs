//! The scene's triangles in an order for captures in compute: clusters of 64 neighbours, groups of 32 neighbouring
//! clusters, each with its box.

use super::geometry::CLUSTER;
use crate::scene::opacity::Mask;
use crate::scene::{Part, Scene};
use crate::vk::{Device, Result, TexelBuffer};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// Clusters of a group: those whose bits share a word.
const GROUP: usize = u32::BITS as usize;

/// Texels of the corners' buffer that a triangle takes.
const CORNERS: u64 = 3;

/// Clusters and groups on the device.
pub struct ClusterTree {
    /// Number of groups.
    pub group_count: u32,
    /// Number of clusters.
    pub cluster_count: u32,
    /// Boxes of the groups, lowest and highest corner.
    pub groups: TexelBuffer,
    /// Boxes of the clusters, likewise.
    pub clusters: TexelBuffer,
    /// Three corners a triangle, in the order of the clusters; w (bits): its number in the geometry's order, then its
    /// alpha mask.
    pub corners: TexelBuffer,
    /// Bits of alpha masks, where the scene has some.
    pub masks: Option<TexelBuffer>,
}

impl ClusterTree {
    /// Whether so many triangles fit into a buffer of the device.
    pub fn holds(device: &Device, triangles: usize) -> bool {
        triangles as u64 * CORNERS <= u64::from(device.capabilities.limits.max_texel_buffer_elements)
    }

    /// Orders `triangles` of `scene`, which `parts` give materials to.
    pub fn new(device: &Arc<Device>, scene: &Scene, triangles: &[[u32; 3]], parts: &[Part]) -> Result<Self> {
        let corners = |t: &[u32; 3]| t.map(|v| scene.positions[v as usize]);
        let boxes: Vec<_> = triangles.iter().map(|t| Bounds::of(&corners(t))).collect();
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        sort(&boxes, &mut order);
        let bounds = |size| order.chunks(size).map(|piece| Bounds::around(&boxes, piece)).collect::<Vec<_>>();
        let (groups, clusters) = (bounds(GROUP * CLUSTER as usize), bounds(CLUSTER as usize));
        let opacity = scene.opacity(triangles, parts);
        let named = |t: &u32| {
            let [a, b, c] = corners(&triangles[*t as usize]);
            let Mask { n, first } = opacity.masks[*t as usize];
            [a.extend(f32::from_bits(*t)), b.extend(f32::from_bits(n)), c.extend(f32::from_bits(first))]
        };
        let corners: Vec<_> = order.iter().map(named).collect();
        let masks = || TexelBuffer::with_data(device, "alpha masks", &opacity.words);
        Ok(Self {
            group_count: groups.len() as u32,
            cluster_count: clusters.len() as u32,
            groups: TexelBuffer::with_data(device, "cluster bounds", &groups)?,
            clusters: TexelBuffer::with_data(device, "cluster bounds", &clusters)?,
            corners: TexelBuffer::with_data(device, "capture corners", &corners)?,
            masks: (!opacity.words.is_empty()).then(masks).transpose()?,
        })
    }
}

/// An axis-aligned box, as `glsl/find_clusters` reads it.
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

    fn around(boxes: &[Self], which: &[u32]) -> Self {
        which.iter().map(|i| &boxes[*i as usize]).fold(Self::EMPTY, |b, c| b.with(c.low, c.high))
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

/// Orders the triangles of `boxes`: halves of halves, cut where groups and clusters are full.
fn sort(boxes: &[Bounds], order: &mut [u32]) {
    if order.len() <= CLUSTER as usize {
        // Neighbours in a cluster are drawn side by side: of like size, they take like time.
        order.sort_by(|a, b| boxes[*b as usize].area().total_cmp(&boxes[*a as usize].area()));
        return;
    }
    let group = GROUP * CLUSTER as usize;
    let unit = if order.len() > group { group } else { CLUSTER as usize };
    let middle = order.len().div_ceil(unit).div_ceil(2) * unit;
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

//! The order of the scene's triangles: what is drawn alike together, along a curve, in clusters with their spheres.

use super::{CLUSTER, DrawRange};
use crate::scene::{Part, Scene};
use glam::Vec3;
use std::ops::Range;

/// Clusters of a draw range, at most: llvmpipe (Mesa 22.3.6) draws nothing of 2¹⁶ indirect draws and more.
const MOST_CLUSTERS: u32 = 1 << 15;

/// Triangles in drawing order: opaque materials before masked ones, each material's along a Morton curve.
pub(super) struct Order {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) parts: Vec<Part>,
    pub(super) ranges: Vec<DrawRange>,
}

impl Order {
    pub(super) fn new(scene: &Scene) -> Self {
        let mut sources: Vec<_> = scene.parts.iter().filter(|p| p.triangle_count > 0).collect();
        sources.sort_by_key(|part| scene.is_masked(part));
        let mut order = Self { triangles: Vec::with_capacity(scene.triangles.len()), parts: vec![], ranges: vec![] };
        let bounds = bounds(&scene.positions);
        for part in sources {
            let first = order.triangles.len() as u32;
            order.triangles.extend(along_morton_curve(scene, scene.triangles_of(part), bounds));
            order.parts.push(Part { first_triangle: first, ..*part });
            order.extend_ranges(scene.is_masked(part).then_some(part.material), first);
        }
        order.ranges = order.ranges.into_iter().flat_map(pieces).collect();
        order
    }

    fn extend_ranges(&mut self, masked: Option<u32>, first: u32) {
        let end = self.triangles.len() as u32;
        match self.ranges.last_mut() {
            Some(last) if last.masked.is_none() && masked.is_none() => {
                last.triangles.end = end;
                last.clusters.end = last.clusters.start + last.triangles.len().div_ceil(CLUSTER as usize) as u32;
            }
            last => {
                let start = last.map_or(0, |range| range.clusters.end);
                let clusters = start..start + (end - first).div_ceil(CLUSTER);
                self.ranges.push(DrawRange { masked, triangles: first..end, clusters });
            }
        }
    }
}

/// A range in pieces of at most [`MOST_CLUSTERS`].
fn pieces(range: DrawRange) -> impl Iterator<Item = DrawRange> {
    let DrawRange { masked, triangles, clusters } = range;
    clusters.clone().step_by(MOST_CLUSTERS as usize).map(move |first| {
        let last = (first + MOST_CLUSTERS).min(clusters.end);
        let triangle = |cluster: u32| (triangles.start + (cluster - clusters.start) * CLUSTER).min(triangles.end);
        DrawRange { masked, triangles: triangle(first)..triangle(last), clusters: first..last }
    })
}

pub(super) fn as_usize(range: &Range<u32>) -> Range<usize> {
    range.start as usize..range.end as usize
}

pub(super) fn bounds(points: &[Vec3]) -> [Vec3; 2] {
    let whole = points.iter().fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(*p), high.max(*p)]);
    if points.is_empty() { [Vec3::ZERO; 2] } else { whole }
}

fn along_morton_curve(scene: &Scene, triangles: &[[u32; 3]], bounds: [Vec3; 2]) -> Vec<[u32; 3]> {
    // One scale for all axes: clusters come out as cubes, and a scaled world has the same order.
    let scale = 1023.0 / (bounds[1] - bounds[0]).max_element().max(f32::MIN_POSITIVE);
    let code = |triangle: &[u32; 3]| {
        let sum: Vec3 = triangle.iter().map(|v| scene.positions[*v as usize]).sum();
        let cell = ((sum / 3.0 - bounds[0]) * scale).as_uvec3();
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    let mut coded: Vec<_> = triangles.iter().map(|t| (code(t), *t)).collect();
    coded.sort_by_key(|(code, _)| *code);
    coded.into_iter().map(|(_, t)| t).collect()
}

/// Ten bits, two zeros between neighbours.
fn spread(v: u32) -> u32 {
    let v = v & 0x3ff;
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

pub(super) fn clusters(scene: &Scene, triangles: &[[u32; 3]]) -> Vec<[f32; 4]> {
    let sphere = |cluster: &[[u32; 3]]| {
        let points: Vec<Vec3> = cluster.iter().flatten().map(|v| scene.positions[*v as usize]).collect();
        let [low, high] = bounds(&points);
        let centre = (low + high) * 0.5;
        let radius = points.iter().map(|p| p.distance(centre)).fold(0.0, f32::max);
        // A grain more, for the rounding of the tests that use it.
        [centre.x, centre.y, centre.z, radius * 1.001]
    };
    triangles.chunks(CLUSTER as usize).map(sphere).collect()
}

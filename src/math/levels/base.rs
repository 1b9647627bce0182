//! The surface that levels start from: itself, or the same by fewer triangles.

use super::{Surface, corners};
use crate::math::merge::merged;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use std::borrow::Cow;
use std::time::Duration;

/// How far the surface may move, in parts of its core's radius: less than records are lifted, more than corners are rounded.
const FLATNESS: f64 = 1e-6;
/// Most cells of a merged triangle: of a few large ones with many, each would be in sight of many records.
const MOST_CELLS: f64 = 256.0;
/// What leaves more of the triangles is not worth that their cells show others.
const WORTH_IT: f64 = 0.75;

/// Triangles of the surface, whose corners are `welded`; or as many fewer as cover the same.
pub fn of<'a>(surface: &Surface<'_>, welded: &'a [[u32; 3]]) -> Cow<'a, [[u32; 3]]> {
    let may_be = |corners: &[Vec3; 3]| surface.density.is_even(corners, MOST_CELLS);
    let tolerance = FLATNESS * f64::from(surface.radius);
    let fewer = merged(surface.positions, welded, tolerance, may_be);
    if fewer.len() as f64 <= WORTH_IT * welded.len() as f64 { fewer.into() } else { welded.into() }
}

/// Finds the surface's triangles by where they are.
pub struct Around<'a> {
    surface: &'a Surface<'a>,
    boxes: Vec<Aabb>,
    tree: Bvh2,
    /// More than merged triangles are beside the surface.
    pub margin: f32,
}

impl<'a> Around<'a> {
    pub fn new(surface: &'a Surface<'a>) -> Self {
        let boxes: Vec<_> = surface.triangles.iter().map(|t| bounds(surface, t)).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::fast_build(), &mut Duration::default());
        Self { surface, boxes, tree, margin: 4.0 * FLATNESS as f32 * surface.radius }
    }

    /// Those whose boxes meet that of a triangle with these corners.
    pub fn meeting(&self, triangle: &[u32; 3]) -> Vec<u32> {
        let own = bounds(self.surface, triangle);
        let own = Aabb::new(own.min - self.margin, own.max + self.margin);
        let mut found = Vec::new();
        self.tree.aabb_traverse(own, |tree, node| {
            let leaf = &tree.nodes[node as usize];
            let range = leaf.first_index as usize..(leaf.first_index + leaf.prim_count) as usize;
            let near = tree.primitive_indices[range].iter().filter(|t| self.boxes[**t as usize].intersect_aabb(&own));
            found.extend(near);
            true
        });
        found
    }
}

fn bounds(surface: &Surface<'_>, triangle: &[u32; 3]) -> Aabb {
    Aabb::from_points(&corners(surface.positions, *triangle).map(Vec3A::from))
}

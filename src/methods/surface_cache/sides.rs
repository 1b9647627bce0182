//! Patches of the surface: groups of cells of one triangle that are close together against the distance between places, and
//! that share weights of places. Each has two sides, numbered 2·patch for the front and 2·patch + 1 for the back, as those of
//! cells are.

use crate::math::cells;
use crate::math::sequence::triangle_point;
use crate::methods::Ground;
use crate::scene::{Part, Scene};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Points that the albedo of a patch is averaged over.
const PATCH_POINTS: u32 = 16;
/// Points that the albedo of a cell is averaged over,
const CELL_POINTS: u32 = 4;
/// and cells of a triangle from which each has a single one.
const MANY_CELLS: usize = 16;

/// A point of the surface and what faces its side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) position: Vec3,
    /// Unit normal, interpolated between the vertices.
    pub(super) normal: Vec3,
    /// Unit normal of the triangle.
    pub(super) geometric: Vec3,
}

/// The sides of all patches of a scene.
pub(super) struct Sides<'a> {
    scene: &'a Scene,
    triangles: &'a [[u32; 3]],
    parts: &'a [Part],
    /// First cell of each triangle, and the end.
    first_cell: Vec<u32>,
    /// First patch of each triangle, and the end.
    first: Vec<u32>,
    /// Triangle of each patch.
    owner: Vec<u32>,
    /// Patch of each cell.
    patch: Vec<u32>,
    /// Unit geometric normal of each triangle.
    normals: Vec<Vec3>,
}

impl<'a> Sides<'a> {
    /// Patches that are about `width` wide or one cell; `first_cell` is the first cell of each triangle, in the geometry's order,
    /// and the end.
    pub(super) fn new(ground: &Ground<'a>, first_cell: Vec<u32>, width: f32) -> Self {
        let (scene, triangles) = (ground.scene, &ground.geometry.triangles[..]);
        let corners = |t: &[u32; 3]| t.map(|v| scene.positions[v as usize]);
        let cuts = |(t, ends): (&[u32; 3], &[u32])| {
            let [a, b, c] = corners(t);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            ((longest / width).ceil() as u32).clamp(1, (ends[1] - ends[0]).isqrt())
        };
        let cuts: Vec<u32> = triangles.iter().zip(first_cell.windows(2)).map(cuts).collect();
        let end = |end: &mut u32, cuts: &u32| {
            *end += cuts * cuts;
            Some(*end)
        };
        let first: Vec<u32> = [0].into_iter().chain(cuts.iter().scan(0, end)).collect();
        let owner = (0..).zip(&cuts).flat_map(|(t, n)| std::iter::repeat_n(t, (n * n) as usize)).collect();
        let of_triangle = |t: usize| {
            let count = first_cell[t + 1] - first_cell[t];
            let (r, first, n) = (count.isqrt(), first[t], cuts[t]);
            (0..count).map(move |cell| first + cells::at(n, cells::centre(r, cell)))
        };
        let patch = (0..triangles.len()).into_par_iter().flat_map_iter(of_triangle).collect();
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| scene.positions[v as usize].as_dvec3());
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        };
        let normals = triangles.par_iter().map(normal).collect();
        Self { scene, triangles, parts: &ground.geometry.parts, first_cell, first, owner, patch, normals }
    }

    pub(super) fn count(&self) -> usize {
        2 * self.owner.len()
    }

    /// Sides of cells.
    pub(super) fn cell_side_count(&self) -> usize {
        2 * self.patch.len()
    }

    /// The side of the patch that the side of a cell belongs to.
    pub(super) fn of_cell(&self, cell_side: u32) -> u32 {
        2 * self.patch[cell_side as usize / 2] + cell_side % 2
    }

    /// The cells of each triangle.
    pub(super) fn cells_of_triangles(&self) -> impl IndexedParallelIterator<Item = (u32, std::ops::Range<u32>)> {
        (0..self.triangles.len() as u32)
            .into_par_iter()
            .map(|t| (t, self.first_cell[t as usize]..self.first_cell[t as usize + 1]))
    }

    pub(super) fn triangle(&self, side: u32) -> u32 {
        self.owner[side as usize / 2]
    }

    /// The plane of a triangle: a point of it and its unit normal.
    pub(super) fn plane(&self, triangle: u32) -> (Vec3, Vec3) {
        (self.corners(triangle)[0], self.normals[triangle as usize])
    }

    /// Whether nothing of the side reflects.
    pub(super) fn is_black(&self, side: u32) -> bool {
        let material = &self.scene.materials[self.material(self.triangle(side)) as usize];
        material.base_color.truncate() == Vec3::ZERO
    }

    /// The middle of the patch.
    pub(super) fn point(&self, side: u32) -> Point {
        let triangle = self.triangle(side);
        let [begin, end] = [0, 1].map(|i| self.first[triangle as usize + i]);
        let [u, v] = cells::centre((end - begin).isqrt(), side / 2 - begin).to_array();
        let [a, b, c] = self.corners(triangle);
        let towards = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
        let geometric = self.normals[triangle as usize] * towards;
        let [na, nb, nc] = self.triangles[triangle as usize].map(|i| self.scene.normals[i as usize]);
        let smooth = (na * (1.0 - u - v) + nb * u + nc * v).try_normalize().unwrap_or(geometric);
        // Shading normals may point to the other side of their triangle.
        let normal = if smooth.dot(geometric) < 0.0 { -smooth } else { smooth };
        Point { position: a + (b - a) * u + (c - a) * v, normal, geometric }
    }

    /// The middle of a cell of a triangle.
    pub(super) fn cell_position(&self, triangle: u32, cell: u32) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        let [u, v] = self.middle(triangle, cell).to_array();
        a + (b - a) * u + (c - a) * v
    }

    /// Albedo of both sides of the patch, averaged over its points that the surface has; at most 1.
    pub(super) fn albedo(&self, side: u32) -> Vec3 {
        let (triangle, patch) = (self.triangle(side), side / 2);
        let range = self.first[triangle as usize]..self.first[triangle as usize + 1];
        self.mean_albedo(triangle, (range.len() as u32, patch - range.start), PATCH_POINTS)
    }

    /// The same of a cell of a triangle.
    pub(super) fn cell_albedo(&self, triangle: u32, cell: u32) -> Vec3 {
        let range = self.first_cell[triangle as usize]..self.first_cell[triangle as usize + 1];
        let points = if range.len() >= MANY_CELLS { 1 } else { CELL_POINTS };
        self.mean_albedo(triangle, (range.len() as u32, cell - range.start), points)
    }

    /// Over `points` points of one of so many equal pieces of a triangle.
    fn mean_albedo(&self, triangle: u32, (pieces, piece): (u32, u32), points: u32) -> Vec3 {
        let (vertices, material, cuts) = (self.triangles[triangle as usize], self.material(triangle), pieces.isqrt());
        let points = if self.scene.albedo_varies(material) { points } else { 1 };
        let at = |i: u32| cells::point(cuts, piece, triangle_point(i).as_dvec2()).as_vec2();
        let albedo = |i: u32| self.scene.albedo_at(material, vertices, at(i));
        let (sum, present) = (0..points).filter_map(albedo).fold((Vec3::ZERO, 0.0), |(s, n), a| (s + a, n + 1.0));
        sum / f32::max(present, 1.0)
    }

    fn material(&self, triangle: u32) -> u32 {
        let part = self.parts.partition_point(|part| part.first_triangle <= triangle).saturating_sub(1);
        self.parts[part].material
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.scene.positions[v as usize])
    }

    fn middle(&self, triangle: u32, cell: u32) -> Vec2 {
        let [first, end] = [0, 1].map(|i| self.first_cell[triangle as usize + i]);
        cells::centre((end - first).isqrt(), cell - first)
    }
}

//! Cells for interpolation without jumps between levels.
//!
//! Beside a finer cell a coarse one must take part of the finer one's corners in, or light jumps where an object passes from one to
//! the other (Tatarchuk and Oat 2005: keep using the samples of subdivided neighbours). Here a sample that first occurs at level l
//! works in all cells of level l around it, whether or not these were cut: hat functions of the level's width, as in hierarchical
//! bases (Yserentant 1986). Cells that are cut for that alone have corners without samples; such a [`Point`] takes its value from the
//! corners of the next coarser level, which is what interpolation gives there anyway. So a point is interpolated in the finest
//! cell around it, by its eight corners, and the result is continuous.

use super::Volume;
use super::lattice::{Lattice, octants};
use glam::{DVec3, UVec3};
use std::collections::{HashMap, HashSet};

/// A corner of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its place in steps of the finest level.
    pub corner: UVec3,
    /// Samples and weights that make its value: itself alone, if it is a sample.
    pub mix: Vec<(u32, f64)>,
    /// Its number, if it is a sample.
    pub sample: Option<u32>,
}

/// A cell of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Number of the first of its eight children, which follow each other; 0 for a cell that is not cut.
    pub first_child: u32,
    /// Points at its corners.
    pub corners: [u32; 8],
}

/// The cells of level 0 first, row by row; then children.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Cells.
    pub nodes: Vec<Node>,
    /// Their corners.
    pub points: Vec<Point>,
}

struct Builder<'a> {
    lattice: &'a Lattice,
    samples: HashMap<UVec3, u32>,
    cut: HashSet<(u32, UVec3)>,
    points: HashMap<UVec3, u32>,
    tree: Tree,
}

/// The sample of each corner that has one.
pub fn corners_of(lattice: &Lattice) -> HashMap<UVec3, u32> {
    let of_leaf = |leaf: &super::Cell| {
        let corner = |octant| lattice.corner(leaf.level, leaf.at + octant);
        octants().map(corner).into_iter().zip(leaf.corners).collect::<Vec<_>>()
    };
    lattice.leaves.iter().flat_map(of_leaf).collect()
}

impl Tree {
    /// The tree of a volume.
    pub fn new(volume: &Volume) -> Self {
        let lattice = &volume.lattice;
        let samples = corners_of(lattice);
        let mut cut = HashSet::new();
        for corner in samples.keys() {
            let level = lattice.level_of(*corner);
            for at in lattice.around(level, *corner) {
                // All cells above one that is there are cut.
                cut.extend((0..level).map(|up| (up, at >> (level - up))));
            }
        }
        let mut builder = Builder { lattice, samples, cut, points: HashMap::new(), tree: Self::default() };
        builder.build();
        builder.tree
    }

    /// The number of the finest cell around a place in the box, and where in it: from 0 to 1 along each axis; and the cell's level.
    pub fn find(&self, lattice: &Lattice, point: DVec3) -> (usize, DVec3, u32) {
        let cells = lattice.divisions.as_dvec3();
        let at = ((point - lattice.low) / (lattice.high - lattice.low) * cells).clamp(DVec3::ZERO, cells);
        let whole = at.floor().min(cells - 1.0);
        let mut t = at - whole;
        let root = whole.as_uvec3();
        let mut number = (root.x + lattice.divisions.x * (root.y + lattice.divisions.y * root.z)) as usize;
        let mut level = 0;
        while self.nodes[number].first_child != 0 {
            let upper = t.cmpge(DVec3::splat(0.5));
            t = 2.0 * t - DVec3::select(upper, DVec3::ONE, DVec3::ZERO);
            number = (self.nodes[number].first_child + upper.bitmask()) as usize;
            level += 1;
        }
        (number, t, level)
    }
}

impl Builder<'_> {
    fn build(&mut self) {
        for at in self.lattice.cells_of(0) {
            let node = self.node(0, at);
            self.tree.nodes.push(node);
        }
        let mut open: Vec<(usize, u32, UVec3)> =
            self.lattice.cells_of(0).into_iter().enumerate().map(|(i, at)| (i, 0, at)).collect();
        while let Some((number, level, at)) = open.pop() {
            if !self.cut.contains(&(level, at)) {
                continue;
            }
            let first = self.tree.nodes.len();
            self.tree.nodes[number].first_child = first as u32;
            for (i, octant) in octants().into_iter().enumerate() {
                let child = at * 2 + octant;
                let node = self.node(level + 1, child);
                self.tree.nodes.push(node);
                open.push((first + i, level + 1, child));
            }
        }
    }

    fn node(&mut self, level: u32, at: UVec3) -> Node {
        let corners = octants().map(|octant| self.lattice.corner(level, at + octant));
        Node { first_child: 0, corners: corners.map(|corner| self.point(corner)) }
    }

    fn point(&mut self, corner: UVec3) -> u32 {
        if let Some(known) = self.points.get(&corner) {
            return *known;
        }
        let point = match self.samples.get(&corner) {
            Some(sample) => Point { corner, mix: vec![(*sample, 1.0)], sample: Some(*sample) },
            None => self.virtual_point(corner),
        };
        let number = self.tree.points.len() as u32;
        self.tree.points.push(point);
        self.points.insert(corner, number);
        number
    }

    /// By a cell of the level above the one at which the corner first occurs. Any of them that touch it gives the same.
    fn virtual_point(&mut self, corner: UVec3) -> Point {
        let level = self.lattice.level_of(corner) - 1;
        let shift = self.lattice.levels - level;
        let at = (corner >> shift).min((self.lattice.divisions << level) - 1);
        let t = (corner - (at << shift)).as_dvec3() / f64::from(1_u32 << shift);
        let corners = octants().map(|octant| (at + octant) << shift).map(|corner| self.point(corner));
        let mut mix: Vec<(u32, f64)> = Vec::new();
        for (weight, point) in super::cell::trilinear(t).into_iter().zip(corners).filter(|(weight, _)| *weight > 0.0) {
            for (sample, share) in &self.tree.points[point as usize].mix {
                match mix.iter_mut().find(|(known, _)| known == sample) {
                    Some((_, sum)) => *sum += weight * share,
                    None => mix.push((*sample, weight * share)),
                }
            }
        }
        Point { corner, mix, sample: None }
    }
}

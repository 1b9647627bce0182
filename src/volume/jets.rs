//! Values and derivatives at the corners of a tree's cells, for the cubic interpolation.
//!
//! A corner without a sample gets them from the cell above its own: the cubic of a part of a cell is then the cubic of the whole.
//! Cells on both sides of a face have the same cubic on it, but not the same slopes across its edges, so that each cell has its own.

use super::cell::{CubicWeight, cubic, cubic_slopes};
use super::lattice::{Lattice, octants};
use super::tree::Tree;
use super::{Sample, Volume};
use glam::{DVec3, UVec3, Vec3};

/// Value and derivatives along x, y and z of each coefficient, the colour channels side by side.
type Jet = Vec<[DVec3; 4]>;

/// The samples' first, then those of other corners.
pub struct Jets {
    all: Vec<Jet>,
    /// Of each cell of the tree the jets at its corners.
    of_nodes: Vec<[u32; 8]>,
}

impl Jets {
    /// Those of all cells of the volume's tree, whose samples have gradients.
    pub fn new(volume: &Volume, tree: &Tree) -> Self {
        let all = volume.samples.iter().map(jet_of).collect();
        let mut jets = Self { all, of_nodes: vec![[0; 8]; tree.nodes.len()] };
        let roots = volume.lattice.divisions.element_product();
        let mut open: Vec<(usize, u32)> = (0..roots as usize).map(|root| (root, 0)).collect();
        for (root, _) in &open {
            let corners = tree.nodes[*root].corners;
            let sample = |point: u32| tree.points[point as usize].sample;
            jets.of_nodes[*root] = corners.map(|point| sample(point).expect("the box's own cells have samples"));
        }
        while let Some((number, level)) = open.pop() {
            let first = tree.nodes[number].first_child as usize;
            if first != 0 {
                jets.descend(tree, number, volume.lattice.size(level));
                open.extend((first..first + 8).map(|child| (child, level + 1)));
            }
        }
        jets
    }

    /// Those of a cell's children.
    fn descend(&mut self, tree: &Tree, number: usize, size: DVec3) {
        let mut known = [None; 27];
        let node = tree.nodes[number];
        for (i, octant) in octants().into_iter().enumerate() {
            let child = node.first_child as usize + i;
            let corners = tree.nodes[child].corners;
            for (place, point) in octants().into_iter().zip(corners).map(|(corner, point)| (octant + corner, point)) {
                let at = (place.x + 3 * (place.y + 3 * place.z)) as usize;
                let jet = match (tree.points[point as usize].sample, known[at]) {
                    (Some(sample), _) => sample,
                    (None, Some(jet)) => jet,
                    (None, None) => self.within(number, place, size),
                };
                known[at] = Some(jet);
                let corner = (place - octant).dot(UVec3::new(1, 2, 4)) as usize;
                self.of_nodes[child][corner] = jet;
            }
        }
    }

    /// At a place of a cell, in halves of its sides.
    fn within(&mut self, number: usize, place: UVec3, size: DVec3) -> u32 {
        if place.cmpne(UVec3::ONE).all() {
            return self.of_nodes[number][(place / 2).dot(UVec3::new(1, 2, 4)) as usize];
        }
        let t = place.as_dvec3() / 2.0;
        let value = self.sum(number, &cubic(t, size));
        let slopes = cubic_slopes(t, size).map(|weights| self.sum(number, &weights));
        self.all.push((0..value.len()).map(|c| [value[c], slopes[0][c], slopes[1][c], slopes[2][c]]).collect());
        self.all.len() as u32 - 1
    }

    fn sum(&self, number: usize, weights: &[CubicWeight; 8]) -> Vec<DVec3> {
        let jets = self.of_nodes[number].map(|jet| &self.all[jet as usize]);
        let mut sums = vec![DVec3::ZERO; jets[0].len()];
        for (jet, weight) in jets.iter().zip(weights) {
            for (sum, [value, x, y, z]) in sums.iter_mut().zip(*jet) {
                let slope = weight.gradient;
                *sum += weight.value * *value + slope.x * *x + slope.y * *y + slope.z * *z;
            }
        }
        sums
    }

    /// The coefficients at a point of the box.
    pub fn read(&self, lattice: &Lattice, tree: &Tree, point: DVec3) -> Vec<DVec3> {
        let (node, t, level) = tree.find(lattice, point);
        self.sum(node, &cubic(t, lattice.size(level)))
    }
}

fn jet_of(sample: &Sample) -> Jet {
    let jet = |(value, slopes): (&Vec3, &[Vec3; 3])| {
        let [x, y, z] = slopes.map(|slope| slope.as_dvec3());
        [value.as_dvec3(), x, y, z]
    };
    sample.coefficients.iter().zip(&sample.gradients).map(jet).collect()
}

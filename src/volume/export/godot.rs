//! Godot's light probes: `LightmapGIData`'s probe data, in the places of the `LightmapGI` node.
//!
//! Godot interpolates in tetrahedra and finds them by a tree of planes. Each cell of the grid is six of them: where its coordinates are
//! in one of their six orders (Freudenthal 1942), which three planes tell.

use super::{Grid, Light, measures};
use glam::{DVec3, UVec3};
use serde_json::{Value, json};

/// A leaf without a tetrahedron.
const EMPTY: i32 = i32::MIN;

/// Points, coefficients, tetrahedra and the tree.
pub fn probes(grid: &Grid) -> Value {
    let (tetrahedra, nodes) = tree(grid);
    let light = |light: &Light| measures::godot(light).map(|c| c.as_vec3().to_array());
    let high = grid.place(grid.lights.len() - 1);
    json!({
        "engine": "godot",
        "about": "LightmapGIData.call(\"_set_probe_data\", {bounds, points, tetrahedra, bsp, sh, interior}); bsp holds six 32-bit numbers \
                  a node: normal and distance of a plane as bits of floats, the node over it, the node under it",
        "bounds": {"position": grid.low.to_array(), "size": (high - grid.low).to_array()},
        "points": (0..grid.lights.len()).map(|i| grid.place(i).to_array()).collect::<Vec<_>>(),
        "sh": grid.lights.iter().map(light).collect::<Vec<_>>(),
        "tetrahedra": tetrahedra.concat(),
        "bsp": nodes.iter().flat_map(|node| node.numbers()).collect::<Vec<_>>(),
        "interior": false,
    })
}

/// A plane; n·p − d > 0 is over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// n.
    pub normal: DVec3,
    /// d.
    pub distance: f64,
    /// Node over the plane; below 0 a leaf: the tetrahedron −(i + 1), or none.
    pub over: i32,
    /// Node under it.
    pub under: i32,
}

impl Node {
    fn numbers(&self) -> [i32; 6] {
        let bits = |v: f64| (v as f32).to_bits() as i32;
        let [x, y, z] = self.normal.to_array().map(bits);
        [x, y, z, bits(self.distance), self.over, self.under]
    }
}

/// Tetrahedra by their points, and the tree, whose first node is the root.
pub fn tree(grid: &Grid) -> (Vec<[u32; 4]>, Vec<Node>) {
    let mut builder = Builder { grid, tetrahedra: Vec::new(), nodes: Vec::new() };
    builder.cells(UVec3::ZERO, grid.counts - 1);
    (builder.tetrahedra, builder.nodes)
}

struct Builder<'a> {
    grid: &'a Grid,
    tetrahedra: Vec<[u32; 4]>,
    nodes: Vec<Node>,
}

impl Builder<'_> {
    /// The tree of the cells from `low` to before `high`.
    fn cells(&mut self, low: UVec3, high: UVec3) -> i32 {
        let size = high - low;
        let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        if size[axis] == 1 {
            return self.cell(low);
        }
        let mut middle = [low, high];
        let cut = low[axis] + size[axis] / 2;
        (middle[0][axis], middle[1][axis]) = (cut, cut);
        let normal = DVec3::AXES[axis];
        let distance = (self.grid.low + low.as_dvec3().with_axis(axis, f64::from(cut)) * self.grid.spacing)[axis];
        self.split(normal, distance, |b| b.cells(middle[0], high), |b| b.cells(low, middle[1]))
    }

    fn split(
        &mut self,
        normal: DVec3,
        distance: f64,
        over: impl FnOnce(&mut Self) -> i32,
        under: impl FnOnce(&mut Self) -> i32,
    ) -> i32 {
        let number = self.nodes.len();
        self.nodes.push(Node { normal, distance, over: EMPTY, under: EMPTY });
        let (over, under) = (over(self), under(self));
        (self.nodes[number].over, self.nodes[number].under) = (over, under);
        number as i32
    }

    /// Six tetrahedra: by which of x and y is larger, then z beside the larger one, then beside the smaller one.
    fn cell(&mut self, at: UVec3) -> i32 {
        self.order(at, 0, 1, |b| b.beside(at, [0, 1]), |b| b.beside(at, [1, 0]))
    }

    fn beside(&mut self, at: UVec3, [first, second]: [usize; 2]) -> i32 {
        let last = move |b: &mut Self| {
            b.order(at, 2, second, |b| b.leaf(at, [first, 2, second]), |b| b.leaf(at, [first, second, 2]))
        };
        self.order(at, 2, first, |b| b.leaf(at, [2, first, second]), last)
    }

    /// Over: the place along `a` in the cell is larger than along `b`.
    fn order(
        &mut self,
        at: UVec3,
        a: usize,
        b: usize,
        over: impl FnOnce(&mut Self) -> i32,
        under: impl FnOnce(&mut Self) -> i32,
    ) -> i32 {
        let spacing = self.grid.spacing;
        let normal = DVec3::AXES[a] / spacing[a] - DVec3::AXES[b] / spacing[b];
        let length = normal.length();
        let corner = self.grid.low + at.as_dvec3() * spacing;
        self.split(normal / length, normal.dot(corner) / length, over, under)
    }

    /// The tetrahedron where coordinates fall in the order of `axes`.
    fn leaf(&mut self, at: UVec3, axes: [usize; 3]) -> i32 {
        let n = self.grid.counts;
        let number = |p: UVec3| p.x + n.x * (p.y + n.y * p.z);
        let mut corner = at;
        let mut points = [number(at); 4];
        for (axis, point) in axes.into_iter().zip(&mut points[1..]) {
            corner[axis] += 1;
            *point = number(corner);
        }
        self.tetrahedra.push(points);
        -(self.tetrahedra.len() as i32)
    }
}

/// A coordinate replaced.
trait WithAxis {
    fn with_axis(self, axis: usize, value: f64) -> Self;
}

impl WithAxis for DVec3 {
    fn with_axis(mut self, axis: usize, value: f64) -> Self {
        self[axis] = value;
        self
    }
}

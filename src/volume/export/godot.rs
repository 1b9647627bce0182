//! Godot's light probes: a `LightmapGIData` resource, in the coordinates of the `LightmapGI` node that gets it.
//!
//! Godot interpolates in tetrahedra and finds them by a tree of planes. Each cell of the grid is cut into six of them: a point's
//! coordinates in the cell are in one of six orders (Freudenthal 1942), and three planes tell which.

use super::{Grid, Light, measures};
use glam::{DVec3, UVec3};
use std::fmt::Write;

/// A child without a tetrahedron.
const EMPTY: i32 = i32::MIN;

/// The resource as Godot's text format (`.tres`): probe points, coefficients, tetrahedra and the tree.
pub fn resource(grid: &Grid) -> String {
    let (tetrahedra, nodes) = tree(grid);
    let size = grid.place(grid.lights.len() - 1) - grid.low;
    let points = (0..grid.lights.len()).flat_map(|i| grid.place(i).as_vec3().to_array());
    let colours = |light: &Light| measures::godot(light).map(|c| c.as_vec3().extend(1.0).to_array());
    let mut text = String::from("[gd_resource type=\"LightmapGIData\" format=3]\n\n[resource]\nprobe_data = {\n");
    let bounds = grid.low.to_array().into_iter().chain(size.to_array());
    for (key, kind, numbers) in [
        ("bounds", "AABB", list(bounds)),
        ("points", "PackedVector3Array", list(points)),
        ("tetrahedra", "PackedInt32Array", list(tetrahedra.iter().flatten())),
        ("bsp", "PackedInt32Array", list(nodes.iter().flat_map(Node::numbers))),
        ("sh", "PackedColorArray", list(grid.lights.iter().flat_map(colours).flatten())),
    ] {
        text.extend(["\"", key, "\": ", kind, "(", &numbers, "),\n"]);
    }
    text.push_str("\"interior\": false,\n\"baked_exposure\": 1.0\n}\n");
    text
}

/// Numbers with commas between them.
fn list(numbers: impl Iterator<Item: std::fmt::Display>) -> String {
    let mut text = String::new();
    for (i, number) in numbers.enumerate() {
        let comma = if i > 0 { ", " } else { "" };
        // A string takes everything.
        let _ = write!(text, "{comma}{number}");
    }
    text
}

/// A plane of the tree: a point p with n·p > d is over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The unit normal n.
    pub normal: DVec3,
    /// The distance d.
    pub distance: f64,
    /// The child over the plane: the number of a node, or −(i + 1) for tetrahedron i.
    pub over: i32,
    /// The child under the plane.
    pub under: i32,
}

impl Node {
    /// As Godot stores it: normal and distance as bits of floats, then the children.
    fn numbers(&self) -> [i32; 6] {
        let bits = |v: f64| (v as f32).to_bits() as i32;
        let [x, y, z] = self.normal.to_array().map(bits);
        [x, y, z, bits(self.distance), self.over, self.under]
    }
}

/// Tetrahedra, each by its four points, and the tree; its first node is the root.
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

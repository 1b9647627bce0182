//! Nodes of the tree: clusters first, then what holds them, up to the root.

use super::sort::{Item, sorted};
use super::{Bounds, CHILDREN};
use crate::math::levels::{Bound, Cluster};
use glam::{Vec3, Vec4};

/// A node as the device reads it; `w` of the corners is told there.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Around what it draws; w, as bits: [`Self::children`], and its [`Middle`]. Nothing of a cluster.
    bounds: Bounds,
    /// Around all that a cluster stands for, and w of the lowest corner: its error. Of what holds clusters, around all that is
    /// replaced with them, and w: the least error of theirs, the largest of what replaces them.
    errors: Bounds,
}

impl Node {
    /// Texels of a node, without errors if there are none.
    pub fn texels(&self, has_levels: bool) -> impl Iterator<Item = Vec4> {
        let Self { bounds, errors } = *self;
        [bounds.low, bounds.high, errors.low, errors.high].into_iter().take(if has_levels { 4 } else { 2 })
    }

    /// With the children from `first` on.
    fn holding(mut self, first: u32, count: usize, middle: Middle) -> Self {
        self.bounds.low.w = f32::from_bits(first * CHILDREN as u32 + count as u32 - 1);
        self.bounds.high.w = f32::from_bits(middle.packed);
        self
    }

    /// Eight times the first child, and how many more.
    pub fn children(&self) -> u32 {
        self.bounds.low.w.to_bits()
    }

    fn middle(&self) -> Middle {
        Middle { packed: self.bounds.high.w.to_bits() }
    }

    fn around(nodes: &[Self]) -> Self {
        let join = |with: fn(&Self) -> Bounds| Bounds::around(nodes.iter().map(with));
        Self { bounds: join(|n| n.bounds), errors: join(|n| n.errors) }
    }
}

/// A point of a node's box for errors, and how far from it the boxes of what it holds are at most. An eye is no further from any
/// of these than from the point, and that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Middle {
    /// Three times eight bits: place in the box; seven: the distance, in parts of the diagonal (`farthest_from` of the shader).
    packed: u32,
}

impl Middle {
    const PLACES: f32 = 255.0;
    /// No exponent of a float is all ones then.
    const PARTS: f32 = 126.0;

    /// In `whole`, near to `point`; `away`: how far from a point the boxes are.
    fn new(whole: Bounds, point: Vec3, away: impl Fn(Vec3) -> f32) -> Self {
        let share = (point - whole.low.truncate()) / whole.size().max(Vec3::splat(f32::MIN_POSITIVE));
        let [x, y, z] =
            (share.clamp(Vec3::ZERO, Vec3::ONE) * Self::PLACES).round().to_array().map(|place| place as u32);
        let place = Self { packed: x | y << 8 | z << 16 };
        // A grain more, for the rounding of distances.
        let parts = away(place.point(whole)) * 1.0001 / whole.size().length().max(f32::MIN_POSITIVE) * Self::PARTS;
        Self { packed: place.packed | (parts.ceil().min(Self::PARTS) as u32) << 24 }
    }

    /// Of boxes in `whole`: the middle of the smallest box that meets all of them. Where there are none nobody asks.
    fn of(whole: Bounds, boxes: &[Bound]) -> Self {
        if boxes.is_empty() {
            return Self { packed: 0 };
        }
        let low = boxes.iter().fold(Vec3::INFINITY, |least, b| least.min(b.high));
        let high = boxes.iter().fold(Vec3::NEG_INFINITY, |most, b| most.max(b.low));
        Self::new(whole, 0.5 * (low + high), |point| boxes.iter().map(|b| b.distance(point)).fold(0.0, f32::max))
    }

    /// Of what `nodes` have in theirs.
    fn around(whole: Bounds, nodes: &[Node]) -> Self {
        let of = |node: &Node| (node.middle().point(node.errors), node.middle().distance(node.errors));
        let points: Vec<_> = nodes.iter().map(|n| of(n).0).collect();
        let point = Bounds::of(&points);
        Self::new(whole, (0.5 * (point.low + point.high)).truncate(), |point| {
            nodes.iter().map(of).map(|(middle, distance)| middle.distance(point) + distance).fold(0.0, f32::max)
        })
    }

    fn point(self, whole: Bounds) -> Vec3 {
        let place = [0, 8, 16].map(|bits| (self.packed >> bits & 255) as f32);
        whole.low.truncate() + whole.size() * (Vec3::from(place) / Self::PLACES)
    }

    fn distance(self, whole: Bounds) -> f32 {
        whole.size().length() * ((self.packed >> 24) as f32 / Self::PARTS)
    }
}

/// Clusters with their boxes, of a group: what replaces them replaces all.
pub struct Group {
    /// Up to eight clusters.
    pub clusters: Vec<(Cluster, Bounds)>,
    coarser: Bound,
}

impl Group {
    /// Groups of clusters as they come.
    pub fn in_order(clusters: &[(Cluster, Bounds)]) -> Vec<Self> {
        Self::pieces(clusters).map(Self::new).collect()
    }

    /// Those come together that a view visits where an error of `allowed` is at distance 1.
    pub fn by_visits(clusters: &[(Cluster, Bounds)], allowed: f32) -> Vec<Self> {
        let pieces: Vec<_> = Self::pieces(clusters).collect();
        let item = |piece: &&[(Cluster, Bounds)]| {
            let bounds = Bounds::around(piece.iter().map(|c| c.1));
            Item { bounds, reach: Some(piece[0].0.coarser.error / allowed) }
        };
        let items: Vec<_> = pieces.iter().map(item).collect();
        sorted(&items).into_iter().map(|i| Self::new(pieces[i as usize])).collect()
    }

    fn pieces(clusters: &[(Cluster, Bounds)]) -> impl Iterator<Item = &[(Cluster, Bounds)]> {
        clusters.chunk_by(|a, b| a.0.coarser == b.0.coarser).flat_map(|c| c.chunks(CHILDREN))
    }

    fn new(clusters: &[(Cluster, Bounds)]) -> Self {
        Self { clusters: clusters.to_vec(), coarser: clusters[0].0.coarser }
    }

    fn node(&self, first: u32) -> Node {
        let mut errors = Bounds::from(self.coarser);
        errors.low.w = self.clusters.iter().fold(f32::INFINITY, |least, c| least.min(c.0.own.error));
        errors.high.w = self.coarser.error;
        let bounds = Bounds::around(self.clusters.iter().map(|c| c.1));
        // What is exact suffices at any distance.
        let own: Vec<_> = self.clusters.iter().map(|c| c.0.own).filter(|own| own.error > 0.0).collect();
        let middle = Middle::of(errors, &own);
        Node { bounds, errors }.holding(first, self.clusters.len(), middle)
    }
}

/// All nodes of a tree: clusters, their groups, and what holds these, eight by eight. The last one is the root.
pub fn nodes_of(groups: &[Group]) -> Vec<Node> {
    let cluster = |(cluster, bounds): &(Cluster, Bounds)| {
        let mut errors = Bounds::from(cluster.own);
        errors.low.w = cluster.own.error;
        Node { bounds: *bounds, errors }
    };
    let mut nodes: Vec<Node> = groups.iter().flat_map(|g| &g.clusters).map(cluster).collect();
    let mut first = 0;
    let mut level: Vec<Node> = Vec::new();
    for group in groups {
        level.push(group.node(first));
        first += group.clusters.len() as u32;
    }
    while level.len() > 1 {
        let mut first = nodes.len() as u32;
        nodes.extend(&level);
        let holder = |children: &[Node]| {
            let node = Node::around(children);
            let node = node.holding(first, children.len(), Middle::around(node.errors, children));
            first += children.len() as u32;
            node
        };
        level = level.chunks(CHILDREN).map(holder).collect();
    }
    nodes.extend(level);
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    /// Farthest an eye may be from a box of those that `node` holds, as the shader reckons.
    fn farthest(node: &Node, eye: Vec3) -> f32 {
        1.0001 * (node.middle().point(node.errors).distance(eye) + node.middle().distance(node.errors))
    }

    fn bound(a: Vec3, b: Vec3) -> Bound {
        Bound { low: a.min(b), high: a.max(b), error: 1.0 }
    }

    /// Nodes over nodes over boxes of any shape and place: no box is further from an eye than their nodes say.
    #[test]
    fn no_box_is_further_than_its_node_says() {
        // Points of the sequence of Roberts 2018, in a cube around the origin.
        let mut number = 0.0_f64;
        let mut point = |scale: f32| {
            number += 1.0;
            ((number * dvec3(0.819_172_5, 0.671_043_6, 0.549_700_5)).fract() - 0.5).as_vec3() * scale
        };
        for turn in 0..200 {
            let size = [1e-3, 1.0, 1e4][turn % 3];
            let boxes = [0; 8].map(|_| [0; 5].map(|_| bound(point(size), point(size))));
            let groups = boxes.map(|of_group| {
                let errors = Bounds::around(of_group.map(Bounds::from));
                Node { bounds: errors, errors }.holding(0, 5, Middle::of(errors, &of_group))
            });
            let all = Node::around(&groups);
            let all = all.holding(0, 8, Middle::around(all.errors, &groups));
            for eye in [0.1, 1.0, 30.0].map(|near| point(near * size)) {
                for (group, boxes) in groups.iter().zip(&boxes) {
                    let exact = boxes.iter().map(|b| b.distance(eye)).fold(0.0, f32::max);
                    let [of_group, of_all] = [group, &all].map(|node| farthest(node, eye));
                    assert!(exact <= of_group && exact <= of_all, "{exact} {of_group} {of_all}");
                }
            }
        }
    }

    /// Boxes that have a point in common: an eye is no further from any of them than from it.
    #[test]
    fn overlapping_boxes_are_no_further_than_what_they_share() {
        let boxes = [[0.0, 6.0], [4.0, 10.0], [1.0, 5.0]].map(|[a, b]| bound(Vec3::splat(a), Vec3::splat(b)));
        let errors = Bounds::around(boxes.map(Bounds::from));
        let node = Node { bounds: errors, errors }.holding(3, 3, Middle::of(errors, &boxes));
        assert_eq!(node.children(), 8 * 3 + 2);
        assert!(farthest(&node, Vec3::splat(4.5)) < 0.1, "{}", farthest(&node, Vec3::splat(4.5)));
    }
}

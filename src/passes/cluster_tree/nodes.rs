//! Nodes of the tree: clusters first, then what holds them, up to the root.

use super::sort::{Item, sorted};
use super::{Bounds, CHILDREN};
use crate::math::levels::{Bound, Cluster};
use glam::Vec4;

/// A node as the device reads it; `w` of the corners is told there.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Around what it draws; w, as bits: first child, and how many more there are. Nothing of a cluster.
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

    fn with_children(mut self, first: u32, more: u32) -> Self {
        self.bounds.low.w = f32::from_bits(first);
        self.bounds.high.w = f32::from_bits(more);
        self
    }

    /// Eight times the first child, and how many more.
    pub fn children(&self) -> u32 {
        self.bounds.low.w.to_bits() * CHILDREN as u32 + self.bounds.high.w.to_bits()
    }

    fn around(nodes: &[Self]) -> Self {
        let join = |with: fn(&Self) -> Bounds| Bounds::around(nodes.iter().map(with));
        Self { bounds: join(|n| n.bounds), errors: join(|n| n.errors) }
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
        Node { bounds, errors }.with_children(first, self.clusters.len() as u32 - 1)
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
            let node = Node::around(children).with_children(first, children.len() as u32 - 1);
            first += children.len() as u32;
            node
        };
        level = level.chunks(CHILDREN).map(holder).collect();
    }
    nodes.extend(level);
    nodes
}

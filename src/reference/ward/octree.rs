//! Ward's octree (1988): each record stands in a node about as large as its zone of influence.

use glam::DVec3;

const NONE: u32 = u32::MAX;
/// Zones smaller than the scene / 2^DEPTH share the deepest nodes.
const DEPTH: u32 = 24;

/// Indices of records, found by the places that they may influence.
pub struct Octree {
    center: DVec3,
    half: f64,
    nodes: Vec<Node>,
}

struct Node {
    children: [u32; 8],
    records: Vec<u32>,
}

impl Node {
    fn new() -> Self {
        Self { children: [NONE; 8], records: vec![] }
    }
}

impl Octree {
    /// Covers the cube of half side `half` around `center`.
    pub fn new(center: DVec3, half: f64) -> Self {
        Self { center, half, nodes: vec![Node::new()] }
    }

    /// Adds a record whose zone is a sphere: to the smallest node around its centre with half side ≥ radius.
    pub fn insert(&mut self, record: u32, position: DVec3, radius: f64) {
        let (mut node, mut center, mut half) = (0, self.center, self.half);
        for _ in 0..DEPTH {
            if 0.5 * half < radius {
                break;
            }
            half *= 0.5;
            let octant = position.cmpge(center).bitmask();
            center += offset(octant) * half;
            let child = self.nodes[node].children[octant as usize];
            node = if child == NONE {
                self.nodes.push(Node::new());
                let new = self.nodes.len() as u32 - 1;
                self.nodes[node].children[octant as usize] = new;
                new as usize
            } else {
                child as usize
            };
        }
        self.nodes[node].records.push(record);
    }

    /// Calls `visit` with every record whose zone may contain `position`, in an order that depends on the insertions alone.
    pub fn around(&self, position: DVec3, mut visit: impl FnMut(u32)) {
        let mut stack = vec![(0u32, self.center, self.half)];
        while let Some((node, center, half)) = stack.pop() {
            let node = &self.nodes[node as usize];
            node.records.iter().for_each(|&record| visit(record));
            let half = 0.5 * half;
            for (octant, &child) in node.children.iter().enumerate().filter(|(_, child)| **child != NONE) {
                let center = center + offset(octant as u32) * half;
                // A zone reaches at most half a side out of its node.
                if (position - center).abs().max_element() <= 2.0 * half {
                    stack.push((child, center, half));
                }
            }
        }
    }
}

fn offset(octant: u32) -> DVec3 {
    let sign = |bit: u32| if octant >> bit & 1 == 1 { 1.0 } else { -1.0 };
    DVec3::new(sign(0), sign(1), sign(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_every_zone_that_contains_the_point() {
        let place = |i| {
            let [x, y, z, r] = sobol_burley::sample_4d(i, 0, 3).map(f64::from);
            (DVec3::new(x, y, z) * 2.0 - 1.0, 0.5 * r * r * r)
        };
        let mut tree = Octree::new(DVec3::ZERO, 1.0);
        for i in 0..500 {
            tree.insert(i, place(i).0, place(i).1);
        }
        let mut candidates = 0;
        for i in 500..1000 {
            let point = place(i).0;
            let mut found = vec![];
            tree.around(point, |record| found.push(record));
            candidates += found.len();
            for record in 0..500 {
                if place(record).0.distance(point) < place(record).1 {
                    assert!(found.contains(&record), "{record} at {point}");
                }
            }
        }
        assert!(candidates < 500 * 150, "{candidates} visits: nothing is culled");
    }
}

//! The same surface by fewer triangles: vertices in flat places and on straight edges are not needed.

use super::adjacency::NONE;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Most triangles around a vertex that is taken away.
const MOST_AROUND: usize = 32;
/// Thinnest triangle that is made: twice its area, in squares of its longest side.
const THINNEST: f64 = 1e-3;
/// How much longer edges may be, sweep by sweep.
const GROWTH: f32 = 1.5;

/// `triangles` without the vertices that can be drawn along an edge to a neighbour while no point of the surface leaves it by more
/// than about `tolerance`, in the positions' unit. Corners are the same where their numbers are; whatever is made `may_be` with
/// these corners.
///
/// Edges are collapsed as by Hoppe et al. 1993, but none at a cost: what meshoptimizer's quadrics, in single precision, tell from
/// flat is off by 2⁻¹² of what they are of. Short edges go first, so that what lies side by side grows alike. Open borders stay
/// where they are, and what more than two triangles share.
pub fn merged(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    tolerance: f64,
    may_be: impl Fn(&[Vec3; 3]) -> bool + Sync,
) -> Vec<[u32; 3]> {
    let mut mesh = Mesh::new(positions, triangles);
    let mut moves: Vec<Option<Move>> = vec![None; positions.len()];
    let mut changed: Vec<bool> = mesh.first.iter().map(|corner| *corner != NONE).collect();
    let mut longest = 0.0_f32;
    loop {
        let asked: Vec<u32> = (0..).zip(&changed).filter(|(_, changed)| **changed).map(|(vertex, _)| vertex).collect();
        let found: Vec<_> = asked.par_iter().map(|vertex| mesh.shortest_move(*vertex, tolerance, &may_be)).collect();
        for (vertex, found) in asked.iter().zip(found) {
            (moves[*vertex as usize], changed[*vertex as usize]) = (found, false);
        }
        let Some(shortest) = moves.iter().flatten().map(|m| m.length).reduce(f32::min) else { break };
        longest = longest.max(shortest) * GROWTH;
        for vertex in 0..positions.len() as u32 {
            // What has changed since it was asked is asked anew.
            let now = moves[vertex as usize].filter(|m| m.length <= longest && !changed[vertex as usize]);
            let Some(Move { to, .. }) = now else { continue };
            moves[vertex as usize] = None;
            if mesh.joins_well(vertex, to) {
                mesh.collapse(vertex, to, |v| changed[v as usize] = true);
                changed[vertex as usize] = false;
            }
        }
    }
    mesh.triangles.into_iter().filter(|t| t[0] != NONE).collect()
}

/// Along an edge of this length.
#[derive(Clone, Copy)]
struct Move {
    length: f32,
    to: u32,
}

struct Mesh<'a> {
    positions: &'a [Vec3],
    /// Those that are gone have no corners.
    triangles: Vec<[u32; 3]>,
    /// Of each vertex a corner that is there: three times its triangle, and which one; and of each corner the next one.
    first: Vec<u32>,
    next: Vec<u32>,
}

/// Triangles around a vertex.
struct Star {
    count: usize,
    /// Of each the corners after the vertex, and before it.
    sides: [[u32; 2]; MOST_AROUND],
}

impl Star {
    fn sides(&self) -> &[[u32; 2]] {
        &self.sides[..self.count]
    }

    fn touches(&self, vertex: u32) -> bool {
        self.sides().iter().any(|side| side.contains(&vertex))
    }

    /// The first vertex around, and the last: the same where the triangles close. None where they are not one fan.
    fn ends(&self) -> Option<[u32; 2]> {
        let sides = self.sides();
        let is_end = |v: u32| sides.iter().any(|s| s[1] == v);
        let start = sides.iter().map(|s| s[0]).find(|v| !is_end(*v)).or_else(|| Some(sides.first()?[0]))?;
        let mut at = start;
        for turn in 1..=sides.len() {
            let mut on = sides.iter().filter(|s| s[0] == at);
            let (Some(side), None) = (on.next(), on.next()) else { return None };
            at = side[1];
            let comes_once = sides.iter().filter(|s| s[1] == at).count() == 1;
            if !comes_once || at == start && turn < sides.len() {
                return None;
            }
        }
        Some([start, at])
    }
}

impl<'a> Mesh<'a> {
    fn new(positions: &'a [Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut first = vec![NONE; positions.len()];
        let mut next = vec![NONE; 3 * triangles.len()];
        for (corner, vertex) in (0..).zip(triangles.as_flattened()) {
            next[corner as usize] = std::mem::replace(&mut first[*vertex as usize], corner);
        }
        Self { positions, triangles: triangles.to_vec(), first, next }
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    fn corners_of(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let some = |corner: u32| (corner != NONE).then_some(corner);
        std::iter::successors(some(self.first[vertex as usize]), move |c| some(self.next[*c as usize]))
    }

    /// None where there are too many.
    fn star(&self, vertex: u32) -> Option<Star> {
        let mut star = Star { count: 0, sides: [[NONE; 2]; MOST_AROUND] };
        for corner in self.corners_of(vertex) {
            let (t, i) = (self.triangles[(corner / 3) as usize], (corner % 3) as usize);
            *star.sides.get_mut(star.count)? = [t[(i + 1) % 3], t[(i + 2) % 3]];
            star.count += 1;
        }
        Some(star)
    }

    /// The shortest edge that a vertex can be drawn along.
    fn shortest_move(&self, vertex: u32, tolerance: f64, may_be: &impl Fn(&[Vec3; 3]) -> bool) -> Option<Move> {
        let star = self.star(vertex)?;
        let p = self.at(vertex);
        let mut normals = [DVec3::ZERO; MOST_AROUND];
        for (normal, [a, b]) in normals.iter_mut().zip(star.sides()) {
            *normal = (self.at(*a) - p).cross(self.at(*b) - p).try_normalize()?;
        }
        let normals = &normals[..star.count];
        let [start, end] = star.ends()?;
        let is_on_all = |to: DVec3| normals.iter().all(|n| n.dot(to - p).abs() <= tolerance);
        // On a border only along it, where it is straight.
        let is_straight = |to: u32, other: u32| {
            let (along, way) = (self.at(to) - self.at(other), p - self.at(other));
            (way - along * (way.dot(along) / along.length_squared())).length() <= tolerance
        };
        let stays_open =
            |to: u32| start == end || to == start && is_straight(to, end) || to == end && is_straight(to, start);
        let makes_good_ones = |to: u32| {
            let q = self.at(to);
            star.sides().iter().zip(normals).filter(|(side, _)| !side.contains(&to)).all(|([a, b], normal)| {
                let (u, v) = (self.at(*a) - q, self.at(*b) - q);
                let longest = u.length_squared().max(v.length_squared()).max((u - v).length_squared());
                u.cross(v).dot(*normal) >= THINNEST * longest
                    && may_be(&[to, *a, *b].map(|v| self.positions[v as usize]))
            })
        };
        let around = star.sides().iter().map(|s| s[0]).chain((start != end).then_some(end));
        // What is not shorter than what has been found is not looked at.
        around.fold(None, |best: Option<Move>, to| {
            let there = Move { length: self.at(to).distance(p) as f32, to };
            let shorter = best.is_none_or(|best| (there.length, to) < (best.length, best.to));
            let can = shorter && is_on_all(self.at(to)) && stays_open(to) && makes_good_ones(to);
            if can { Some(there) } else { best }
        })
    }

    /// Whether the ends of an edge have no neighbours in common but the corners opposite to it.
    fn joins_well(&self, vertex: u32, to: u32) -> bool {
        let (Some(star), Some(other)) = (self.star(vertex), self.star(to)) else { return false };
        let is_opposite = |v: u32| star.sides().iter().any(|s| s.contains(&v) && s.contains(&to));
        let mut around = star.sides().as_flattened().iter().filter(|v| **v != to);
        around.all(|v| is_opposite(*v) || !other.touches(*v))
    }

    /// Draws a vertex to another one, and tells those whose triangles change.
    fn collapse(&mut self, vertex: u32, to: u32, mut tell: impl FnMut(u32)) {
        let mut corner = std::mem::replace(&mut self.first[vertex as usize], NONE);
        while corner != NONE {
            let next = self.next[corner as usize];
            let triangle = &mut self.triangles[(corner / 3) as usize];
            triangle.iter().for_each(|v| tell(*v));
            if triangle.contains(&to) {
                let gone = std::mem::replace(triangle, [NONE; 3]);
                gone.into_iter().filter(|v| *v != vertex).for_each(|v| self.forget_gone(v));
            } else {
                triangle[(corner % 3) as usize] = to;
                self.next[corner as usize] = std::mem::replace(&mut self.first[to as usize], corner);
            }
            corner = next;
        }
    }

    /// Takes corners of triangles that are gone out of a vertex's list.
    fn forget_gone(&mut self, vertex: u32) {
        let is_gone = |mesh: &Self, corner: u32| corner != NONE && mesh.triangles[(corner / 3) as usize][0] == NONE;
        while is_gone(self, self.first[vertex as usize]) {
            self.first[vertex as usize] = self.next[self.first[vertex as usize] as usize];
        }
        let mut corner = self.first[vertex as usize];
        while corner != NONE {
            while is_gone(self, self.next[corner as usize]) {
                self.next[corner as usize] = self.next[self.next[corner as usize] as usize];
            }
            corner = self.next[corner as usize];
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::adjacency;
    use crate::math::simplify::tests::{volume, wavy_box};
    use std::collections::HashSet;

    fn welded((positions, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let triangles = adjacency::welded(&positions, &triangles);
        (positions, triangles)
    }

    /// Squares of the unit square, n a side, each of two triangles, as high as `height` says.
    pub(in crate::math) fn sheet(n: u32, height: impl Fn(f32, f32) -> f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let point = |i: u32| {
            let [x, y] = [i % (n + 1), i / (n + 1)].map(|v| v as f32 / n as f32);
            Vec3::new(x, y, height(x, y))
        };
        let squares = (0..n * n).map(|i| i % n + i / n * (n + 1));
        let triangles = squares.flat_map(|i| [[i, i + 1, i + n + 1], [i + 1, i + n + 2, i + n + 1]]);
        ((0..(n + 1) * (n + 1)).map(point).collect(), triangles.collect())
    }

    fn is_closed(positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
        adjacency::neighbours(triangles, positions).iter().flatten().all(|t| *t != NONE)
    }

    /// Area of a triangle's shadow on the sheet's plane, negative if it is turned over.
    pub(in crate::math) fn shadow(corners: [Vec3; 3]) -> f32 {
        let [a, b, c] = corners.map(|p| p.truncate());
        (b - a).perp_dot(c - a) * 0.5
    }

    fn shadows(positions: &[Vec3], triangles: &[[u32; 3]]) -> f32 {
        triangles.iter().map(|t| shadow(t.map(|v| positions[v as usize]))).sum()
    }

    #[test]
    fn a_box_is_as_many_triangles_as_it_needs() {
        for n in [2, 7, 32] {
            let (positions, triangles) = welded(wavy_box(n, 0.0));
            let few = merged(&positions, &triangles, 1e-6, |_| true);
            assert!(few.len() < 20, "{} of {}", few.len(), triangles.len());
            assert!(is_closed(&positions, &few));
            assert!((volume(&positions, &few) - 1.0).abs() < 1e-5);
        }
    }

    /// The lid of a box is a wave: what is flat beside it goes, of it nothing; its border and it still meet.
    #[test]
    fn what_is_bent_stays() {
        let (positions, triangles) = welded(wavy_box(32, 0.1));
        let few = merged(&positions, &triangles, 1e-6, |_| true);
        let is_within = |p: Vec3| p.z > 0.5 && p.truncate().min_element() > 0.0 && p.truncate().max_element() < 1.0;
        let of_lid = |t: &&[u32; 3]| t.iter().any(|v| is_within(positions[*v as usize]));
        assert_eq!(few.iter().filter(of_lid).count(), triangles.iter().filter(of_lid).count());
        assert!(few.len() < triangles.len() / 2, "{} of {}", few.len(), triangles.len());
        assert!(is_closed(&positions, &few));
        assert!((volume(&positions, &few) - volume(&positions, &triangles)).abs() < 1e-5);
    }

    /// Vertices stay where they were: what lies between them sinks below the dome. Sweep by sweep that adds up, to no more than a
    /// few times the tolerance.
    #[test]
    fn what_is_nearly_flat_moves_by_a_few_tolerances() {
        let dome = |x: f32, y: f32| 0.1 * ((3.1 * x).sin() * (2.3 * y).cos());
        let (positions, triangles) = sheet(256, dome);
        for tolerance in [1e-6, 1e-5, 1e-4] {
            let few = merged(&positions, &triangles, tolerance, |_| true);
            assert!((shadows(&positions, &few) - 1.0).abs() < 1e-4);
            let off = |t: &[u32; 3], [u, v]: [f32; 2]| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                let p = a + u * (b - a) + v * (c - a);
                f64::from((dome(p.x, p.y) - p.z).abs())
            };
            let places = [[1.0 / 3.0, 1.0 / 3.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]];
            let worst = few.iter().flat_map(|t| places.map(|at| off(t, at))).fold(0.0, f64::max);
            assert!(worst < 4.0 * tolerance + 1e-6, "{worst} by {tolerance}, {} triangles", few.len());
            assert!(tolerance < 1e-5 || few.len() < triangles.len() / 2, "{} by {tolerance}", few.len());
        }
    }

    #[test]
    fn triangles_may_be_no_larger_than_is_said() {
        let (positions, triangles) = sheet(32, |_, _| 0.0);
        let longest = |[a, b, c]: &[Vec3; 3]| a.distance(*b).max(b.distance(*c)).max(c.distance(*a));
        let few = merged(&positions, &triangles, 1e-6, |corners| longest(corners) < 0.3);
        assert!(few.iter().all(|t| longest(&t.map(|v| positions[v as usize])) < 0.3));
        assert!((30..200).contains(&few.len()), "{}", few.len());
        assert!((shadows(&positions, &few) - 1.0).abs() < 1e-5);
    }

    /// Three sheets that share a side, one of them with a notch: of the side every vertex stays, and the notch.
    #[test]
    fn what_three_share_stays_and_corners_of_borders() {
        let (points, squares) = sheet(8, |_, _| 0.0);
        let turns: [fn(Vec3) -> Vec3; 3] = [|p| p, |p| Vec3::new(-p.x, p.y, p.x), |p| Vec3::new(-p.x, p.y, -p.x)];
        let positions: Vec<Vec3> = turns.iter().flat_map(|turn| points.iter().map(|p| turn(*p))).collect();
        let of_sheet = |i: u32| squares.iter().map(move |t| t.map(|v| v + 81 * i));
        let notch = |t: &[u32; 3]| t.iter().any(|v| positions[*v as usize].truncate() == glam::Vec2::new(1.0, 0.5));
        let triangles = (0..3).flat_map(of_sheet).filter(|t| !notch(t)).collect();
        let (positions, triangles) = welded((positions, triangles));
        let few = merged(&positions, &triangles, 1e-6, |_| true);
        let left: HashSet<u32> = few.as_flattened().iter().copied().collect();
        let there: HashSet<u32> = triangles.as_flattened().iter().copied().collect();
        let must_stay = |v: &&u32| {
            let p = positions[**v as usize];
            p.x == 0.0 || p.z == 0.0 && p.x == 0.875 && (p.y == 0.5 || p.y == 0.625)
        };
        assert_eq!(there.iter().filter(must_stay).count(), 9 + 2);
        assert!(there.iter().filter(must_stay).all(|v| left.contains(v)));
        assert!(few.len() < triangles.len() / 3, "{} of {}", few.len(), triangles.len());
    }

    /// Without area, twice the same, of the same corner twice: none of them breaks anything.
    #[test]
    fn what_is_no_surface_is_left_alone() {
        let (mut positions, mut triangles) = sheet(8, |_, _| 0.0);
        triangles.extend([[0, 1, 1], [2, 2, 2], [3, 4, 5], [20, 21, 29], [20, 21, 29], [29, 21, 20]]);
        positions.push(Vec3::NAN);
        triangles.push([40, 41, positions.len() as u32 - 1]);
        let few = merged(&positions, &triangles, 1e-6, |_| true);
        assert!(few.len() < triangles.len() && few.contains(&[2, 2, 2]));
        assert!(merged(&[], &[], 1e-6, |_| true).is_empty());
    }
}

//! Cutting triangles smaller: for projections that bend their sides, and for cells that are finer near a focus.

use super::{Part, Scene};
use crate::math::density::Focus;
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// How long a side of a triangle may be.
#[derive(Clone, Debug, PartialEq)]
pub struct SideLimit {
    /// Anywhere.
    pub longest: f32,
    /// What else limits it, by where its middle is.
    pub foci: Vec<Focus>,
}

impl SideLimit {
    /// The same everywhere.
    pub fn even(longest: f32) -> Self {
        Self { longest, foci: Vec::new() }
    }

    /// Whether any side of a triangle that may be cut is longer.
    pub fn cuts(&self, scene: &Scene) -> bool {
        let mut may_be_cut =
            scene.parts.iter().filter(|part| !scene.emits(part)).flat_map(|part| scene.triangles_of(part));
        may_be_cut.any(|t| self.worst_side(&scene.positions, *t).1 > 1.0)
    }

    /// The corner that the side which is longest beside its limit starts from, and its length in parts of that. What side
    /// is cut depends on nothing else, so that neighbours agree.
    fn worst_side(&self, positions: &[Vec3], triangle: [u32; 3]) -> (usize, f32) {
        let share = |i: usize| {
            let [a, b] = [triangle[i % 3], triangle[(i + 1) % 3]].map(|v| positions[v as usize]);
            let middle = (a + b) * 0.5;
            let limit = self.foci.iter().fold(self.longest, |limit, focus| limit.min(focus.longest_side(middle)));
            a.distance(b) / limit
        };
        let shares = [0, 1, 2].map(share);
        let later = if shares[1] >= shares[2] { 1 } else { 2 };
        let first = if shares[0] >= shares[later] { 0 } else { later };
        (first, shares[first])
    }
}

impl Scene {
    /// The same surfaces with no side longer than `limit`. Triangles of emissive materials stay whole, so that lights are
    /// sampled as before.
    ///
    /// Every side is halved until it is short enough, whatever triangle it belongs to: neighbours that share a side share
    /// what it is cut into, and no gaps open between them.
    pub fn tessellated(&self, limit: &SideLimit) -> Self {
        let mut cut =
            Self { triangles: Vec::new(), parts: Vec::new(), core_of_whole: Some(self.core()), ..self.clone() };
        let mut middles = HashMap::new();
        for part in &self.parts {
            let whole = self.triangles_of(part);
            let first_triangle = cut.triangles.len() as u32;
            if self.emits(part) {
                cut.triangles.extend(whole);
            } else {
                whole.iter().for_each(|triangle| cut.add_pieces(*triangle, limit, &mut middles));
            }
            cut.parts.push(Part {
                first_triangle,
                triangle_count: cut.triangles.len() as u32 - first_triangle,
                ..*part
            });
        }
        cut
    }

    fn add_pieces(&mut self, whole: [u32; 3], limit: &SideLimit, middles: &mut HashMap<(u32, u32), u32>) {
        let mut open = vec![whole];
        while let Some(triangle) = open.pop() {
            let (first, share) = limit.worst_side(&self.positions, triangle);
            let [a, b, c] = [0, 1, 2].map(|i| triangle[(first + i) % 3]);
            if share > 1.0 {
                let middle = *middles.entry((a.min(b), a.max(b))).or_insert_with(|| self.add_middle(a, b));
                open.extend([[middle, b, c], [a, middle, c]]);
            } else {
                self.triangles.push(triangle);
            }
        }
    }

    /// A vertex halfway between two, with all that vertices have.
    fn add_middle(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (a as usize, b as usize);
        self.positions.push((self.positions[a] + self.positions[b]) * 0.5);
        let unit = |sum: Vec3, otherwise: Vec3| sum.try_normalize().unwrap_or(otherwise);
        if !self.normals.is_empty() {
            self.normals.push(unit(self.normals[a] + self.normals[b], self.normals[a]));
        }
        if !self.tangents.is_empty() {
            let [s, t]: [Vec4; 2] = [self.tangents[a], self.tangents[b]];
            self.tangents.push(unit(s.truncate() + t.truncate(), s.truncate()).extend(s.w));
        }
        for set in self.uvs.iter_mut().filter(|set| !set.is_empty()) {
            set.push((set[a] + set[b]) * 0.5);
        }
        if !self.colors.is_empty() {
            self.colors.push((self.colors[a] + self.colors[b]) * 0.5);
        }
        self.positions.len() as u32 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell;

    fn area(scene: &Scene) -> f64 {
        let corners = |t: &[u32; 3]| t.map(|v| scene.positions[v as usize].as_dvec3());
        let of = |t| {
            let [a, b, c] = corners(t);
            (b - a).cross(c - a).length() / 2.0
        };
        scene.triangles.iter().map(of).sum()
    }

    #[test]
    fn pieces_are_small_and_cover_the_same_surface() {
        let scene = cornell();
        let cut = scene.tessellated(&SideLimit::even(0.1));
        assert!((area(&cut) / area(&scene) - 1.0).abs() < 1e-6);
        assert_eq!(cut.parts.last().map(|p| p.first_triangle + p.triangle_count), Some(cut.triangles.len() as u32));
        for part in &cut.parts {
            for triangle in cut.triangles_of(part) {
                assert!(scene.emits(part) || SideLimit::even(0.1).worst_side(&cut.positions, *triangle).1 <= 1.0);
                let [a, b, c] = triangle.map(|v| cut.positions[v as usize]);
                assert!((b - a).cross(c - a).dot(cut.normals[triangle[0] as usize]) > 0.0, "the front stays in front");
            }
        }
        assert_eq!(cut.emitters().len(), scene.emitters().len());
        assert_eq!(cut.normals.len(), cut.positions.len());
    }

    /// Each inner side belongs to two triangles, with no vertex in between, wherever that was so before.
    #[test]
    fn no_gaps_open() {
        let mut scene = cornell();
        scene.materials.iter_mut().for_each(|m| m.emission = Vec3::ZERO);
        let bits = |p: Vec3| p.to_array().map(f32::to_bits);
        let open_sides = |scene: &Scene| {
            let mut sides = HashMap::new();
            for t in &scene.triangles {
                for i in 0..3 {
                    let [a, b] = [t[i], t[(i + 1) % 3]].map(|v| bits(scene.positions[v as usize]));
                    *sides.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
            let length = |(a, b): &([u32; 3], [u32; 3])| {
                Vec3::from_array(a.map(f32::from_bits)).distance(Vec3::from_array(b.map(f32::from_bits)))
            };
            sides.iter().filter(|(_, n)| **n == 1).map(|(side, _)| length(side)).sum::<f32>()
        };
        let before = open_sides(&scene);
        let foci = vec![Focus::camera(Vec3::new(0.1, 0.05, 0.1), 0.5)];
        for limit in [SideLimit::even(0.07), SideLimit { longest: f32::INFINITY, foci }] {
            assert!(limit.cuts(&scene));
            let cut = scene.tessellated(&limit);
            assert!(!limit.cuts(&cut));
            let after = open_sides(&cut);
            assert!((after - before).abs() < 1e-4 * before, "{before} {after}");
        }
    }
}

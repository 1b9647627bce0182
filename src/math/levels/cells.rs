//! Light of coarse triangles: each of their cells shows the finer cell that is nearest to its centre.

use crate::math::cells as grid;
use glam::{Vec2, Vec3};

/// A triangle with its cells.
#[derive(Clone, Copy)]
pub struct Piece {
    corner: Vec3,
    /// From the corner to the others.
    sides: [Vec3; 2],
    normal: Vec3,
    low: Vec3,
    high: Vec3,
    first: u32,
    resolution: u32,
}

impl Piece {
    /// A triangle whose r² cells start at `first`.
    pub fn new([a, b, c]: [Vec3; 3], first: u32, resolution: u32) -> Self {
        let sides = [b - a, c - a];
        let normal = sides[0].cross(sides[1]);
        Self { corner: a, sides, normal, low: a.min(b).min(c), high: a.max(b).max(c), first, resolution }
    }

    fn cells(&self) -> u32 {
        self.resolution * self.resolution
    }

    fn point(&self, uv: Vec2) -> Vec3 {
        self.corner + uv.x * self.sides[0] + uv.y * self.sides[1]
    }

    fn centre(&self, cell: u32) -> Vec3 {
        self.point(grid::centre(self.resolution, cell))
    }

    /// Square of the distance from its box, which its own is no less than.
    fn box_distance_squared(&self, p: Vec3) -> f32 {
        (self.low - p).max(p - self.high).max(Vec3::ZERO).length_squared()
    }

    /// (u, v) of its point nearest to `p`.
    fn closest(&self, p: Vec3) -> Vec2 {
        let ([u, v], d) = (self.sides, p - self.corner);
        let (uu, uv, vv, du, dv) = (u.dot(u), u.dot(v), v.dot(v), d.dot(u), d.dot(v));
        let inside = Vec2::new(du * vv - dv * uv, dv * uu - du * uv) / (uu * vv - uv * uv);
        if inside.min_element() >= 0.0 && inside.x + inside.y <= 1.0 {
            return inside;
        }
        let share = |along: Vec3, from: Vec3| {
            let t = from.dot(along) / along.length_squared();
            if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
        };
        let (t0, t1, t2) = (share(u, d), share(v, d), share(v - u, d - u));
        let candidates = [Vec2::new(t0, 0.0), Vec2::new(0.0, t1), Vec2::new(1.0 - t2, t2)];
        let distance = |s: &Vec2| (d - s.x * u - s.y * v).length_squared();
        candidates.into_iter().min_by(|s, t| distance(s).total_cmp(&distance(t))).unwrap_or_default()
    }
}

/// For each cell of `coarse` the cell of `fine` that it shows.
///
/// What faces the same way goes before what does not, and what is within `error` before the rest.
pub fn shown(coarse: Vec<Piece>, mut fine: Vec<Piece>, error: f32) -> Vec<(u32, u32)> {
    let axis = longest(&fine);
    fine.sort_by(|a, b| a.low[axis].total_cmp(&b.low[axis]));
    let extent = fine.iter().map(|p| p.high[axis] - p.low[axis]).fold(0.0, f32::max);
    let mut all = Vec::new();
    let mut near = Vec::new();
    for piece in coarse {
        let from = fine.partition_point(|p| p.low[axis] < piece.low[axis] - error - extent);
        let to = fine.partition_point(|p| p.low[axis] <= piece.high[axis] + error);
        find_near(&piece, &fine[from..to], &fine, error, &mut near);
        all.extend((0..piece.cells()).map(|cell| (piece.first + cell, nearest(piece.centre(cell), &mut near))));
    }
    all
}

/// Axis along which pieces are spread most.
fn longest(pieces: &[Piece]) -> usize {
    let low = pieces.iter().fold(Vec3::INFINITY, |low, p| low.min(p.low));
    let high = pieces.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(p.high));
    let size = high - low;
    (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0)
}

/// Those of `around` that face as `piece` does and whose boxes come within `error` of its own; or of all that face so; or
/// all.
fn find_near<'a>(piece: &Piece, around: &'a [Piece], all: &'a [Piece], error: f32, near: &mut Vec<&'a Piece>) {
    let (low, high) = (piece.low - error, piece.high + error);
    let alike = |other: &&Piece| other.normal.dot(piece.normal) >= 0.0;
    near.clear();
    near.extend(around.iter().filter(|o| o.low.cmple(high).all() && o.high.cmpge(low).all()).filter(alike));
    if near.is_empty() {
        near.extend(all.iter().filter(alike));
    }
    if near.is_empty() {
        near.extend(all);
    }
}

/// The cell nearest to a point, of those of `pieces`; the piece that has it comes first, for the next point is near.
fn nearest(point: Vec3, pieces: &mut [&Piece]) -> u32 {
    let mut best = (f32::INFINITY, 0, Vec2::ZERO);
    for (index, piece) in pieces.iter().enumerate() {
        if piece.box_distance_squared(point) < best.0 {
            let uv = piece.closest(point);
            let distance = piece.point(uv).distance_squared(point);
            if distance < best.0 {
                best = (distance, index, uv);
            }
        }
    }
    pieces.swap(0, best.1);
    pieces[0].first + grid::at(pieces[0].resolution, best.2)
}

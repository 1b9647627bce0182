//! The hemisphere, projected along the normal onto the unit disc below it (Nusselt's analog, 1928; S4's "fish eye"):
//! area on the disc is cosine-weighted solid angle, so that all texels but those on the rim weigh the same.
//!
//! S4 gives each of the N texels whose centre lies within the disc the weight π/N. Here a texel has exactly its area
//! within the disc, and those of the rim also that of their outer neighbours, whose centres lie outside: the sum is π
//! just as well, and a light in the middle is not scaled by how many centres the disc happens to hold (1 % at 32²).

use super::{Edge, Table, Texel, pitch};
use crate::math::quadrature::gauss_legendre;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// ∫ over a part of the disc.
#[derive(Clone, Copy, Default)]
struct Measure {
    flux: DVec3,
    solid_angle: f64,
}

/// The squares of the disc's bounds.
pub(super) struct Grid {
    size: u32,
    pitch: f64,
}

/// A side of a square between squares of different owners: the part of the line x = `line` with y from `low` to `high`,
/// turned by −90° if `turned`, crossed from the first owner to the second.
struct Side {
    owners: [u32; 2],
    line: f64,
    low: f64,
    high: f64,
    turned: bool,
}

/// Points of a rule over a square, along each of its axes, and along an edge.
const POINTS: u32 = 6;

impl Grid {
    pub(super) fn new(size: u32) -> Self {
        Self { size, pitch: pitch(size, 1.0) }
    }

    /// Measures the texels and the edges between them.
    pub(super) fn table(&self) -> Table {
        let mut texels = self.covered();
        for (y, x, i) in self.owned() {
            let part = self.measure(x, y);
            texels[i as usize].flux += part.flux;
            texels[i as usize].solid_angle += part.solid_angle;
        }
        Table { texels, edges: self.edges() }
    }

    /// [`super::Shape::visit_texels`]. In columns y = √(1 − x²)·sin t, so that dω = dx dy/z = dx dt.
    pub(super) fn visit_texels(&self, visit: &mut dyn FnMut(usize, DVec3, f64)) {
        let rule = gauss_legendre(POINTS);
        for (row, column, i) in self.owned() {
            let (sign, low) = (self.centre(column, row).signum(), self.inner_corner(column, row));
            let high = (low + self.pitch).min(DVec2::ONE);
            let (full, rim) = spans(low, high);
            for [from, to] in [full, rim].into_iter().filter(|[from, to]| to > from) {
                for &(u, wu) in &rule {
                    // Where the rim cuts a square, columns shorten by the square root of what is left of x.
                    let (x, wu) = (to - u * u * (to - from), 2.0 * u * wu);
                    let s = half_chord(x);
                    let [first, last] = [low.y, high.y].map(|y| (y / s).min(1.0).asin());
                    for &(v, wv) in &rule {
                        let (sine, cosine) = (first + v * (last - first)).sin_cos();
                        let direction = DVec3::new(sign.x * x, sign.y * s * sine, s * cosine);
                        visit(i as usize, direction, wu * wv * (to - from) * (last - first));
                    }
                }
            }
        }
    }

    /// [`super::Shape::visit_edges`]. On the arc (c, s sin t, s cos t) m dl = (s, −c sin t, −c cos t) s dt.
    pub(super) fn visit_edges(&self, visit: &mut dyn FnMut(usize, DVec3, DVec3)) {
        let rule = gauss_legendre(POINTS);
        let mut numbers: BTreeMap<[u32; 2], usize> = self.sides().iter().map(|side| (side.pair(), 0)).collect();
        numbers.values_mut().enumerate().for_each(|(number, of)| *of = number);
        for side in self.sides() {
            let (c, s) = (side.line, half_chord(side.line));
            let [first, last] = [side.low, side.high].map(|y| (y / s).clamp(-1.0, 1.0).asin());
            for &(t, weight) in &rule {
                let (sine, cosine) = (first + t * (last - first)).sin_cos();
                let length = weight * (last - first) * s;
                let m = DVec3::new(s, -c * sine, -c * cosine) * side.sense();
                visit(numbers[&side.pair()], side.turn(DVec3::new(c, s * sine, s * cosine)), length * side.turn(m));
            }
        }
    }

    /// The texels, not yet measured: squares whose centres lie on the disc.
    fn covered(&self) -> Vec<Texel> {
        let texel = |(y, x)| {
            let p = self.centre(x, y);
            let direction = p.extend((1.0 - p.length_squared()).sqrt());
            Texel { layer: 0, x, y, direction, solid_angle: 0.0, flux: DVec3::ZERO, forward: 1.0 }
        };
        self.squares().filter(|&(y, x)| self.is_covered(x, y)).map(texel).collect()
    }

    /// Number of the texel that each square belongs to: none outside of the disc.
    fn owners(&self) -> Vec<Option<u32>> {
        let mut numbers = vec![None; (self.size * self.size) as usize];
        let covered = self.squares().filter(|&(y, x)| self.is_covered(x, y));
        for (number, (y, x)) in (0..).zip(covered) {
            numbers[(y * self.size + x) as usize] = Some(number);
        }
        let of = |(y, x)| self.owner(x, y).and_then(|(x, y)| numbers[(y * self.size + x) as usize]);
        self.squares().map(of).collect()
    }

    /// Row, column and owner of every square that has one.
    fn owned(&self) -> impl Iterator<Item = (u32, u32, u32)> + use<> {
        self.squares().zip(self.owners()).filter_map(|((y, x), owner)| owner.map(|owner| (y, x, owner)))
    }

    /// Sides between squares of different owners, row by row.
    fn sides(&self) -> Vec<Side> {
        let owners = self.owners();
        let owner = |x: u32, y: u32| owners[(y * self.size + x) as usize];
        let at = |k: u32| f64::from(k) * self.pitch - 1.0;
        let mut sides = Vec::new();
        let mut add = |i: Option<u32>, j: Option<u32>, [line, low, high]: [f64; 3], turned| {
            if let (Some(i), Some(j)) = (i, j)
                && i != j
            {
                sides.push(Side { owners: [i, j], line, low, high, turned });
            }
        };
        for (row, column) in self.squares().filter(|&(_, column)| column > 0) {
            let (line, from) = (at(column), at(row));
            // From left to right across x = line; rows count from the top.
            add(owner(column - 1, row), owner(column, row), [line, -from - self.pitch, -from], false);
            // The same turned: downwards across y = −line.
            add(owner(row, column - 1), owner(row, column), [line, from, from + self.pitch], true);
        }
        sides
    }

    /// Edges between texels, each the sum of the sides that they share.
    fn edges(&self) -> Vec<Edge> {
        // Of each pair the step and the sum of its arcs' middles.
        let mut sums: BTreeMap<[u32; 2], [DVec3; 2]> = BTreeMap::new();
        for side in self.sides() {
            let step = side.turn(small_circle(side.line, side.low, side.high));
            let middle = side.turn(on_sphere(side.line, (side.low + side.high) / 2.0));
            let sum = sums.entry(side.pair()).or_default();
            sum[0] += side.sense() * step;
            sum[1] += middle;
        }
        sums.into_iter().map(|([i, j], [step, middles])| Edge { i, j, step, middle: middles.normalize() }).collect()
    }

    /// All squares as (row, column).
    fn squares(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let size = self.size;
        (0..size).flat_map(move |y| (0..size).map(move |x| (y, x)))
    }

    fn centre(&self, x: u32, y: u32) -> DVec2 {
        DVec2::new((f64::from(x) + 0.5) * self.pitch - 1.0, 1.0 - (f64::from(y) + 0.5) * self.pitch)
    }

    fn is_covered(&self, x: u32, y: u32) -> bool {
        self.centre(x, y).length_squared() < 1.0
    }

    /// Corner of a square nearest to the middle of the disc, by absolute coordinates.
    fn inner_corner(&self, x: u32, y: u32) -> DVec2 {
        (self.centre(x, y).abs() - self.pitch / 2.0).max(DVec2::ZERO)
    }

    /// The covered square that stands for (x, y): itself or one further in; none outside of the disc.
    fn owner(&self, mut x: u32, mut y: u32) -> Option<(u32, u32)> {
        if self.inner_corner(x, y).length_squared() >= 1.0 {
            return None;
        }
        let inwards = |c: u32| if 2 * c < self.size { c + 1 } else { c - 1 };
        while !self.is_covered(x, y) {
            let a = self.centre(x, y).abs();
            let (from_x, from_y) = (a.x >= a.y - self.pitch / 2.0, a.y >= a.x - self.pitch / 2.0);
            x = if from_x { inwards(x) } else { x };
            y = if from_y { inwards(y) } else { y };
        }
        Some((x, y))
    }

    fn measure(&self, x: u32, y: u32) -> Measure {
        let sign = self.centre(x, y).signum();
        let low = self.inner_corner(x, y);
        let mut part = first_quadrant(low, (low + self.pitch).min(DVec2::ONE));
        part.flux *= sign.extend(1.0);
        part
    }
}

/// The part of the disc in [low, high], both in the first quadrant.
fn first_quadrant(low: DVec2, high: DVec2) -> Measure {
    let (full, rim) = spans(low, high);
    let area = over(full, |x| x * (high.y - low.y)) + over(rim, |x| circle(x, 1.0) - x * low.y);
    let solid_angle = over(full, |x| arc(x, high.y) - arc(x, low.y)) + over(rim, |x| FRAC_PI_2 * x - arc(x, low.y));
    let turned = |p: DVec2| DVec2::new(p.y, p.x);
    Measure { flux: DVec3::new(moment(turned(low), turned(high)), moment(low, high), area), solid_angle }
}

/// ∫∫ y/z dy dx over the same part: ∫ y/z dy = −z.
fn moment(low: DVec2, high: DVec2) -> f64 {
    let (full, rim) = spans(low, high);
    let (near, far) = (half_chord(low.y), half_chord(high.y));
    over(full, |x| circle(x, near) - circle(x, far)) + over(rim, |x| circle(x, near))
}

/// Where columns have their full height, and where the rim cuts them.
fn spans(low: DVec2, high: DVec2) -> ([f64; 2], [f64; 2]) {
    let full = high.x.min(half_chord(high.y)).max(low.x);
    let rim = high.x.min(half_chord(low.y)).max(full);
    ([low.x, full], [full, rim])
}

fn over([a, b]: [f64; 2], antiderivative: impl Fn(f64) -> f64) -> f64 {
    antiderivative(b) - antiderivative(a)
}

fn half_chord(c: f64) -> f64 {
    (1.0 - c * c).max(0.0).sqrt()
}

/// ∫ √(r² − x²) dx.
fn circle(x: f64, r: f64) -> f64 {
    if r <= 0.0 {
        return 0.0;
    }
    let x = x.clamp(-r, r);
    0.5 * (x * (r * r - x * x).max(0.0).sqrt() + r * r * (x / r).asin())
}

/// ∫ asin(y/√(1 − x²)) dx, of which the difference over y is the solid angle ∫∫ dx dy/√(1 − x² − y²).
fn arc(x: f64, y: f64) -> f64 {
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let angle = |a: f64, c: f64| a.atan2((1.0 - c * c - a * a).max(0.0).sqrt());
    x * angle(y, x) + y * angle(x, y) - (x * y).atan2(z)
}

impl Side {
    /// The owners, the lesser number first.
    fn pair(&self) -> [u32; 2] {
        let [i, j] = self.owners;
        [i.min(j), i.max(j)]
    }

    /// 1 if it is crossed from the lesser number to the greater one, else −1.
    fn sense(&self) -> f64 {
        if self.owners[0] < self.owners[1] { 1.0 } else { -1.0 }
    }

    fn turn(&self, v: DVec3) -> DVec3 {
        if self.turned { DVec3::new(v.y, -v.x, v.z) } else { v }
    }
}

/// The direction above (x, y) on the disc.
fn on_sphere(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// ∫ cosθ m dl over the arc x = c, y from `low` to `high`, m towards growing x. On the sphere the line x = c is the small
/// circle (c, s sin t, s cos t), s² = 1 − c²; across it m = (s, −c sin t, −c cos t), so that
/// ∫ cosθ m dl = (s² Δy, −c Δ(y²)/2, −c (s² Δt + Δ(yz))/2).
fn small_circle(c: f64, low: f64, high: f64) -> DVec3 {
    let s2 = 1.0 - c * c;
    let s = s2.sqrt();
    let [a, b] = [low, high].map(|y| y.clamp(-s, s));
    let lift = |y: f64| s2 * (y / s).clamp(-1.0, 1.0).asin() + y * (s2 - y * y).max(0.0).sqrt();
    DVec3::new(s2 * (b - a), -c * (b * b - a * a) / 2.0, -c * (lift(b) - lift(a)) / 2.0)
}

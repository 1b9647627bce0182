//! The normal equations (M + S)·x = b by conjugate gradients: M is the mass matrix of linear triangles, S that of the bend across
//! edges, b the integrals of E·φ.

use super::mesh::{Face, Mesh};
use glam::DVec3;
use std::collections::BTreeMap;

/// Residual, as a share of b, at which the solver ends.
const ENOUGH: f64 = 1e-7;
const MOST_STEPS: usize = 1000;
/// Rounds in which what is negative is held.
const ROUNDS: usize = 6;
/// Largest cotangent in a bend: slivers have no say.
const STEEPEST: f64 = 8.0;

/// An edge between two triangles: its ends and the corners across, with the factors of the bend.
struct Hinge {
    unknowns: [usize; 4],
    factors: [f64; 4],
}

/// Least squares, and the steps that it took.
pub fn least_squares(mesh: &Mesh, smoothness: f64) -> (Vec<DVec3>, usize) {
    let hinges = hinges(mesh, smoothness);
    let mut right = vec![DVec3::ZERO; mesh.count];
    for face in &mesh.faces {
        let weight = face.area / face.cells.len() as f64;
        for (weights, irradiance) in &face.cells {
            face.corners.iter().zip(weights).for_each(|(at, w)| right[*at] += *irradiance * (weight * w));
        }
    }
    let diagonal = diagonal(mesh, &hinges);
    // The lumped solution is close to begin with.
    let mut lumped = vec![0.0; mesh.count];
    for face in &mesh.faces {
        face.corners.iter().for_each(|at| lumped[*at] += face.area / 3.0);
    }
    let start = right.iter().zip(&lumped).map(|(b, area)| if *area > 0.0 { *b / *area } else { DVec3::ZERO }).collect();
    let system = Gradients { product: |x: &[DVec3]| product(mesh, &hinges, x), diagonal: &diagonal, right: &right };
    system.not_negative(start)
}

/// Mean irradiance, at each unknown, of the cells that lie next to it.
pub fn sampled(mesh: &Mesh) -> Vec<DVec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.count];
    for face in &mesh.faces {
        for (corner, at) in face.corners.iter().enumerate() {
            let nearest = face.cells.iter().max_by(|a, b| a.0[corner].total_cmp(&b.0[corner]));
            if let Some((_, irradiance)) = nearest {
                sums[*at].0 += *irradiance;
                sums[*at].1 += 1.0;
            }
        }
    }
    sums.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0)).collect()
}

fn product(mesh: &Mesh, hinges: &[Hinge], x: &[DVec3]) -> Vec<DVec3> {
    let mut y = vec![DVec3::ZERO; x.len()];
    for face in &mesh.faces {
        // ∫φᵢφⱼ = A/12, and twice that for i = j.
        let sum: DVec3 = face.corners.iter().map(|at| x[*at]).sum();
        face.corners.iter().for_each(|at| y[*at] += (sum + x[*at]) * (face.area / 12.0));
    }
    for Hinge { unknowns, factors } in hinges {
        let bend: DVec3 = unknowns.iter().zip(factors).map(|(at, f)| x[*at] * *f).sum();
        unknowns.iter().zip(factors).for_each(|(at, f)| y[*at] += bend * *f);
    }
    y
}

fn diagonal(mesh: &Mesh, hinges: &[Hinge]) -> Vec<f64> {
    let mut diagonal = vec![0.0; mesh.count];
    for face in &mesh.faces {
        face.corners.iter().for_each(|at| diagonal[*at] += face.area / 6.0);
    }
    for Hinge { unknowns, factors } in hinges {
        unknowns.iter().zip(factors).for_each(|(at, f)| diagonal[*at] += f * f);
    }
    diagonal
}

/// Edges that two triangles share. The bend is that of Bergou, Wardetzky, Harmon, Zorin and Grinspun 2006, equation 4: the jump of
/// the slope across the edge.
fn hinges(mesh: &Mesh, smoothness: f64) -> Vec<Hinge> {
    let mut edges: BTreeMap<[usize; 2], Vec<(usize, usize)>> = BTreeMap::new();
    for (index, face) in mesh.faces.iter().enumerate() {
        for corner in 0..3 {
            let ends = [face.corners[(corner + 1) % 3], face.corners[(corner + 2) % 3]];
            let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            edges.entry(key).or_default().push((index, corner));
        }
    }
    let inner = edges.into_values().filter(|faces| faces.len() == 2);
    inner.map(|faces| hinge(mesh, [faces[0], faces[1]], smoothness)).collect()
}

fn hinge(mesh: &Mesh, sides: [(usize, usize); 2], smoothness: f64) -> Hinge {
    let [first, second] = sides.map(|(index, _)| &mesh.faces[index]);
    let ends = [1, 2].map(|i| first.corners[(sides[0].1 + i) % 3]);
    let across = sides.map(|(index, corner)| mesh.faces[index].corners[corner]);
    let at = |face: &Face, unknown: usize| face.corners.iter().position(|c| *c == unknown).unwrap_or(0);
    let [[a, b], [c, d]] = [first, second].map(|face| ends.map(|end| cotangent(face, at(face, end))));
    let factors = [b + d, a + c, -(a + b), -(c + d)];
    // Squared, a bend has the irradiance's unit; an area makes it one with the error's integral.
    let weight = (3.0 * smoothness * (first.area + second.area)).sqrt();
    Hinge { unknowns: [ends[0], ends[1], across[0], across[1]], factors: factors.map(|f| f * weight) }
}

/// Of the angle at a corner.
fn cotangent(face: &Face, corner: usize) -> f64 {
    let [p, q, r] = [0, 1, 2].map(|i| face.positions[(corner + i) % 3]);
    let (u, v) = (q - p, r - p);
    (u.dot(v) / u.cross(v).length()).clamp(-STEEPEST, STEEPEST)
}

/// Conjugate gradients for A·x = b, A symmetric and positive, each channel by itself; scaled by the diagonal.
struct Gradients<'a, P> {
    product: P,
    diagonal: &'a [f64],
    right: &'a [DVec3],
}

impl<P: Fn(&[DVec3]) -> Vec<DVec3>> Gradients<'_, P> {
    /// The best x that is not negative, nearly: what comes out negative is held at 0, and the rest is solved anew.
    fn not_negative(&self, start: Vec<DVec3>) -> (Vec<DVec3>, usize) {
        let mut free = vec![DVec3::ONE; start.len()];
        let (mut x, mut steps) = (start, 0);
        for _ in 0..ROUNDS {
            steps += self.run(&mut x, &free);
            let held = |(x, free): (&mut DVec3, &mut DVec3)| {
                *free = DVec3::select(x.cmplt(DVec3::ZERO), DVec3::ZERO, *free);
                *x = x.max(DVec3::ZERO);
            };
            if x.iter().all(|x| x.cmpge(DVec3::ZERO).all()) {
                break;
            }
            x.iter_mut().zip(&mut free).for_each(held);
        }
        (x, steps)
    }

    /// Goes on from `x`, in what is `free`; the steps that it takes.
    fn run(&self, x: &mut [DVec3], free: &[DVec3]) -> usize {
        let scaled = |r: &[DVec3]| r.iter().zip(self.diagonal).map(|(r, d)| *r / *d).collect::<Vec<_>>();
        let rest = self.right.iter().zip((self.product)(x)).zip(free).map(|((b, ax), free)| (*b - ax) * *free);
        let mut rest: Vec<DVec3> = rest.collect();
        let mut z = scaled(&rest);
        let mut way = z.clone();
        let mut size = dot(&rest, &z);
        let enough = dot(self.right, &scaled(self.right)) * (ENOUGH * ENOUGH);
        for step in 0..MOST_STEPS {
            if size.cmple(enough).all() {
                return step;
            }
            let along = (self.product)(&way);
            let length = ratio(size, dot(&way, &along));
            x.iter_mut().zip(&way).for_each(|(x, w)| *x += length * *w);
            rest.iter_mut().zip(&along).zip(free).for_each(|((r, a), free)| *r -= length * *a * *free);
            z = scaled(&rest);
            let next = dot(&rest, &z);
            let turn = ratio(next, size);
            way.iter_mut().zip(&z).for_each(|(w, z)| *w = *z + turn * *w);
            size = next;
        }
        MOST_STEPS
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> DVec3 {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

fn ratio(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::select(b.cmpgt(DVec3::ZERO), a / b, DVec3::ZERO)
}

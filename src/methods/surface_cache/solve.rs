//! Solves E = b + K·E, or sums as many of its bounces as are asked for.

use super::system::System;
use glam::DVec3;

/// Directions that GMRES keeps before it starts anew.
const KEPT: usize = 40;

/// How all bounces are summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Bounce after bounce (Jacobi): of albedo ρ it takes ln ε/ln ρ products.
    Plain,
    /// GMRES (Saad and Schultz 1986), each colour channel by itself: a product for each distinct large eigenvalue, about.
    #[default]
    Accelerated,
}

/// Irradiance of all places, and how it came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// E of each place, W·m⁻².
    pub irradiance: Vec<DVec3>,
    /// ‖b + K·E − E‖/‖b‖ after each product, of the worst channel.
    pub residuals: Vec<f64>,
    /// What the bounces left out would add, as a share of the whole: an estimate by the last bounces' ratio.
    pub lost: f64,
}

/// The first `bounces` terms of b + K·b + K²·b + …
pub fn partial_sum(system: &System, first: &[DVec3], bounces: u32) -> Solution {
    if bounces == 0 {
        return Solution { irradiance: vec![DVec3::ZERO; first.len()], ..Solution::default() };
    }
    let mut sum = Sum::new(first);
    for _ in 1..bounces {
        if !sum.add(system) {
            break;
        }
    }
    sum.finish(system)
}

/// All terms, to a residual of `tolerance`, in `most` products at most.
pub fn solve(system: &System, first: &[DVec3], solver: Solver, tolerance: f64, most: usize) -> Solution {
    match solver {
        Solver::Plain => {
            let mut sum = Sum::new(first);
            while sum.residual() > tolerance && sum.residuals.len() < most && sum.add(system) {}
            sum.finish(system)
        }
        Solver::Accelerated => accelerated(system, first, tolerance, most),
    }
}

/// A sum of bounces so far.
struct Sum<'a> {
    first: &'a [DVec3],
    irradiance: Vec<DVec3>,
    last: Vec<DVec3>,
    residuals: Vec<f64>,
}

impl<'a> Sum<'a> {
    fn new(first: &'a [DVec3]) -> Self {
        Self { first, irradiance: first.to_vec(), last: first.to_vec(), residuals: Vec::new() }
    }

    fn residual(&self) -> f64 {
        self.residuals.last().copied().unwrap_or(f64::INFINITY)
    }

    /// Adds one more bounce; whether there was light in it.
    fn add(&mut self, system: &System) -> bool {
        self.last = system.product(&self.last);
        self.irradiance.iter_mut().zip(&self.last).for_each(|(sum, bounce)| *sum += bounce);
        self.residuals.push(share(norm(&self.last), norm(self.first)));
        self.residual() > 0.0
    }

    fn finish(self, system: &System) -> Solution {
        let next = system.product(&self.last);
        let lost = lost(&self.irradiance, &self.last, &next);
        Solution { irradiance: self.irradiance, residuals: self.residuals, lost }
    }
}

/// What all bounces after `last` add, those after `next` as a geometric series (Aitken 1926), as a share of the whole.
fn lost(irradiance: &[DVec3], last: &[DVec3], next: &[DVec3]) -> f64 {
    let total = |values: &[DVec3]| values.iter().map(|v| v.abs().element_sum()).sum::<f64>();
    let (whole, last, next) = (total(irradiance), total(last), total(next));
    let ratio = if last > 0.0 { (next / last).clamp(0.0, 1.0 - 1e-6) } else { 0.0 };
    let rest = next / (1.0 - ratio);
    if whole > 0.0 { rest / (whole + rest) } else { 0.0 }
}

/// GMRES from zero. Every scalar is one of each channel, for K mixes no channels.
fn accelerated(system: &System, first: &[DVec3], tolerance: f64, most: usize) -> Solution {
    let size = norm(first);
    let mut solution = Solution { irradiance: vec![DVec3::ZERO; first.len()], ..Solution::default() };
    let mut rest = first.to_vec();
    while solution.residuals.len() < most && share(norm(&rest), size) > tolerance {
        let before = solution.residuals.len();
        let mut krylov = Krylov::new(rest, tolerance * size);
        while krylov.is_to_go_on() && solution.residuals.len() < most {
            krylov.extend(system);
            solution.residuals.push(share(krylov.residual(), size));
        }
        krylov.add_best(&mut solution.irradiance);
        rest = left_over(system, first, &solution.irradiance);
        if solution.residuals.len() == before {
            break;
        }
    }
    // One bounce more: what rounding made negative is gone, and what remains tells how much is missing.
    let irradiance: Vec<_> = solution.irradiance.iter().zip(&rest).map(|(e, r)| (*e + *r).max(DVec3::ZERO)).collect();
    let next = system.product(&rest);
    solution.residuals.push(share(norm(&next), size));
    solution.lost = lost(&irradiance, &rest, &next);
    Solution { irradiance, ..solution }
}

/// b + K·E − E.
fn left_over(system: &System, first: &[DVec3], irradiance: &[DVec3]) -> Vec<DVec3> {
    let product = system.product(irradiance);
    first.iter().zip(product).zip(irradiance).map(|((b, ke), e)| b + ke - e).collect()
}

/// An orthonormal basis of r, (1 − K)·r, (1 − K)²·r …, and the least residual over it, by Givens rotations.
struct Krylov {
    basis: Vec<Vec<DVec3>>,
    /// Columns of the triangular factor.
    columns: Vec<Vec<DVec3>>,
    /// Cosine and sine of each rotation.
    turns: Vec<[DVec3; 2]>,
    right: Vec<DVec3>,
    enough: DVec3,
}

impl Krylov {
    fn new(rest: Vec<DVec3>, enough: DVec3) -> Self {
        let length = norm(&rest);
        let unit = rest.into_iter().map(|r| ratio(r, length)).collect();
        Self { basis: vec![unit], columns: Vec::new(), turns: Vec::new(), right: vec![length], enough }
    }

    fn residual(&self) -> DVec3 {
        self.right[self.columns.len()].abs()
    }

    fn is_to_go_on(&self) -> bool {
        self.columns.len() < KEPT && self.residual().cmpgt(self.enough).any()
    }

    fn extend(&mut self, system: &System) {
        let last = &self.basis[self.columns.len()];
        let product = system.product(last);
        let mut next: Vec<DVec3> = last.iter().zip(product).map(|(v, kv)| v - kv).collect();
        let mut column = Vec::new();
        for v in &self.basis {
            let along = dot(v, &next);
            next.iter_mut().zip(v).for_each(|(n, v)| *n -= along * v);
            column.push(along);
        }
        let length = norm(&next);
        next.iter_mut().for_each(|n| *n = ratio(*n, length));
        for (i, [c, s]) in self.turns.iter().enumerate() {
            (column[i], column[i + 1]) = (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
        }
        self.turn(column, length);
        self.basis.push(next);
    }

    /// Turns what lies below the diagonal of a new column to zero.
    fn turn(&mut self, mut column: Vec<DVec3>, below: DVec3) {
        let at = self.columns.len();
        let diagonal = (column[at] * column[at] + below * below).map(f64::sqrt);
        let (c, s) = (ratio(column[at], diagonal), ratio(below, diagonal));
        column[at] = diagonal;
        self.columns.push(column);
        self.turns.push([c, s]);
        let right = self.right[at];
        self.right[at] = c * right;
        self.right.push(-s * right);
    }

    /// Adds the combination of the basis with the least residual.
    fn add_best(&self, irradiance: &mut [DVec3]) {
        let count = self.columns.len();
        let mut factors = vec![DVec3::ZERO; count];
        for i in (0..count).rev() {
            let known: DVec3 = (i + 1..count).map(|j| self.columns[j][i] * factors[j]).sum();
            factors[i] = ratio(self.right[i] - known, self.columns[i][i]);
        }
        for (v, factor) in self.basis.iter().zip(factors) {
            irradiance.iter_mut().zip(v).for_each(|(e, v)| *e += factor * v);
        }
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> DVec3 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(values: &[DVec3]) -> DVec3 {
    dot(values, values).map(f64::sqrt)
}

/// Channel by channel; 0 where there is nothing to divide by.
fn ratio(a: DVec3, b: DVec3) -> DVec3 {
    let channel = |i: usize| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 };
    DVec3::new(channel(0), channel(1), channel(2))
}

fn share(a: DVec3, b: DVec3) -> f64 {
    ratio(a, b).max_element()
}

#[cfg(test)]
mod tests {
    use super::super::system::Entry;
    use super::*;
    use glam::Vec3;

    /// A chain of rooms: most of the light stays in its room, some goes to the next ones.
    fn chain(count: u32, rho: f32, through: f32) -> System {
        let row = |p: u32| {
            let neighbours = [p.checked_sub(1), (p + 1 < count).then_some(p + 1)];
            let outside = neighbours.iter().flatten().map(|n| (*n, through)).collect::<Vec<_>>();
            let inside = 1.0 - through * outside.len() as f32;
            let entry =
                |(place, share): &(u32, f32)| Entry { place: *place, factor: Vec3::new(rho, 0.5, 0.0) * *share };
            outside.iter().chain([&(p, inside)]).map(entry).collect()
        };
        System::new(&(0..count).map(row).collect::<Vec<_>>())
    }

    fn one_lamp(count: u32) -> Vec<DVec3> {
        let mut first = vec![DVec3::ZERO; count as usize];
        first[0] = DVec3::new(1.0, 2.0, 0.0);
        first
    }

    /// A furnace: E = b/(1 − ρ), after n bounces (1 − ρⁿ)/(1 − ρ).
    #[test]
    fn bounces_in_a_furnace_are_a_geometric_series() {
        for rho in [0.1_f32, 0.5, 0.9, 0.99] {
            let system = chain(6, rho, 0.2);
            let first = [DVec3::X; 6];
            let q = f64::from(rho);
            for bounces in [1_u32, 2, 7] {
                let sum = partial_sum(&system, &first, bounces);
                let expected = (1.0 - q.powi(bounces as i32)) / (1.0 - q);
                assert!(sum.irradiance.iter().all(|e| (e.x / expected - 1.0).abs() < 1e-6), "{rho} {bounces}");
                let rest = q.powi(bounces as i32);
                assert!((sum.lost / rest - 1.0).abs() < 1e-4, "{} of {rest}", sum.lost);
            }
            for solver in [Solver::Plain, Solver::Accelerated] {
                let all = solve(&system, &first, solver, 1e-6, 5000);
                assert!(all.irradiance.iter().all(|e| (e.x * (1.0 - q) - 1.0).abs() < 1e-3), "{rho} {solver:?}");
            }
        }
    }

    /// Ten rooms in a row, ρ = .99: both solvers agree, and the accelerated one takes far fewer products.
    #[test]
    fn acceleration_pays_where_light_stays() {
        let (system, first) = (chain(10, 0.99, 0.01), one_lamp(10));
        let [plain, fast] = [Solver::Plain, Solver::Accelerated].map(|s| solve(&system, &first, s, 1e-8, 10_000));
        let (slow, quick) = (plain.residuals.len(), fast.residuals.len());
        eprintln!("ten rooms: {slow} products plainly, {quick} accelerated");
        assert!(slow > 1000 && quick <= 15, "{slow} {quick}");
        for (a, b) in plain.irradiance.iter().zip(&fast.irradiance) {
            // A residual leaves an error of 1/(1 − ρ) times as much.
            assert!((*a - *b).abs().max_element() <= 100.0 * 1e-8, "{a} {b}");
            assert_eq!(b.z, 0.0);
        }
        assert!(plain.lost < 1e-5 && fast.lost < 1e-5);
    }

    /// What no light reaches stays exactly black.
    #[test]
    fn apart_rooms_stay_black() {
        let system = chain(4, 0.9, 0.0);
        for solver in [Solver::Plain, Solver::Accelerated] {
            let all = solve(&system, &one_lamp(4), solver, 1e-6, 1000);
            assert!(all.irradiance[0].x > 9.9 && all.irradiance[1..].iter().all(|e| *e == DVec3::ZERO));
        }
    }
}

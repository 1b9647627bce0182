//! Solves E = b + K·E, or sums as many of its bounces as are asked for.

use super::gmres;
use super::system::System;
use super::vectors::{norm, share, total};
use glam::DVec3;
use std::time::Instant;

/// How all bounces are summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Bounce after bounce (Jacobi): of albedo ρ it takes ln ε/ln ρ products.
    Plain,
    /// GMRES (Saad and Schultz 1986), each colour channel by itself: a product for each distinct large eigenvalue, about.
    #[default]
    Accelerated,
}

/// Where a sum stands after a product.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// ‖b + K·E − E‖/‖b‖ of the worst colour channel, over all places.
    pub residual: f64,
    /// Share of all light by reflection that is still missing: 1 − ΣE/ΣE of all bounces, over all places and channels.
    pub missing: f64,
    /// Milliseconds since the first product began.
    pub ms: f64,
}

/// Irradiance of all places, and how it came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// E of each place, W·m⁻².
    pub irradiance: Vec<DVec3>,
    /// One a product.
    pub steps: Vec<Step>,
    /// What the bounces left out would add, as a share of the whole: an estimate by the last bounces' ratio.
    pub lost: f64,
    /// Whether all bounces were asked for and the products did not suffice.
    pub is_unfinished: bool,
}

/// Least share of the tolerance that the residual is asked for.
const LEAST_SHARE: f64 = 1e-3;

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

/// All terms but a share of `tolerance` of the light, in `most` products at most.
///
/// An error e leaves the residual (1 − K)·e, which is no smaller than e times 1 − the largest sum of a row of K: the residual is
/// brought down to that share of the tolerance, a thousandth of it where albedos come close to 1.
pub fn solve(system: &System, first: &[DVec3], solver: Solver, tolerance: f64, most: usize) -> Solution {
    let enough = tolerance * (1.0 - system.largest_row()).max(LEAST_SHARE);
    let mut solution = match solver {
        Solver::Plain => {
            let mut sum = Sum::new(first);
            while sum.log.residual() > enough && sum.log.len() < most && sum.add(system) {}
            sum.finish(system)
        }
        Solver::Accelerated => gmres::solve(system, first, enough, most),
    };
    solution.is_unfinished = solution.steps.last().is_some_and(|step| step.residual > enough);
    solution
}

/// Remembers how far each product got.
pub(super) struct Log {
    begun: Instant,
    /// With the light that is there in place of what is missing, which the end tells.
    steps: Vec<Step>,
}

impl Log {
    pub(super) fn new() -> Self {
        Self { begun: Instant::now(), steps: Vec::new() }
    }

    /// After a product: the residual, and the sum of all irradiance so far.
    pub(super) fn add(&mut self, residual: f64, there: f64) {
        self.steps.push(Step { residual, missing: there, ms: self.begun.elapsed().as_secs_f64() * 1e3 });
    }

    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    fn residual(&self) -> f64 {
        self.steps.last().map_or(f64::INFINITY, |step| step.residual)
    }

    /// The solution, whose last bounce and the one after it are given.
    pub(super) fn finish(mut self, irradiance: Vec<DVec3>, last: &[DVec3], next: &[DVec3]) -> Solution {
        let lost = lost(&irradiance, last, next);
        let whole = total(&irradiance) / (1.0 - lost);
        for step in &mut self.steps {
            step.missing = if whole > 0.0 { 1.0 - step.missing / whole } else { 0.0 };
        }
        Solution { irradiance, steps: self.steps, lost, is_unfinished: false }
    }
}

/// A sum of bounces so far.
struct Sum<'a> {
    first: &'a [DVec3],
    irradiance: Vec<DVec3>,
    last: Vec<DVec3>,
    log: Log,
}

impl<'a> Sum<'a> {
    fn new(first: &'a [DVec3]) -> Self {
        Self { first, irradiance: first.to_vec(), last: first.to_vec(), log: Log::new() }
    }

    /// Adds one more bounce; whether there was light in it.
    fn add(&mut self, system: &System) -> bool {
        self.last = system.product(&self.last);
        self.irradiance.iter_mut().zip(&self.last).for_each(|(sum, bounce)| *sum += bounce);
        self.log.add(share(norm(&self.last), norm(self.first)), total(&self.irradiance));
        self.log.residual() > 0.0
    }

    fn finish(self, system: &System) -> Solution {
        let next = system.product(&self.last);
        self.log.finish(self.irradiance, &self.last, &next)
    }
}

/// What all bounces after `last` add, those after `next` as a geometric series (Aitken 1926), as a share of the whole.
fn lost(irradiance: &[DVec3], last: &[DVec3], next: &[DVec3]) -> f64 {
    let size = |values: &[DVec3]| values.iter().map(|v| v.abs().element_sum()).sum::<f64>();
    let (whole, last, next) = (size(irradiance), size(last), size(next));
    let ratio = if last > 0.0 { (next / last).clamp(0.0, 1.0 - 1e-6) } else { 0.0 };
    let rest = next / (1.0 - ratio);
    if whole > 0.0 { rest / (whole + rest) } else { 0.0 }
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
                // After the product of index i there are i + 2 bounces.
                for (i, step) in sum.steps.iter().enumerate() {
                    let rest = q.powi(i as i32 + 2);
                    assert!((step.missing / rest - 1.0).abs() < 1e-4, "{i}: {} of {rest}", step.missing);
                }
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
        let (slow, quick) = (plain.steps.len(), fast.steps.len());
        eprintln!("ten rooms: {slow} products plainly, {quick} accelerated");
        assert!(slow > 1000 && quick <= 15, "{slow} {quick}");
        for (a, b) in plain.irradiance.iter().zip(&fast.irradiance) {
            // A residual leaves an error of 1/(1 − ρ) times as much.
            assert!((*a - *b).abs().max_element() <= 100.0 * 1e-8, "{a} {b}");
            assert_eq!(b.z, 0.0);
        }
        assert!(plain.lost < 1e-5 && fast.lost < 1e-5);
        for steps in [&plain.steps, &fast.steps] {
            assert!(steps[0].missing > 0.5 && steps.last().unwrap().missing.abs() < 1e-5, "{steps:?}");
        }
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

//! GMRES (Saad and Schultz 1986): the least residual over the space that products with the residual span.

use super::solve::{Log, Solution};
use super::system::System;
use super::vectors::{dot, norm, ratio, share, total};
use glam::DVec3;

/// Directions that are kept before it starts anew.
const KEPT: usize = 40;

/// All terms to a residual of `tolerance` times the first bounce, from zero. Every scalar is one of each channel, for K mixes no channels.
pub(super) fn solve(system: &System, first: &[DVec3], tolerance: f64, most: usize) -> Solution {
    let size = norm(first);
    let mut irradiance = vec![DVec3::ZERO; first.len()];
    let (mut rest, mut log) = (first.to_vec(), Log::new());
    while log.len() < most && share(norm(&rest), size) > tolerance {
        let before = log.len();
        let whole = total(&irradiance);
        let mut krylov = Krylov::new(&rest, tolerance * size);
        while krylov.is_to_go_on() && log.len() < most {
            krylov.extend(system);
            log.add(share(krylov.residual(), size), whole + krylov.total());
        }
        krylov.add_best(&mut irradiance);
        if log.len() == before {
            break;
        }
        rest = left_over(system, first, &irradiance);
        log.add(share(norm(&rest), size), total(&irradiance));
    }
    // One bounce more: what rounding made negative is gone, and what remains tells how much is missing.
    irradiance.iter_mut().zip(&rest).for_each(|(e, r)| *e = (*e + *r).max(DVec3::ZERO));
    let next = system.product(&rest);
    log.add(share(norm(&next), size), total(&irradiance));
    log.finish(irradiance, &rest, &next)
}

/// b + K·E − E.
fn left_over(system: &System, first: &[DVec3], irradiance: &[DVec3]) -> Vec<DVec3> {
    let product = system.product(irradiance);
    first.iter().zip(product).zip(irradiance).map(|((b, ke), e)| b + ke - e).collect()
}

/// An orthonormal basis of r, (1 − K)·r, (1 − K)²·r …, and the least residual over it, by Givens rotations.
struct Krylov {
    basis: Vec<Vec<DVec3>>,
    /// Sum of the entries of each.
    totals: Vec<DVec3>,
    /// Columns of the triangular factor.
    columns: Vec<Vec<DVec3>>,
    /// Cosine and sine of each rotation.
    turns: Vec<[DVec3; 2]>,
    right: Vec<DVec3>,
    enough: DVec3,
}

impl Krylov {
    fn new(rest: &[DVec3], enough: DVec3) -> Self {
        let length = norm(rest);
        let unit: Vec<DVec3> = rest.iter().map(|r| ratio(*r, length)).collect();
        let totals = vec![unit.iter().sum()];
        Self { basis: vec![unit], totals, columns: Vec::new(), turns: Vec::new(), right: vec![length], enough }
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
        self.totals.push(next.iter().sum());
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

    /// Factors of the basis with the least residual.
    fn best(&self) -> Vec<DVec3> {
        let count = self.columns.len();
        let mut factors = vec![DVec3::ZERO; count];
        for i in (0..count).rev() {
            let known: DVec3 = (i + 1..count).map(|j| self.columns[j][i] * factors[j]).sum();
            factors[i] = ratio(self.right[i] - known, self.columns[i][i]);
        }
        factors
    }

    /// What the combination with the least residual sums to.
    fn total(&self) -> f64 {
        self.best().iter().zip(&self.totals).map(|(factor, sum)| (factor * sum).element_sum()).sum()
    }

    /// Adds the combination with the least residual.
    fn add_best(&self, irradiance: &mut [DVec3]) {
        for (v, factor) in self.basis.iter().zip(self.best()) {
            irradiance.iter_mut().zip(v).for_each(|(e, v)| *e += factor * v);
        }
    }
}

//! All bounces where light goes on for long: closed forms, traced paths, and what acceleration brings.

use crate::common::gpu;
use hemicube::methods::surface_cache::Solver::{self, Accelerated, Plain};
use hemicube::report::solvers::{Case, Row, checkerboard, needle, run, sphere};

/// Rows of the solvers, each region within `most` of what it should be; the products of each.
fn solve(case: &Case, solvers: &[Solver], most: f64) -> Vec<usize> {
    let device = gpu();
    let before = device.instance.validation_messages();
    let rows = run(&device, case, solvers).unwrap();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages");
    for row in &rows {
        eprintln!("{}", row.words());
        assert!(!row.bounced.is_unfinished && !row.bounced.is_cut, "{}", row.words());
        assert!(row.errors.iter().all(|(_, off)| off.abs() <= most), "{}", row.words());
    }
    let products = |row: &Row| row.bounced.steps.len();
    rows.iter().map(products).collect()
}

#[test]
fn spheres_of_every_albedo() {
    for (rho, most) in [(0.1, 0.01), (0.5, 0.01), (0.9, 0.01), (0.95, 0.01), (0.99, 0.02), (0.999, 0.03)] {
        let products = solve(&sphere(rho), &[Accelerated], most);
        assert!(products[0] <= 10, "{products:?} at {rho}");
    }
}

#[test]
fn black_and_white_in_turns() {
    solve(&checkerboard(), &[Plain, Accelerated], 0.02);
}

/// The cone lights a spot that is smaller than a texel of most captures: places see it by chance, some 300 times in all.
#[test]
fn a_needle_of_light_in_a_white_box() {
    solve(&needle(), &[Accelerated], 0.1);
}

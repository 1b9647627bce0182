//! Rows of solvers as tables and charts.

use crate::methods::surface_cache::{Bounced, Solver, Step};
use crate::report::csv as csv_file;
use crate::report::svg::{Chart, Dot, Series};

/// A case by one solver.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the case.
    pub case: String,
    /// The solver.
    pub solver: Solver,
    /// Of each region, how far its mean irradiance is off, as a share of what it should be.
    pub errors: Vec<(&'static str, f64)>,
    /// What was done.
    pub bounced: Bounced,
}

impl Row {
    /// The last product.
    pub fn last(&self) -> Step {
        self.bounced.steps.last().copied().unwrap_or_default()
    }

    fn solver(&self) -> &'static str {
        match self.solver {
            Solver::Plain => "plain",
            Solver::Accelerated => "accelerated",
        }
    }

    fn errors(&self) -> String {
        let one = |(name, off): &(&str, f64)| format!("{name} {:+.2} %", 100.0 * off);
        self.errors.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    /// In a line.
    pub fn words(&self) -> String {
        let Step { residual, ms, .. } = self.last();
        let (case, solver, products) = (&self.case, self.solver(), self.bounced.steps.len());
        format!("{case}, {solver}: {products} products, {ms:.0} ms, residual {residual:.1e}; {}", self.errors())
    }
}

/// As Markdown: a line a case, plain beside accelerated.
pub fn markdown(rows: &[Row], device: &str) -> String {
    let mut text = format!(
        "On {device}.\n\n| case | places | plain: products | solve | residual | accelerated: products | solve | residual | off by |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|---|\n"
    );
    for pair in rows.chunks(2) {
        let one = |row: &Row| {
            let Step { residual, ms, .. } = row.last();
            format!("{} | {ms:.0} ms | {residual:.0e}", row.bounced.steps.len())
        };
        let columns: Vec<_> = pair.iter().map(one).collect();
        let (first, errors) = (&pair[0], pair.last().map(Row::errors).unwrap_or_default());
        text += &format!("| {} | {} | {} | {errors} |\n", first.case, first.bounced.places, columns.join(" | "));
    }
    text
}

/// Every product of every row.
pub fn csv(rows: &[Row], device: &str) -> String {
    let columns = ["device", "case", "solver", "places", "product", "ms", "residual", "missing"];
    let of_row = |row: &Row| {
        let line = |(index, step): (usize, &Step)| {
            let values = [
                device.to_owned(),
                row.case.clone(),
                row.solver().to_owned(),
                row.bounced.places.to_string(),
                (index + 1).to_string(),
                format!("{:.3}", step.ms),
                format!("{:e}", step.residual),
                format!("{:e}", step.missing),
            ];
            columns.map(str::to_owned).into_iter().zip(values).collect()
        };
        row.bounced.steps.iter().enumerate().map(line).collect::<Vec<csv_file::Row>>()
    };
    csv_file::write(&columns, &rows.iter().flat_map(of_row).collect::<Vec<_>>())
}

/// Light that is missing against products, and against time.
pub fn charts(rows: &[Row]) -> [Chart; 2] {
    let chart = |x: &str, at: fn(usize, &Step) -> f64| Chart {
        title: "Light that is missing".into(),
        subtitle: "bounces summed one by one (plain) and by GMRES (accelerated)".into(),
        x: x.into(),
        y: "share of all light by reflection".into(),
        series: rows.iter().map(|row| series(row, at)).collect(),
        levels: Vec::new(),
    };
    [chart("products", |index, _| (index + 1) as f64), chart("milliseconds of the solver", |_, step| step.ms)]
}

fn series(row: &Row, at: fn(usize, &Step) -> f64) -> Series {
    let shown = |(_, step): &(usize, &Step)| step.missing.abs() > 1e-8 && step.ms > 0.0;
    let steps = row.bounced.steps.iter().enumerate().filter(shown);
    let line: Vec<_> = steps.map(|(index, step)| (at(index, step), step.missing.abs())).collect();
    let name = format!("{}, {}", row.case, row.solver());
    let dot = |at: &(f64, f64)| Dot { at: *at, text: name.clone(), ringed: false, spread: 0.0 };
    // Lines of thousands of products would be all dots.
    let dots = line.iter().step_by(line.len().div_ceil(24).max(1)).map(dot).collect();
    Series { name, dots, line }
}

//! Rows of the suite's table.

use crate::report::csv;
use std::collections::BTreeMap;

/// What an error may be at N texels a side: `factor` · (2/N)^`order` + `floor`, 2/N being a texel's width at distance 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Error at a texel as wide as its distance.
    pub factor: f64,
    /// Power of the texel's width; 0 for what texels have no part in.
    pub order: f64,
    /// How exactly the expected value itself is known.
    pub floor: f64,
}

/// One quantity of one case.
#[derive(Clone, Debug)]
pub struct Row {
    /// Kind of capture; empty until the suite names it.
    pub capture: &'static str,
    /// What is looked at, and from where.
    pub case: String,
    /// What is measured.
    pub quantity: String,
    /// What it should be.
    pub expected: f64,
    /// What it is at the finest capture, a mean over turns.
    pub got: f64,
    /// Root mean square error over turns relative to the row's scale, by capture size.
    pub errors: Vec<(u32, f64)>,
    /// What these may be.
    pub bound: Bound,
}

impl Bound {
    /// The same at all sizes.
    pub const fn flat(factor: f64) -> Self {
        Self { factor, order: 0.0, floor: 0.0 }
    }

    /// Proportional to a texel's width.
    pub const fn linear(factor: f64) -> Self {
        Self { factor, order: 1.0, floor: 0.0 }
    }

    /// The same where the expected value is known within `floor` only.
    pub const fn and(self, floor: f64) -> Self {
        Self { floor, ..self }
    }

    /// The bound at `size` texels a side.
    pub fn at(&self, size: u32) -> f64 {
        self.factor * (2.0 / f64::from(size)).powf(self.order) + self.floor
    }
}

impl Row {
    /// A row of one number at one capture size: its error is relative to `scale`.
    pub fn single(case: &str, quantity: &str, [expected, got, scale]: [f64; 3], size: u32, tolerance: f64) -> Self {
        let errors = vec![(size, (got - expected).abs() / scale)];
        let bound = Bound::flat(tolerance);
        Self { capture: "", case: case.into(), quantity: quantity.into(), expected, got, errors, bound }
    }

    /// A row that counts what must not be.
    pub fn none_of(case: &str, quantity: &str, count: usize, size: u32) -> Self {
        Self::single(case, quantity, [0.0, count as f64, 1.0], size, 0.0)
    }

    /// Error at the finest capture.
    pub fn error(&self) -> f64 {
        self.errors.last().map_or(0.0, |(_, error)| *error)
    }

    /// What it may be.
    pub fn tolerance(&self) -> f64 {
        self.errors.last().map_or(0.0, |(size, _)| self.bound.at(*size))
    }

    /// Whether the errors of all sizes are within their bounds; what is not a number is not.
    pub fn holds(&self) -> bool {
        self.errors.iter().all(|(size, error)| *error <= self.bound.at(*size))
    }

    /// Order of convergence from the coarsest capture to the finest, where texels have a part in the error.
    pub fn order(&self) -> Option<f64> {
        let ((coarse, from), (fine, to)) = (self.errors.first()?, self.errors.last()?);
        let measured = fine > coarse && self.bound.order > 0.0 && *to > 0.0 && *from > 0.0;
        measured.then(|| (from / to).log2() / (f64::from(*fine) / f64::from(*coarse)).log2())
    }

    fn fields(&self) -> Vec<(&'static str, String)> {
        let errors = self.errors.iter().map(|(size, error)| format!("{size}: {error:.2e}")).collect::<Vec<_>>();
        vec![
            ("capture", self.capture.into()),
            ("case", self.case.clone()),
            ("quantity", self.quantity.clone()),
            ("expected", number(self.expected)),
            ("got", number(self.got)),
            ("error", format!("{:.2e}", self.error())),
            ("tolerance", format!("{:.2e}", self.tolerance())),
            ("holds", if self.holds() { "yes" } else { "NO" }.into()),
            ("order", self.order().map_or_else(String::new, |order| format!("{order:.2}"))),
            ("bound's order", format!("{}", self.bound.order)),
            ("error by capture size", errors.join("; ")),
        ]
    }
}

fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if plain { format!("{value:.6}") } else { format!("{value:.5e}") }
}

/// The rows as comma-separated values, each with the device that measured it.
pub fn csv(rows: &[Row], device: &str) -> String {
    let columns: Vec<&str> = rows.first().map_or_else(Vec::new, |row| row.fields().iter().map(|f| f.0).collect());
    let columns = [columns, vec!["device"]].concat();
    let table: Vec<csv::Row> = rows
        .iter()
        .map(|row| {
            let mut fields: BTreeMap<_, _> = row.fields().into_iter().map(|(name, text)| (name.into(), text)).collect();
            fields.insert("device".into(), device.into());
            fields
        })
        .collect();
    csv::write(&columns, &table)
}

/// The rows as a Markdown page.
pub fn markdown(rows: &[Row], device: &str) -> String {
    let failed = rows.iter().filter(|row| !row.holds()).count();
    let mut page = format!(
        "# Stability of records\n\n{device}: {} rows, {failed} out of bounds.\n\n\
         Errors are root mean squares over {} turns of the hemicube, relative to the expected value or the case's own \
         scale; the tolerance is that of the finest capture, the order that of the errors from the coarsest to the finest.\n\n",
        rows.len(),
        super::TURNS
    );
    for (index, row) in rows.iter().enumerate() {
        let fields = row.fields();
        let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
        if index == 0 {
            page += &line(fields.iter().map(|f| f.0).collect());
            page += &line(fields.iter().map(|_| "---").collect());
        }
        page += &line(fields.iter().map(|f| f.1.as_str()).collect());
    }
    page
}

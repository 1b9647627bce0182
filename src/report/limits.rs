//! What passes do in a second beside what the device does at most, on the pass's own terms: where a pass stands below its
//! roof (Williams, Waterman and Patterson 2009, "Roofline", with measured roofs instead of nominal ones).

use super::table::{Table, percent};
use serde::{Deserialize, Serialize};

/// One kind of work of one pass. A pass that does several kinds is bound by the one of the largest share.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Name of the pass.
    pub pass: String,
    /// What is counted: `texels`.
    pub unit: String,
    /// How many there were.
    pub count: u64,
    /// How many in a second of the pass.
    pub per_second: f64,
    /// How many the device does at most, in a second.
    pub limit: f64,
    /// The one over the other.
    pub share: f64,
}

impl Share {
    /// `count` in `ms` of a pass, on a device that does at most `limit` in a second; none without times.
    pub fn new(pass: &str, unit: &str, count: u64, ms: f64, limit: f64) -> Option<Self> {
        let per_second = count as f64 / (ms * 1e-3);
        let (pass, unit, share) = (pass.to_owned(), unit.to_owned(), per_second / limit);
        (ms > 0.0 && limit > 0.0).then_some(Self { pass, unit, count, per_second, limit, share })
    }
}

/// A row each.
pub(super) fn table(shares: &[Share]) -> Table {
    let mut table = Table::new(&["pass", "did, M", "M/s", "at most, M/s", "share", "of"]);
    let millions = |value: f64| format!("{:.4}", value * 1e-6);
    for s in shares {
        let figures = [millions(s.count as f64), millions(s.per_second), millions(s.limit), percent(s.share)];
        table.row([s.pass.clone()].into_iter().chain(figures).chain([s.unit.clone()]));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_limit() {
        let share = Share::new("integrate", "texels", 3_000_000, 500.0, 12e6).unwrap();
        assert_eq!((share.per_second, share.share), (6e6, 0.5));
        assert!(table(&[share]).to_string().contains("50.0 %"));
        assert!(Share::new("integrate", "texels", 1, 0.0, 1.0).is_none());
        assert!(Share::new("integrate", "texels", 1, 1.0, 0.0).is_none());
    }
}

//! Memory of the samples by order, with gradients and without: the table of Tatarchuk and Oat (2005).

use crate::math::octahedron;
use crate::math::sh;
use serde::Serialize;

/// Memory of one order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Order of the harmonics.
    pub order: u32,
    /// Floats of a sample's coefficients: three channels.
    pub floats_per_sample: usize,
    /// The same with their gradients.
    pub floats_per_sample_with_gradients: usize,
    /// Bytes of all samples.
    pub bytes: usize,
    /// The same with gradients.
    pub bytes_with_gradients: usize,
}

/// Floats of a sample's moments of the distance, which do not depend on the order.
pub const MOMENTS: usize = 2 * octahedron::CELLS;

/// Memory of `samples` at each order from 2 on, four bytes a float, the moments aside.
pub fn table(samples: usize) -> Vec<Row> {
    let row = |order| {
        let floats = 3 * sh::count(order);
        Row {
            order,
            floats_per_sample: floats,
            floats_per_sample_with_gradients: 4 * floats,
            bytes: 4 * floats * samples,
            bytes_with_gradients: 16 * floats * samples,
        }
    };
    (2..=sh::MAX_ORDER).map(row).collect()
}

/// Bytes as people read them.
pub fn plain_bytes(bytes: usize) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.2} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4,913 samples: 108 floats each at order 3 and about 2 MB with gradients; 432 and about 8.2 MB at order 6 by the paper, whose
    /// megabytes are 2²⁰ bytes.
    #[test]
    fn it_is_the_papers_table() {
        let rows = table(4913);
        let [third, sixth] = [3, 6].map(|order| rows.iter().find(|row| row.order == order).unwrap());
        assert_eq!((third.floats_per_sample, third.floats_per_sample_with_gradients), (27, 108));
        assert_eq!((sixth.floats_per_sample, sixth.floats_per_sample_with_gradients), (108, 432));
        let megabytes = |bytes: usize| bytes as f64 / f64::from(1 << 20);
        assert!((megabytes(third.bytes_with_gradients) - 2.0).abs() < 0.05);
        assert!((megabytes(sixth.bytes_with_gradients) - 8.2).abs() < 0.15);
    }
}

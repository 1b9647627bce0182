//! The pixels that each round of the cache looks at.

use crate::passes::find_uncovered::Lattice;

/// First lattice's distance between pixels.
const COARSEST: u32 = 32;

/// Lattices from coarse to fine: each level adds three between the pixels of those before it, each in four parts of every
/// second pixel of every second row. One at a time, so that each sees what the others covered: a zone that reaches the next
/// pixel of its lattice leaves that without a record, as if records were put one by one. Together they hold every pixel exactly
/// once.
pub fn lattices() -> Vec<Lattice> {
    let mut all = quarters(COARSEST, [COARSEST / 2; 2]);
    let (mut stride, mut base) = (COARSEST, COARSEST / 2);
    while stride > 1 {
        let half = stride / 2;
        for [dx, dy] in [[half, half], [half, 0], [0, half]] {
            all.extend(quarters(stride, [(base + dx) % stride, (base + dy) % stride]));
        }
        (stride, base) = (half, base % half.max(1));
    }
    all
}

/// Every `spacing`-th pixel of every `spacing`-th row, as four lattices of twice that.
fn quarters(spacing: u32, [x, y]: [u32; 2]) -> Vec<Lattice> {
    let quarter = |[dx, dy]: [u32; 2]| Lattice { stride: 2 * spacing, offset: [x + dx * spacing, y + dy * spacing] };
    [[0, 0], [1, 1], [1, 0], [0, 1]].map(quarter).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lattices_hold_every_pixel_once() {
        let mut seen = vec![0_u32; 96 * 70];
        for lattice in lattices() {
            for y in (lattice.offset[1]..70).step_by(lattice.stride as usize) {
                for x in (lattice.offset[0]..96).step_by(lattice.stride as usize) {
                    seen[(y * 96 + x) as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|n| *n == 1));
    }
}

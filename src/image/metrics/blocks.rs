//! Errors after averaging over blocks, in which noise cancels and bias stays.

use super::{BLOCK, Layer};

/// Mean absolute and root mean squared difference of the block averages, blocks weighted by their pixels in `used`.
pub fn errors(test: &Layer, reference: &Layer, width: usize, used: &[usize]) -> [f64; 2] {
    let columns = width.div_ceil(BLOCK);
    let block = |i: usize| (i / width / BLOCK) * columns + (i % width) / BLOCK;
    let count = used.iter().map(|&i| block(i) + 1).max().unwrap_or(0);
    let mut pixels = vec![0u32; count];
    for &i in used {
        pixels[block(i)] += 1;
    }
    let (mut absolute, mut squared) = (0.0, 0.0);
    for (t, r) in test.channels.iter().zip(&reference.channels) {
        let mut sums = vec![0.0f64; count];
        for &i in used {
            sums[block(i)] += f64::from(t[i]) - f64::from(r[i]);
        }
        for (sum, &pixels) in sums.iter().zip(&pixels).filter(|&(_, &pixels)| pixels > 0) {
            absolute += sum.abs();
            squared += sum * sum / f64::from(pixels);
        }
    }
    let values = (used.len() * test.channels.len()) as f64;
    [absolute / values, (squared / values).sqrt()]
}

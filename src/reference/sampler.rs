//! The random numbers of one path: an Owen-scrambled Sobol sequence (Burley 2020), four dimensions at a time.

/// Draws the numbers of path `index` of a stream. The same stream and index give the same numbers wherever they run.
#[derive(Debug, Clone, Copy)]
pub struct Sampler {
    index: u32,
    stream: u32,
    sets: u32,
}

impl Sampler {
    /// `index` stays below 2¹⁶. Streams of different seeds, pixels or batches are independent of each other, so that the
    /// spread between batches measures the error of their mean.
    pub fn new(seed: u64, pixel: u64, batch: u32, index: u32) -> Self {
        let stream = mix(mix(mix(seed) ^ pixel) ^ u64::from(batch));
        Self { index, stream: (stream >> 32) as u32, sets: 0 }
    }

    /// Four numbers in [0, 1), well spread over the indices of a stream; each call is a new, independent set.
    pub fn next4(&mut self) -> [f64; 4] {
        self.sets += 1;
        let seed = mix(u64::from(self.stream) << 32 | u64::from(self.sets)) as u32;
        sobol_burley::sample_4d(self.index, 0, seed).map(f64::from)
    }
}

/// A bijective hash of 64 bits (the finaliser of SplitMix64, Steele, Lea, Flood 2014).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_and_each_is_stratified() {
        let first = |batch| Sampler::new(1, 7, batch, 0).next4();
        assert_ne!(first(0), first(1));
        // 16 points of a (0, 2)-sequence: one in each cell of 4 × 4.
        let mut cells = [0; 16];
        for i in 0..16 {
            let [u, v, _, _] = Sampler::new(1, 7, 0, i).next4();
            cells[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
        }
        assert_eq!(cells, [1; 16]);
    }
}

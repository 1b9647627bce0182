//! Sums over batches of paths, pixel by pixel, and the standard errors that the spread between batches gives.

use super::path::Layers;
use glam::DVec3;

/// Mean irradiance and its standard error, by number of reflections (0, 1, 2, 3 and more) and for all reflected light.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// W·m⁻².
    pub mean: Layers,
    /// Standard error of `mean`, per layer and channel.
    pub stderr: Layers,
    /// Standard error of the sum of the layers with at least one reflection.
    pub stderr_indirect: DVec3,
}

impl Estimate {
    /// Irradiance after at least one reflection.
    pub fn indirect(&self) -> DVec3 {
        self.mean[1] + self.mean[2] + self.mean[3]
    }
}

/// Running sums of one pixel over batches of equal size.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    sum: Layers,
    squares: [DVec3; 5],
}

/// Numbers of [`Sums::to_array`].
pub const SUMS_LEN: usize = 27;

impl Sums {
    /// Adds the mean of a batch.
    pub fn add(&mut self, batch: &Layers) {
        for (i, layer) in batch.iter().enumerate() {
            self.sum[i] += *layer;
            self.squares[i] += layer * layer;
        }
        let indirect = batch[1] + batch[2] + batch[3];
        self.squares[4] += indirect * indirect;
    }

    /// Mean and standard error over `batches` batches. With one batch the error is not known and is infinite.
    pub fn estimate(&self, batches: u32) -> Estimate {
        let n = f64::from(batches);
        let mean = self.sum.map(|s| s / n);
        let error = |squares: DVec3, mean: DVec3| {
            if batches < 2 {
                return DVec3::INFINITY;
            }
            let variance = (squares / n - mean * mean).max(DVec3::ZERO) * (n / (n - 1.0));
            (variance / n).map(f64::sqrt)
        };
        let indirect = mean[1] + mean[2] + mean[3];
        Estimate {
            mean,
            stderr: std::array::from_fn(|i| error(self.squares[i], mean[i])),
            stderr_indirect: error(self.squares[4], indirect),
        }
    }

    /// All numbers in a fixed order, for a file.
    pub fn to_array(self) -> [f64; SUMS_LEN] {
        let mut out = [0.0; SUMS_LEN];
        for (to, from) in out.chunks_exact_mut(3).zip(self.sum.iter().chain(&self.squares)) {
            to.copy_from_slice(&from.to_array());
        }
        out
    }

    /// The reverse of [`Sums::to_array`].
    pub fn from_array(numbers: &[f64; SUMS_LEN]) -> Self {
        let at = |i: usize| DVec3::from_slice(&numbers[3 * i..]);
        Self { sum: std::array::from_fn(at), squares: std::array::from_fn(|i| at(4 + i)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_error_of_known_numbers() {
        let mut sums = Sums::default();
        for x in [1.0, 2.0, 3.0, 4.0] {
            sums.add(&[DVec3::splat(x), DVec3::X * x, DVec3::X, DVec3::ZERO]);
        }
        let estimate = sums.estimate(4);
        assert_eq!(estimate.mean[0], DVec3::splat(2.5));
        // Variance of 1, 2, 3, 4 is 5/3; of their mean 5/12.
        assert!((estimate.stderr[0].x - (5f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(estimate.indirect().x, 3.5);
        assert!((estimate.stderr_indirect.x - estimate.stderr[0].x).abs() < 1e-12);
        assert_eq!(Sums::from_array(&sums.to_array()), sums);
    }
}

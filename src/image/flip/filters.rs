//! Separable filters on planes of floats; the edge pixel repeats beyond the border.

use rayon::prelude::*;
use std::f32::consts::PI;

/// A filter's weights, an odd number of them around the middle.
pub type Kernel = Vec<f32>;

/// Filters that follow the eye's contrast sensitivity at `ppd` pixels per degree of visual angle
/// (Andersson et al. 2020, section 4.1, eq. 3 and table 1).
///
/// Each is a sum of Gaussians `a √(π/b) exp(−π² r²/b)`. A Gaussian of the radius is a product of one in x and one in
/// y, so a term is filtered by rows and columns; the blue-yellow channel has two terms, added afterwards.
pub struct Sensitivity {
    /// Achromatic (Y).
    pub y: Kernel,
    /// Red-green (Cx).
    pub cx: Kernel,
    /// Blue-yellow (Cz), two terms.
    pub cz: [Kernel; 2],
}

impl Sensitivity {
    /// The filters at `ppd` pixels per degree.
    pub fn new(ppd: f32) -> Self {
        const WIDEST: f32 = 0.04;
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
        // In one dimension a term carries the root of its factor, as the product over x and y carries it whole.
        let term = |a: f32, b: f32| -> Kernel {
            let factor = (a * (PI / b).sqrt()).sqrt();
            (-radius..=radius).map(|i| factor * (-PI * PI * (i as f32 / ppd).powi(2) / b).exp()).collect()
        };
        Self {
            y: normalised([term(1.0, 0.0047)])[0].clone(),
            cx: normalised([term(1.0, 0.0053)])[0].clone(),
            cz: normalised([term(34.1, 0.04), term(13.5, 0.025)]),
        }
    }
}

/// Scales all terms so that the filter in two dimensions, the sum of their squares, sums to 1.
fn normalised<const N: usize>(terms: [Kernel; N]) -> [Kernel; N] {
    let total: f32 = terms.iter().map(|term| term.iter().sum::<f32>().powi(2)).sum();
    let scale = 1.0 / total.sqrt();
    terms.map(|term| term.iter().map(|weight| weight * scale).collect())
}

/// Gaussian and its first two derivatives, for edges and points (section 4.2): each positive part sums to 1 and each
/// negative part to −1.
pub struct Features {
    /// The Gaussian.
    pub smooth: Kernel,
    /// Its first derivative.
    pub edge: Kernel,
    /// Its second derivative.
    pub point: Kernel,
}

impl Features {
    /// The filters at `ppd` pixels per degree; an edge is 0.082 degrees wide.
    pub fn new(ppd: f32) -> Self {
        const WIDTH: f32 = 0.082;
        let sigma = 0.5 * WIDTH * ppd;
        let radius = (3.0 * sigma).ceil() as i32;
        let sample = |shape: &dyn Fn(f32) -> f32| -> Kernel {
            let at = |i: i32| shape(i as f32) * (-(i * i) as f32 / (2.0 * sigma * sigma)).exp();
            balanced((-radius..=radius).map(at).collect())
        };
        Self { smooth: sample(&|_| 1.0), edge: sample(&|x| -x), point: sample(&|x| x * x / (sigma * sigma) - 1.0) }
    }
}

fn balanced(weights: Kernel) -> Kernel {
    let positive: f32 = weights.iter().filter(|&&weight| weight > 0.0).sum();
    let negative: f32 = -weights.iter().filter(|&&weight| weight < 0.0).sum::<f32>();
    weights.into_iter().map(|weight| weight / if weight > 0.0 { positive } else { negative.max(1e-30) }).collect()
}

/// Filters along the rows with `across`, then along the columns with `down`.
pub fn separable(plane: &[f32], width: usize, across: &[f32], down: &[f32]) -> Vec<f32> {
    columns(&rows(plane, width, across), width, down)
}

/// Filters each row.
pub fn rows(plane: &[f32], width: usize, kernel: &[f32]) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(out, row)| {
        let left = std::iter::repeat_n(row[0], radius);
        let right = std::iter::repeat_n(row[width - 1], radius);
        let padded: Vec<f32> = left.chain(row.iter().copied()).chain(right).collect();
        for (offset, weight) in kernel.iter().enumerate() {
            accumulate(out, &padded[offset..offset + width], *weight);
        }
    });
    out
}

/// Filters each column.
pub fn columns(plane: &[f32], width: usize, kernel: &[f32]) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let last = plane.len() / width - 1;
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (offset, weight) in kernel.iter().enumerate() {
            let from = (y + offset).saturating_sub(radius).min(last);
            accumulate(out, &plane[from * width..][..width], *weight);
        }
    });
    out
}

fn accumulate(out: &mut [f32], values: &[f32], weight: f32) {
    for (sum, value) in out.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensitivity_filters_keep_a_flat_picture() {
        let filters = Sensitivity::new(67.0);
        let flat = vec![3.0; 30 * 20];
        let y = separable(&flat, 30, &filters.y, &filters.y);
        let cz = filters.cz.each_ref().map(|term| separable(&flat, 30, term, term));
        assert!(y.iter().all(|value| (value - 3.0).abs() < 1e-4));
        assert!((0..flat.len()).all(|i| (cz[0][i] + cz[1][i] - 3.0).abs() < 1e-4));
    }

    #[test]
    fn features_answer_to_what_they_are_for() {
        let filters = Features::new(67.0);
        let width = 41;
        let step: Vec<f32> = (0..width * 5).map(|i| if i % width >= 20 { 1.0 } else { 0.0 }).collect();
        let edge = separable(&step, width, &filters.edge, &filters.smooth);
        assert!(edge[width * 2 + 20].abs() > 0.8 && edge[width * 2 + 3].abs() < 1e-6);
        let upright = separable(&step, width, &filters.smooth, &filters.edge);
        assert!(upright.iter().all(|value| value.abs() < 1e-5));
    }
}

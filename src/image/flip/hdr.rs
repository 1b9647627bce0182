//! HDR-FLIP: the largest FLIP over a range of exposures (Andersson et al. 2021).

use super::{DEFAULT_PPD, Planes, flip};
use crate::image::tone::{luminance, srgb_encode};

/// HDR-FLIP of two pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct HdrFlip {
    /// Error at each pixel, 0 to 1.
    pub map: Vec<f32>,
    /// Shortest exposure looked at, in stops.
    pub start: f32,
    /// Longest exposure looked at, in stops.
    pub stop: f32,
    /// Number of exposures from the first to the last, evenly spaced.
    pub exposures: usize,
}

impl HdrFlip {
    /// Mean over the pixels that `mask` keeps, the number the paper recommends.
    pub fn mean(&self, mask: Option<&[bool]>) -> f64 {
        let kept = |i: &usize| mask.is_none_or(|mask| mask[*i]);
        let (sum, count) = (0..self.map.len())
            .filter(kept)
            .fold((0.0, 0), |(sum, count), i| (sum + f64::from(self.map[i]), count + 1));
        if count == 0 { 0.0 } else { sum / f64::from(count) }
    }
}

/// HDR-FLIP of linear Rec.709 radiance. Exposures follow from the reference alone; negative radiance counts as none.
pub fn hdr_flip(reference: Planes, test: Planes, width: usize) -> HdrFlip {
    let (start, stop, exposures) = exposure_range(reference);
    let step = (stop - start) / (exposures - 1).max(1) as f32;
    let mut map = vec![0.0f32; reference[0].len()];
    for index in 0..exposures {
        let stops = start + index as f32 * step;
        let [a, b] = [reference, test].map(|planes| planes.map(|plane| expose(plane, stops)));
        let error = flip(a.each_ref().map(|p| &p[..]), b.each_ref().map(|p| &p[..]), width, DEFAULT_PPD);
        for (largest, error) in map.iter_mut().zip(error) {
            *largest = largest.max(error);
        }
    }
    HdrFlip { map, start, stop, exposures }
}

/// Coefficients of the paper's default tone map (Narkowicz 2016, a fit of ACES; the pre-exposure of 0.6 is within):
/// `(k₀x² + k₁x + k₂) / (k₃x² + k₄x + k₅)`.
const ACES: [f32; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

fn tone_map(x: f32) -> f32 {
    let [k0, k1, k2, k3, k4, k5] = ACES;
    // Far above white the quotient has reached its limit; larger values would overflow.
    let x = x.clamp(0.0, 1e9);
    (((k0 * x + k1) * x + k2) / ((k3 * x + k4) * x + k5)).clamp(0.0, 1.0)
}

/// sRGB code values of a plane after exposure and tone map.
fn expose(plane: &[f32], stops: f32) -> Vec<f32> {
    let scale = stops.exp2();
    plane.iter().map(|value| srgb_encode(tone_map(value * scale))).collect()
}

/// First and last exposure in stops and their number (section 3): the brightest, and the median, pixel of the
/// reference comes out at 0.85 of the tone map's range.
fn exposure_range(reference: Planes) -> (f32, f32, usize) {
    let [r, g, b] = reference;
    let mut luminances: Vec<f32> = (0..r.len()).map(|i| luminance([r[i], g[i], b[i]])).filter(|y| *y > 0.0).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    let Some(&brightest) = luminances.last() else { return (0.0, 0.0, 1) };
    // The paper takes the median of all pixels, for which black has no exposure; it is met where fewer than half are.
    let black = r.len() - luminances.len();
    let middle = (r.len() / 2).checked_sub(black).unwrap_or(luminances.len() / 2);
    let bright = solve_tone_map(0.85);
    let (start, stop) = ((bright / brightest).log2(), (bright / luminances[middle]).log2());
    (start, stop, ((stop - start).ceil() as usize).max(2))
}

/// The x ≥ 0 at which the tone map has the value `t`: the quadratic `(k₀ − t k₃)x² + (k₁ − t k₄)x + k₂ − t k₅ = 0`.
fn solve_tone_map(t: f32) -> f32 {
    let [k0, k1, k2, k3, k4, k5] = ACES;
    let half = 0.5 * (k1 - t * k4) / (k0 - t * k3);
    let rest = (k2 - t * k5) / (k0 - t * k3);
    -half + (half * half - rest).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::tests::oracle;
    use super::*;

    /// Radiance over nine stops with an edge, as planes.
    fn radiance(width: usize, height: usize, scale: f32) -> [Vec<f32>; 3] {
        let value = |i: usize, tint: f32| {
            let (x, y) = ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
            let edge = if (x - 0.5).hypot(y - 0.4) < 0.2 { 6.0 } else { 1.0 };
            scale * edge * tint * (9.0 * x - 6.0).exp2()
        };
        [1.0, 0.8, 0.5].map(|tint| (0..width * height).map(|i| value(i, tint)).collect())
    }

    fn views(planes: &[Vec<f32>; 3]) -> Planes<'_> {
        planes.each_ref().map(|plane| &plane[..])
    }

    #[test]
    fn tone_map_is_solved() {
        assert!((tone_map(solve_tone_map(0.85)) - 0.85).abs() < 1e-5);
        assert_eq!(tone_map(f32::INFINITY), 1.0);
    }

    #[test]
    fn exposures_follow_the_brightest_and_the_median() {
        // tools/metrics_oracle.py prints these.
        let plane: Vec<f32> = (1..=101).map(|i| 0.02 * i as f32 * i as f32).collect();
        let (start, stop, exposures) = exposure_range([&plane; 3]);
        assert!((start + 6.589_27).abs() < 1e-4 && (stop + 4.617_698).abs() < 1e-4, "{start} {stop}");
        assert_eq!(exposures, 2);
    }

    #[test]
    fn agrees_with_nvidias_program_at_each_exposure() {
        let (width, height) = (64, 40);
        let (a, mut b) = (radiance(width, height, 1.0), radiance(width, height, 1.08));
        b[1][700..720].fill(40.0);
        let ours = hdr_flip(views(&a), views(&b), width);
        let step = (ours.stop - ours.start) / (ours.exposures - 1) as f32;
        let codes = |planes: &[Vec<f32>; 3], stops: f32| -> Vec<u8> {
            let planes = planes.each_ref().map(|plane| expose(plane, stops));
            let code = |value: f32| (value * 255.0 + 0.5) as u8;
            (0..width * height).flat_map(|i| [0, 1, 2].map(|k| code(planes[k][i]))).collect()
        };
        let mut theirs = vec![0.0f32; width * height];
        for index in 0..ours.exposures {
            let stops = ours.start + index as f32 * step;
            let error = oracle(&codes(&a, stops), &codes(&b, stops), width);
            theirs.iter_mut().zip(error).for_each(|(largest, error)| *largest = largest.max(error));
        }
        // The oracle sees 8-bit codes, which is worth about a thousandth here.
        let mean = theirs.iter().map(|error| f64::from(*error)).sum::<f64>() / theirs.len() as f64;
        assert!((ours.mean(None) - mean).abs() < 1.5e-3, "{} {mean}", ours.mean(None));
        assert!(mean > 0.1);
    }

    #[test]
    fn same_pictures_and_black_ones_have_no_error() {
        let a = radiance(20, 10, 1.0);
        assert_eq!(hdr_flip(views(&a), views(&a), 20).mean(None), 0.0);
        let black = vec![0.0; 50];
        assert_eq!(hdr_flip([&black; 3], [&black; 3], 10).mean(None), 0.0);
    }
}

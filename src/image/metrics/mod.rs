//! How far a picture is from its reference, layer by layer, in linear floats.
//!
//! Definitions, for channels c of pixels p that the mask keeps, test t, reference r, and m the mean of |r| over both:
//! - `mae` = mean |t − r| / m; `rms` = √mean (t − r)² / m;
//! - `relmse` = mean (t − r)² / (r² + ε): relative mean squared error as in Rousselle et al. 2011 ("Adaptive Sampling
//!   and Reconstruction using Greedy Error Minimization", section 3), with ε = 0.01 m², so that the result does not
//!   depend on the unit;
//! - a pixel's relative error is Σ_c |t − r| / (Σ_c |r| + 0.01 n m) with n channels; `p95`, `p99` and `max` are over
//!   pixels, percentiles interpolated linearly;
//! - `energy` = Σ t / Σ r.
//!
//! Pixels with NaN or infinite values are counted and left out of the rest.

mod blocks;
#[cfg(test)]
mod tests;

use super::flip::hdr_flip;
use super::{Kind, Layer, Picture};
use serde::Serialize;

/// Size of the blocks of the block-averaged errors, pixels.
pub const BLOCK: usize = 4;

/// Share of the mean that is added where a pixel's value divides, so that black pixels do not decide everything.
const FLOOR: f64 = 0.01;

/// Errors of one layer; see the module for the definitions.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Metrics {
    /// Pixels compared: within the mask and finite in both pictures.
    pub pixels: usize,
    /// Pixels of the test within the mask that hold NaN or an infinite value.
    pub non_finite_test: usize,
    /// The same of the reference.
    pub non_finite_reference: usize,
    /// Mean of |reference|, in the layer's unit.
    pub mean_reference: f64,
    /// Mean absolute error over the reference's mean.
    pub mae: f64,
    /// Root of the mean squared error over the reference's mean.
    pub rms: f64,
    /// Relative mean squared error.
    pub relmse: f64,
    /// 95th percentile of the pixels' relative error.
    pub p95: f64,
    /// 99th percentile of the pixels' relative error.
    pub p99: f64,
    /// Largest relative error of a pixel.
    pub max: f64,
    /// Sum of the test over the sum of the reference; none for vectors.
    pub energy: Option<f64>,
    /// `mae` after averaging over blocks of 4 × 4 pixels: what is left when noise is taken out.
    pub block_mae: f64,
    /// `rms` after averaging over blocks of 4 × 4 pixels.
    pub block_rms: f64,
    /// Mean of HDR-FLIP, 0 to 1; none unless asked for, and for layers that are no colour.
    pub flip: Option<f64>,
}

/// Which pixels count, from a mask channel: those above one half.
pub fn mask(channel: &[f32]) -> Vec<bool> {
    channel.iter().map(|value| *value > 0.5).collect()
}

/// Errors of a layer of the test against the same layer of the reference, both `width` pixels wide.
///
/// The layers must have the same channels and sizes.
pub fn measure(test: &Layer, reference: &Layer, width: usize, mask: Option<&[bool]>) -> Metrics {
    let finite = |layer: &Layer, i: usize| layer.channels.iter().all(|channel| channel[i].is_finite());
    let pixels = reference.channels.first().map_or(0, |channel| channel.len());
    let within: Vec<usize> = (0..pixels).filter(|&i| mask.is_none_or(|mask| mask[i])).collect();
    let used: Vec<usize> = within.iter().copied().filter(|&i| finite(test, i) && finite(reference, i)).collect();
    let mut metrics = Metrics {
        pixels: used.len(),
        non_finite_test: within.iter().filter(|&&i| !finite(test, i)).count(),
        non_finite_reference: within.iter().filter(|&&i| !finite(reference, i)).count(),
        energy: (reference.kind != Kind::Vector).then_some(1.0),
        ..Metrics::default()
    };
    if used.is_empty() {
        return metrics;
    }
    means(&mut metrics, test, reference, &used);
    let relative = relative_errors(test, reference, &used, metrics.mean_reference);
    tail(&mut metrics, &relative);
    [metrics.block_mae, metrics.block_rms] =
        blocks::errors(test, reference, width, &used).map(|error| over(error, metrics.mean_reference));
    metrics
}

/// Mean HDR-FLIP of a colour layer; what the mask leaves out, and what is not finite, is black in both.
pub fn measure_flip(test: &Layer, reference: &Layer, width: usize, mask: Option<&[bool]>) -> Option<f64> {
    let ([t0, t1, t2], [r0, r1, r2]) = (&test.channels[..], &reference.channels[..]) else { return None };
    let (t, r) = ([t0, t1, t2], [r0, r1, r2]);
    let kept = |i: usize| mask.is_none_or(|mask| mask[i]) && (0..3).all(|k| t[k][i].is_finite() && r[k][i].is_finite());
    let kept: Vec<bool> = (0..t0.len()).map(kept).collect();
    let cut = |plane: &&[f32]| -> Vec<f32> {
        plane.iter().zip(&kept).map(|(v, &keep)| if keep { *v } else { 0.0 }).collect()
    };
    let (t, r) = (t.map(cut), r.map(cut));
    let is_colour = test.kind == Kind::Colour && reference.kind == Kind::Colour;
    let error = || hdr_flip(r.each_ref().map(|p| &p[..]), t.each_ref().map(|p| &p[..]), width).mean(Some(&kept));
    is_colour.then(error)
}

fn means(metrics: &mut Metrics, test: &Layer, reference: &Layer, used: &[usize]) {
    let count = (used.len() * reference.channels.len()) as f64;
    let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
        let planes = test.channels.iter().zip(&reference.channels);
        planes.map(|(t, r)| used.iter().map(|&i| term(f64::from(t[i]), f64::from(r[i]))).sum::<f64>()).sum()
    };
    let mean = sum(&|_, r| r.abs()) / count;
    let epsilon = FLOOR * mean * mean;
    metrics.mean_reference = mean;
    metrics.mae = over(sum(&|t, r| (t - r).abs()) / count, mean);
    metrics.rms = over((sum(&|t, r| (t - r).powi(2)) / count).sqrt(), mean);
    metrics.relmse = sum(&|t, r| over((t - r).powi(2), r * r + epsilon)) / count;
    metrics.energy = metrics.energy.map(|_| match (sum(&|t, _| t), sum(&|_, r| r)) {
        (0.0, 0.0) => 1.0,
        (t, r) => t / r,
    });
}

/// A quotient in which nothing over nothing is no error.
fn over(error: f64, mean: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / mean }
}

fn relative_errors(test: &Layer, reference: &Layer, used: &[usize], mean: f64) -> Vec<f64> {
    let floor = FLOOR * mean * reference.channels.len() as f64;
    let pixel = |&i: &usize| {
        let planes = test.channels.iter().zip(&reference.channels);
        let (error, size) = planes.fold((0.0, 0.0), |(error, size), (t, r)| {
            (error + (f64::from(t[i]) - f64::from(r[i])).abs(), size + f64::from(r[i]).abs())
        });
        over(error, size + floor)
    };
    used.iter().map(pixel).collect()
}

fn tail(metrics: &mut Metrics, errors: &[f64]) {
    let mut sorted = errors.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    metrics.p95 = percentile(&sorted, 0.95);
    metrics.p99 = percentile(&sorted, 0.99);
    metrics.max = sorted[sorted.len() - 1];
}

/// Value below which the share `p` of the sorted values lies, interpolated linearly.
pub fn percentile(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = p * last as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    if low == high { low } else { low + (high - low) * place.fract() }
}

/// Relative error of each pixel for a difference picture: 0 outside the mask, NaN where either picture is not finite.
pub fn difference_map(test: &Layer, reference: &Layer, mask: Option<&[bool]>, mean: f64) -> Vec<f32> {
    let all: Vec<usize> = (0..reference.channels[0].len()).collect();
    let errors = relative_errors(test, reference, &all, mean);
    let kept = |i: usize| mask.is_none_or(|mask| mask[i]);
    let finite = |layer: &Layer, i: usize| layer.channels.iter().all(|channel| channel[i].is_finite());
    let value = |(i, error): (usize, f64)| match (kept(i), finite(test, i) && finite(reference, i)) {
        (false, _) => 0.0,
        (true, false) => f32::NAN,
        (true, true) => error as f32,
    };
    errors.into_iter().enumerate().map(value).collect()
}

/// Layers that both pictures have with the same channels, by name.
pub fn common_layers<'a>(test: &'a Picture, reference: &Picture) -> Vec<&'a str> {
    let kind = |picture: &Picture, name: &str| picture.layer(name).map(|layer| layer.kind);
    let same = |name: &&str| kind(test, name).is_some() && kind(test, name) == kind(reference, name);
    test.layers().into_iter().filter(same).collect()
}

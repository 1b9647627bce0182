//! Windows against negative irradiance: a few harmonics of a narrow light overshoot, and fall below 0 opposite to it.

use super::sh::{self, sphere_rule};
use glam::DVec3;

/// No window is stronger: degree 1 is left a millionth.
const STRONGEST: f64 = 2.5e5;

/// The coefficients with degree l divided by 1 + λ l²(l + 1)²: the function with the least sum of its squared error and λ times its
/// squared Laplacian (Sloan 2008, "Stupid Spherical Harmonics (SH) Tricks"). Degree 0, the mean, stays.
pub fn windowed(coefficients: &[f64], strength: f64) -> Vec<f64> {
    let factor = |i: usize| {
        let l = i.isqrt() as f64;
        1.0 / (1.0 + strength * (l * (l + 1.0)).powi(2))
    };
    coefficients.iter().enumerate().map(|(i, c)| c * factor(i)).collect()
}

/// The least λ, to a hundredth, by which none of the `channels` has negative irradiance in any direction; 0 where none has. One for
/// all channels, so that no hue changes but where colours differ by direction. A channel of negative mean is left aside: no window
/// helps it.
pub fn strength(channels: &[Vec<f64>]) -> f64 {
    let order = channels.first().map_or(0, |channel| channel.len().isqrt() as u32);
    let directions: Vec<DVec3> = sphere_rule(12).into_iter().map(|(d, _)| d).chain(axes()).collect();
    let harmonics: Vec<Vec<f64>> = directions.iter().map(|d| lobes(order, *d)).collect();
    let is_sound = |strength: f64| {
        channels.iter().filter(|channel| channel.first().is_some_and(|mean| *mean >= 0.0)).all(|channel| {
            let channel = windowed(channel, strength);
            let tolerated = -1e-6 * channel[0];
            harmonics.iter().all(|h| h.iter().zip(&channel).map(|(h, c)| h * c).sum::<f64>() >= tolerated)
        })
    };
    if is_sound(0.0) {
        return 0.0;
    }
    let (mut low, mut high) = (1e-6_f64, STRONGEST);
    while high > 1.01 * low {
        let middle = (low * high).sqrt();
        if is_sound(middle) { high = middle } else { low = middle }
    }
    high
}

/// Harmonics times what makes irradiance of them.
fn lobes(order: u32, d: DVec3) -> Vec<f64> {
    let mut out = vec![0.0; sh::count(order)];
    sh::evaluate(order, d, &mut out);
    out.iter_mut().enumerate().for_each(|(i, value)| *value *= sh::cosine_factor(i.isqrt() as u32));
    out
}

fn axes() -> impl Iterator<Item = DVec3> {
    DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light from one direction at order 3 falls below 0 at right angles; the window ends that and keeps the mean.
    #[test]
    fn a_narrow_light_is_nowhere_negative() {
        let d = DVec3::new(0.6, -0.48, 0.64);
        for order in 3..=6 {
            let mut light = vec![0.0; sh::count(order)];
            sh::evaluate(order, d, &mut light);
            let least =
                |c: &[f64]| sphere_rule(16).iter().map(|(n, _)| sh::irradiance(c, *n)).fold(f64::INFINITY, f64::min);
            assert!(least(&light) < -1e-3, "{order}: {}", least(&light));
            let strength = strength(std::slice::from_ref(&light));
            let soft = windowed(&light, strength);
            eprintln!(
                "order {order}: strength {strength:.4}, irradiance from {:.4} to {:.4}",
                least(&light),
                least(&soft)
            );
            assert!(strength > 0.0 && strength < 0.3 && least(&soft) > -1e-3 * soft[0]);
            assert_eq!(soft[0], light[0]);
            let weaker = windowed(&light, 0.8 * strength);
            assert!(least(&weaker) < 0.0, "a weaker window would do");
        }
    }

    #[test]
    fn even_light_needs_no_window() {
        assert_eq!(strength(&[vec![1.0, 0.1, -0.1, 0.2], vec![0.0; 4]]), 0.0);
        assert_eq!(windowed(&[1.0, 0.5], 0.0), [1.0, 0.5]);
    }
}

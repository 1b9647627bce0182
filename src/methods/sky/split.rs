//! A map split into what captures resolve and what is bright and small.
//!
//! A capture averages radiance over its texels. Where a few of them hold much of the sky's light, what they see decides alone, and
//! an edge that crosses one of them is misplaced by a texel. The radiance above a threshold is taken out there: it lights as
//! parallel lights, with exact shadows. Both parts together are the map.

use crate::scene::EnvironmentMap;
use rayon::prelude::*;
use std::borrow::Cow;

/// Largest radiance that captures take, relative to the sky's power through all directions, 1/sr: of it, a texel of a hemicube
/// with 32 texels a side brings at most some 4 % of the mean irradiance.
const BRIGHT: f64 = 3.0;
/// Less excess than this share of the power is left to captures.
const WORTH: f64 = 0.01;
/// Steps towards the threshold that agrees with what is left below it.
const STEPS: u32 = 12;
/// Maps that are narrower are cut finer first: their light moves from one texel to the next.
const FINE: [u32; 2] = [512, 256];

/// The map, cut so finely that each texel is a light of one radiance.
pub fn fine(map: &EnvironmentMap) -> Cow<'_, EnvironmentMap> {
    let factors = [FINE[0].div_ceil(map.width), FINE[1].div_ceil(map.height)];
    if factors == [1, 1] { Cow::Borrowed(map) } else { Cow::Owned(map.finer(factors)) }
}

/// Largest radiance of any channel.
pub fn peak(texel: [f32; 3]) -> f32 {
    texel[0].max(texel[1]).max(texel[2])
}

/// Radiance above which the light of a fine map is taken out; `None` where captures do it well.
pub fn threshold(map: &EnvironmentMap) -> Option<f32> {
    let total = power_below(map, f32::INFINITY);
    let mut limit = (BRIGHT * total) as f32;
    if map.rgb.par_iter().all(|texel| peak(*texel) <= limit) {
        return None;
    }
    let mut below = total;
    for _ in 0..STEPS {
        below = power_below(map, limit);
        limit = (BRIGHT * below) as f32;
    }
    (total - below > WORTH * total).then_some(limit)
}

/// Power through all directions of what lies below `limit`, by the largest channel.
fn power_below(map: &EnvironmentMap, limit: f32) -> f64 {
    let row = |(y, row): (usize, &[[f32; 3]])| {
        row.iter().map(|texel| f64::from(peak(*texel).min(limit))).sum::<f64>() * map.solid_angle(y as u32)
    };
    let rows: Vec<f64> = map.rgb.par_chunks(map.width as usize).enumerate().map(row).collect();
    rows.iter().sum()
}

/// A texel's radiance below `limit` and above it, of one colour.
pub fn split(texel: [f32; 3], limit: f32) -> [[f32; 3]; 2] {
    let share = (limit / peak(texel)).min(1.0);
    if share < 1.0 { [texel.map(|x| x * share), texel.map(|x| x * (1.0 - share))] } else { [texel, [0.0; 3]] }
}

/// The mean of a map's radiance below `limit` over each texel of a smaller one, by solid angle.
pub fn reduced(map: &EnvironmentMap, [width, height]: [u32; 2], limit: f32) -> EnvironmentMap {
    let columns = shares(map.width, width, |x| x);
    // Of a zone, by the heights between which it lies.
    let rows = shares(map.height, height, |y| -(std::f64::consts::PI * y).cos());
    let row = |y: usize| {
        let mut sums = vec![[0.0f64; 3]; width as usize];
        for (from, share) in &rows[y] {
            let texels = &map.rgb[from * map.width as usize..][..map.width as usize];
            for (sum, parts) in sums.iter_mut().zip(&columns) {
                for (x, part) in parts {
                    let [below, _] = split(texels[*x], limit);
                    (0..3).for_each(|c| sum[c] += share * part * f64::from(below[c]));
                }
            }
        }
        sums.into_iter().map(|sum| sum.map(|x| x as f32)).collect::<Vec<_>>()
    };
    let rgb = (0..height as usize).into_par_iter().flat_map_iter(row).collect();
    EnvironmentMap { width, height, rgb }
}

/// Of which of `from` intervals each of `to` consists, and in which shares, measured by `measure` on [0, 1].
fn shares(from: u32, to: u32, measure: impl Fn(f64) -> f64) -> Vec<Vec<(usize, f64)>> {
    let edge = |i: f64, n: u32| measure((i / f64::from(n)).min(1.0));
    let of = |i: u32| {
        let (low, high) = (edge(f64::from(i), to), edge(f64::from(i + 1), to));
        let first = (u64::from(i) * u64::from(from) / u64::from(to)) as u32;
        let end = (u64::from(i + 1) * u64::from(from)).div_ceil(u64::from(to)) as u32;
        let part = |j: u32| {
            let overlap = edge(f64::from(j + 1), from).min(high) - edge(f64::from(j), from).max(low);
            (j as usize, overlap.max(0.0) / (high - low))
        };
        (first..end.min(from)).map(part).collect()
    };
    (0..to).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn power(map: &EnvironmentMap) -> f64 {
        power_below(map, f32::INFINITY)
    }

    /// A constant map is the same at any size, and nothing of it is bright.
    #[test]
    fn constants_stay_constant() {
        for (width, height) in [(1, 1), (2, 1), (7, 3), (300, 200), (1024, 512)] {
            let map = EnvironmentMap { width, height, rgb: vec![[0.25, 0.5, 1.0]; (width * height) as usize] };
            let fine = fine(&map);
            assert_eq!(threshold(&fine), None);
            let small = reduced(&fine, [128, 64], f32::INFINITY);
            assert!(small.rgb.iter().all(|t| (Vec3::from(*t) - Vec3::new(0.25, 0.5, 1.0)).length() < 1e-6));
            assert!((power(&fine) - 4.0 * std::f64::consts::PI).abs() < 1e-5);
        }
    }

    /// What is taken out and what stays are the whole, whatever the size of the sun.
    #[test]
    fn a_sun_is_taken_out_and_nothing_is_lost() {
        for (width, height, radius) in [(64u32, 32u32, 0i32), (512, 256, 0), (512, 256, 3), (2048, 1024, 4)] {
            let mut map = EnvironmentMap { width, height, rgb: vec![[1.0; 3]; (width * height) as usize] };
            for dy in -radius..=radius {
                for dx in -radius..=radius {
                    let (x, y) = (width as i32 / 4 + dx, height as i32 / 3 + dy);
                    map.rgb[(y * width as i32 + x) as usize] = [1e6; 3];
                }
            }
            let fine = fine(&map);
            let limit = threshold(&fine).expect("a sun");
            let small = reduced(&fine, [128, 64], limit);
            let bright: f64 = (0..fine.height)
                .map(|y| {
                    let row = &fine.rgb[(y * fine.width) as usize..][..fine.width as usize];
                    row.iter().map(|t| f64::from(split(*t, limit)[1][0])).sum::<f64>() * fine.solid_angle(y)
                })
                .sum();
            let (whole, smooth) = (power(&fine), power(&small));
            assert!(((smooth + bright) / whole - 1.0).abs() < 1e-5, "{width}: {smooth} and {bright} of {whole}");
            assert!(smooth < 30.0, "{width}: {smooth} stays, of 12.6 that are not the sun's");
        }
    }

    /// A wide patch is left to captures.
    #[test]
    fn a_wide_patch_stays() {
        let mut map = EnvironmentMap { width: 64, height: 32, rgb: vec![[0.0; 3]; 64 * 32] };
        (0..16).for_each(|i| map.rgb[(8 + i / 4) * 64 + 16 + i % 4 * 4..][..4].fill([2.0; 3]));
        assert_eq!(threshold(&fine(&map)), None);
    }
}

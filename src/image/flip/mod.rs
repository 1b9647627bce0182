//! FLIP: how different two pictures look when one flips between them, 0 (same) to 1, at each pixel.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images" for pictures on a screen; Andersson
//! et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images" for linear radiance.

mod colour;
mod filters;
mod hdr;

use filters::{Features, Sensitivity, columns, rows, separable};
use rayon::prelude::*;

pub use hdr::{HdrFlip, hdr_flip};

/// Pixels per degree of visual angle of a 0.7 m wide screen of 3840 pixels seen from 0.7 m, the paper's default.
pub const DEFAULT_PPD: f32 = 67.0;

/// Red, green and blue of a picture, a plane each.
pub type Planes<'a> = [&'a [f32]; 3];

/// FLIP at each pixel of two pictures in sRGB code values (0 to 1), `ppd` pixels per degree of visual angle.
pub fn flip(reference: Planes, test: Planes, width: usize, ppd: f32) -> Vec<f32> {
    let [a, b] = [opponent(reference), opponent(test)];
    let sensitivity = Sensitivity::new(ppd);
    let [seen_a, seen_b] = [seen(&a, width, &sensitivity), seen(&b, width, &sensitivity)];
    let largest = colour::largest_distance();
    let kernels = Features::new(ppd);
    let [features_a, features_b] = [features(&a[0], width, &kernels), features(&b[0], width, &kernels)];
    let error = |i: usize| {
        let colour = colour::difference(seen_a[i], seen_b[i], largest);
        let [edge, point] = [0, 1].map(|k| (features_a[i][k] - features_b[i][k]).abs());
        // Section 4.2 and 4.3, with the exponent q_f = 0.5: a feature that changes raises the colour's difference.
        let feature = (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2).sqrt();
        colour.powf(1.0 - feature)
    };
    (0..a[0].len()).into_par_iter().map(error).collect()
}

fn opponent([r, g, b]: Planes) -> [Vec<f32>; 3] {
    let colours: Vec<[f32; 3]> = (0..r.len()).into_par_iter().map(|i| colour::ycxcz([r[i], g[i], b[i]])).collect();
    [0, 1, 2].map(|k| colours.iter().map(|colour| colour[k]).collect())
}

/// What the eye keeps of a picture at this distance, as linear colours.
fn seen([y, cx, cz]: &[Vec<f32>; 3], width: usize, filters: &Sensitivity) -> Vec<[f32; 3]> {
    let y = separable(y, width, &filters.y, &filters.y);
    let cx = separable(cx, width, &filters.cx, &filters.cx);
    let [wide, narrow] = filters.cz.each_ref().map(|term| separable(cz, width, term, term));
    let colour = |i: usize| colour::linear_of_ycxcz([y[i], cx[i], wide[i] + narrow[i]]);
    (0..y.len()).into_par_iter().map(colour).collect()
}

/// Strength of edge and of point at each pixel of the achromatic plane.
fn features(y: &[f32], width: usize, kernels: &Features) -> Vec<[f32; 2]> {
    let grey: Vec<f32> = y.par_iter().map(|y| (y + 16.0) / 116.0).collect();
    let smooth = rows(&grey, width, &kernels.smooth);
    let strength = |kernel: &[f32]| -> Vec<f32> {
        let across = separable(&grey, width, kernel, &kernels.smooth);
        let down = columns(&smooth, width, kernel);
        across.iter().zip(&down).map(|(x, y)| x.hypot(*y)).collect()
    };
    let (edge, point) = (strength(&kernels.edge), strength(&kernels.point));
    edge.into_iter().zip(point).map(|(edge, point)| [edge, point]).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// NVIDIA's own program on 8-bit pictures, as an oracle.
    pub(crate) fn oracle(reference: &[u8], test: &[u8], width: usize) -> Vec<f32> {
        let picture =
            |codes: &[u8]| nv_flip::FlipImageRgb8::with_data(width as u32, (codes.len() / 3 / width) as u32, codes);
        nv_flip::flip(picture(reference), picture(test), DEFAULT_PPD).to_vec()
    }

    /// Planes of 0 to 1 from interleaved codes.
    pub(crate) fn planes(codes: &[u8]) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|k| codes.iter().skip(k).step_by(3).map(|&code| code as f32 / 255.0).collect())
    }

    /// Interleaved codes with edges, a gradient, saturated patches and noise.
    fn scene(width: usize, height: usize, seed: u32) -> Vec<u8> {
        let pixel = |i: usize| {
            let (x, y) = (i % width, i / width);
            let noise = ((i as u32 ^ seed).wrapping_mul(2654435761) >> 27) as u8;
            let patch = [[230, 20, 30], [20, 210, 40], [30, 40, 220], [240, 240, 235]][(x / 17 + y / 13) % 4];
            let shade = if (x + 2 * y) % 40 < 25 { x * 160 / width + 20 } else { 200 };
            [0, 1, 2].map(|k| if x * 2 < width { patch[k] / 2 + noise } else { shade as u8 + noise / 2 })
        };
        (0..width * height).flat_map(pixel).collect()
    }

    #[test]
    fn agrees_with_nvidias_program_at_each_pixel() {
        let (width, height) = (75, 52);
        let a = scene(width, height, 0);
        let mut changed = scene(width, height, 99);
        changed[3 * (20 * width + 30)..][..60].fill(255);
        let shifted: Vec<u8> = a.iter().cycle().skip(3).take(a.len()).copied().collect();
        let darker: Vec<u8> = a.iter().map(|code| (*code as f32 * 0.9) as u8).collect();
        for b in [a.clone(), changed, shifted, darker] {
            let [pa, pb] = [planes(&a), planes(&b)];
            let ours = flip(pa.each_ref().map(|p| &p[..]), pb.each_ref().map(|p| &p[..]), width, DEFAULT_PPD);
            let theirs = oracle(&a, &b, width);
            let worst = ours.iter().zip(&theirs).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-3, "largest difference {worst}");
            let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
            assert!((mean(&ours) - mean(&theirs)).abs() < 1e-5, "{} {}", mean(&ours), mean(&theirs));
        }
    }

    #[test]
    fn a_picture_narrower_than_the_filters_is_no_problem() {
        let (a, b) = (scene(3, 2, 0), scene(3, 2, 7));
        let [pa, pb] = [planes(&a), planes(&b)];
        let ours = flip(pa.each_ref().map(|p| &p[..]), pb.each_ref().map(|p| &p[..]), 3, DEFAULT_PPD);
        assert!(ours.iter().zip(oracle(&a, &b, 3)).all(|(x, y)| (x - y).abs() < 1e-3));
    }
}

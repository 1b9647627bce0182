//! The path tracer against another renderer's irradiance of the reference scenes, within the noise of both.
//!
//! The scenes are not part of the project: `HEMICUBE_SCENES` names their folder.

use crate::common::scene_folder;
use hemicube::image::{Picture, exr};
use hemicube::reference::{Progressive, Settings, Tracer, View};
use hemicube::scene;

/// Paths a pixel.
const SPP: u32 = 64;
/// Pixels along the side of a block whose means are compared.
const BLOCK: usize = 16;

/// Mean of a layer over the pixels of a block that both pictures see as reflecting, all channels together.
fn block_mean(picture: &Picture, layer: &str, both: &[bool], block: (usize, usize), scale: f64) -> f64 {
    let channels = picture.rgb(layer).unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for y in block.1 * BLOCK..(block.1 + 1) * BLOCK {
        for x in block.0 * BLOCK..(block.0 + 1) * BLOCK {
            let i = y * picture.width as usize + x;
            if both[i] {
                sum += channels.iter().map(|c| f64::from(c[i]).powf(scale)).sum::<f64>() / 3.0;
                count += 1;
            }
        }
    }
    if count < BLOCK * BLOCK / 2 { f64::NAN } else { sum / count as f64 }
}

/// Compares the layers by blocks; `noise` is the reference's standard error of a pixel over the mean of the layer.
fn compare(name: &str, size: (u32, u32), bounces: u32, noise: &[(&str, f64)]) {
    let Some(folder) = scene_folder(name) else { return };
    let mut peer = exr::read(&folder.join(format!("E_{}x{}.exr", size.0, size.1))).unwrap();
    if let Some(b2) = peer.rgb("b2") {
        let b1 = peer.rgb("b1").unwrap();
        let sum = (0..b1[0].len()).map(|i| std::array::from_fn(|c| b1[c][i] + b2[c][i])).collect::<Vec<[f32; 3]>>();
        peer.insert_rgb("irradiance", sum);
    }
    let scene = scene::load(&folder.join(format!("{name}.gltf"))).unwrap();
    let tracer = Tracer::new(&scene);
    let settings = Settings { bounces, seed: 7, batch: 4 };
    let mut run = Progressive::new(&tracer, View::new(&scene.cameras[0], size.0, size.1), settings);
    (0..SPP / settings.batch).for_each(|_| run.advance());
    let ours = run.picture();
    let mut both = agreeing_mask(&ours, &peer);
    drop_shadow_edges(&ours, &peer, &mut both);
    for &(layer, noise) in noise {
        let (mut rows, mut total) = (vec![], [0.0; 2]);
        for by in 0..size.1 as usize / BLOCK {
            for bx in 0..size.0 as usize / BLOCK {
                let at = |picture, layer: &str| block_mean(picture, layer, &both, (bx, by), 1.0);
                let (a, b) = (at(&ours, layer), at(&peer, layer));
                let error = at_error(&ours, layer, &both, (bx, by));
                if a.is_finite() {
                    rows.push((a, b, error, (bx, by)));
                    total = [total[0] + a, total[1] + b];
                }
            }
        }
        report(name, layer, noise, &rows, total);
    }
}

/// Leaves out the few pixels where a shadow's edge passes: the other renderer starts its rays millimetres off the surface
/// and sees light past mouldings that hide it.
fn drop_shadow_edges(ours: &Picture, peer: &Picture, both: &mut [bool]) {
    let (a, b, e) = (ours.rgb("dir").unwrap()[0], peer.rgb("dir").unwrap()[0], ours.rgb("stderr.dir").unwrap()[0]);
    let mean = b.iter().map(|&b| f64::from(b)).sum::<f64>() / b.len() as f64;
    let mut dropped = 0;
    for i in 0..both.len() {
        if both[i] && (a[i] - b[i]).abs() > 0.05 * mean as f32 + 8.0 * e[i] + 0.1 * b[i].min(a[i]) {
            both[i] = false;
            dropped += 1;
        }
    }
    println!("{dropped} of {} pixels lie on shadow edges", both.len());
    assert!(dropped * 500 <= both.len());
}

/// Standard error of a block's mean from the pixels' own.
fn at_error(picture: &Picture, layer: &str, both: &[bool], block: (usize, usize)) -> f64 {
    let variance = block_mean(picture, &format!("stderr.{layer}"), both, block, 2.0);
    (variance / (BLOCK * BLOCK) as f64).sqrt()
}

fn agreeing_mask(ours: &Picture, peer: &Picture) -> Vec<bool> {
    let (a, b) = (ours.scalar("mask").unwrap(), peer.rgb("mask").unwrap()[0]);
    let differing = a.iter().zip(b).filter(|(a, b)| (**a > 0.5) != (**b > 0.5)).count();
    println!("mask differs at {differing} of {} pixels", a.len());
    assert!(differing * 1000 <= a.len(), "{differing} pixels see something else");
    a.iter().zip(b).map(|(a, b)| *a > 0.5 && *b > 0.5).collect()
}

fn report(name: &str, layer: &str, noise: f64, rows: &[(f64, f64, f64, (usize, usize))], total: [f64; 2]) {
    let mean = total[1] / rows.len() as f64;
    let n = (BLOCK * BLOCK) as f64;
    // The other renderer's noise in a block, taken as proportional to the root of its brightness, and the rounding of its
    // file to 11 bits, which does not average out where light is constant.
    let peer_error = |b: f64| (noise * mean * (b / mean).max(0.1).sqrt() / n.sqrt()).hypot(b / 4096.0);
    let z: Vec<f64> = rows.iter().map(|&(a, b, e, _)| (a - b) / e.hypot(peer_error(b))).collect();
    let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
    let bias = total[0] / total[1] - 1.0;
    let bias_error =
        rows.iter().map(|r| r.2.powi(2) + peer_error(r.1).powi(2)).sum::<f64>().sqrt() / (mean * rows.len() as f64);
    let worst = z.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
    println!(
        "{name} {layer}: mean {:+.3} % (z {:+.1}), {} blocks: rms z {rms:.2}, worst z {:+.1} at {:?}",
        100.0 * bias,
        bias / bias_error,
        z.len(),
        worst.1,
        rows[worst.0].3
    );
    assert!(bias.abs() < 4.0 * bias_error + 5e-4, "{name} {layer} is off by {bias}");
    assert!(rms < 1.4 && worst.1.abs() < 6.0, "{name} {layer}: blocks differ");
}

#[test]
fn cornell() {
    compare(
        "cornell",
        (256, 256),
        Settings::ALL_BOUNCES,
        &[("dir", 0.0007), ("b1", 0.0057), ("b2", 0.0403), ("b3plus", 0.0562)],
    );
}

/// What `--bounces 2` gives, against the sum of what has been reflected once and twice.
#[test]
fn two_bounces() {
    compare("cornell", (256, 256), 2, &[("irradiance", noise_of_sum([0.0057, 0.0403], [0.0741, 0.0369]))]);
    compare("sponza", (128, 128), 2, &[("irradiance", noise_of_sum([0.0085, 0.05], [0.5476, 0.2306]))]);
}

/// Noise over the mean of a sum of two layers of these noises and means.
fn noise_of_sum(noise: [f64; 2], mean: [f64; 2]) -> f64 {
    (noise[0] * mean[0]).hypot(noise[1] * mean[1]) / (mean[0] + mean[1])
}

#[test]
fn sponza() {
    // The other renderer's Sponza ends after ten reflections: 2.5 % of `b3plus` would come later.
    compare("sponza", (128, 128), 10, &[("dir", 1e-4), ("b1", 0.0085), ("b2", 0.05), ("b3plus", 0.0517)]);
}

#[test]
fn living_room() {
    compare("living-room", (256, 144), 1, &[("dir", 0.0012), ("b1", 0.0115)]);
}

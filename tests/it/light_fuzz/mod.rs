//! A fuzzer of light: random small scenes, whose energy by the renderer is that by the path tracer.
//!
//! `tools/fuzz_light.sh` runs as many as wanted; what it finds is reduced to a test beside those of its kind.

mod random;
mod scenes;

use crate::common::energy::{Energy, Light, energies};
use crate::common::small;
use hemicube::image::png;
use scenes::case;
use std::path::PathBuf;

/// How far an energy may be off, beside three standard errors of the path tracer.
const BOUND: f64 = 0.05;
/// The path tracer knows the light to this share of it, or the scene is not judged.
const KNOWN: f64 = 0.02;
/// Paths a pixel.
const PATHS: u32 = 256;
/// Pixels a side.
const SIDE: u32 = 40;

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// Writes what is beside what should be, into the folder `HEMICUBE_FUZZ_PICTURES` if that is named.
fn show(name: &str, light: &Light) {
    let Some(folder) = std::env::var_os("HEMICUBE_FUZZ_PICTURES") else { return };
    let side = SIDE as usize;
    let rows = light.is.chunks(side).zip(light.should.chunks(side));
    let values: Vec<f32> = rows.flat_map(|(is, should)| is.iter().chain(should)).copied().collect();
    let top = light.should.iter().copied().fold(0.0, f32::max) * 0.5;
    let path = PathBuf::from(folder).join(format!("{name}.png"));
    png::write_false_colour(&path, 2 * SIDE, SIDE, &values, top).unwrap();
}

/// Scenes from `HEMICUBE_FUZZ_FIRST` on, `HEMICUBE_FUZZ_SCENES` of them: a line each, and the ten worst.
#[test]
fn random_scenes_have_their_light() {
    let (first, count) = (number("HEMICUBE_FUZZ_FIRST", 0), number("HEMICUBE_FUZZ_SCENES", 10));
    let (mut worst, mut judged) = (Vec::new(), 0);
    for seed in first..first + count {
        let case = case(seed);
        let found = energies(&case.scene, &case.camera, &small(SIDE), PATHS);
        let line = |kind: &str, energy: &Energy| {
            let Energy { is, should, error } = energy;
            format!(
                "scene {seed}, {kind}: {:+.2} % ({is:.4e} for {should:.4e} ± {error:.1e}): {}",
                1e2 * energy.off(),
                case.holds
            )
        };
        for (kind, light) in ["direct", "indirect"].into_iter().zip(&found) {
            let energy = &light.energy;
            show(&format!("{seed}-{kind}"), light);
            eprintln!("{}", line(kind, energy));
            assert!(energy.is.is_finite(), "{}", line(kind, energy));
            if energy.is_known_to(KNOWN) {
                judged += 1;
                worst.push((energy.off().abs(), energy.is_off_by(BOUND), line(kind, energy)));
            }
        }
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    let off: Vec<_> = worst.iter().filter(|(_, is_off, _)| *is_off).collect();
    eprintln!("{judged} of {} energies are judged; the worst:", 2 * count);
    worst.iter().take(10).for_each(|(.., line)| eprintln!("  {line}"));
    let lines: Vec<_> = off.iter().map(|(.., line)| line.as_str()).collect();
    assert!(off.is_empty(), "{} of {judged} energies are off:\n{}", off.len(), lines.join("\n"));
}

//! Against NumPy, and against errors made on purpose.

use super::*;

const WIDTH: usize = 18;
const PIXELS: usize = WIDTH * 13;

/// The pictures of tools/metrics_oracle.py.
fn oracle_pictures() -> (Picture, Picture, Vec<bool>) {
    let reference = |i: usize, c: usize| ((i * 7919 + c * 104729) % 1000) as f64 / 500.0;
    let test = |i: usize, c: usize| reference(i, c) + (((i * 31 + c * 17) % 13) as f64 - 6.0) / 100.0;
    let picture = |value: &dyn Fn(usize, usize) -> f64| {
        let mut picture = Picture::new(WIDTH as u32, 13);
        picture.insert_rgb("", (0..PIXELS).map(|i| [0, 1, 2].map(|c| value(i, c) as f32)));
        picture
    };
    (picture(&test), picture(&reference), (0..PIXELS).map(|i| i % 7 != 0).collect())
}

fn close(ours: f64, numpy: f64) -> bool {
    (ours - numpy).abs() <= 2e-9 * numpy.abs()
}

/// mean, mae, rms, relmse, p95, p99, max, energy, block mae, block rms.
fn check(metrics: &Metrics, numpy: [f64; 10]) {
    let Metrics { mean_reference, mae, rms, relmse, p95, p99, max, energy, block_mae, block_rms, .. } = metrics;
    let ours = [mean_reference, mae, rms, relmse, p95, p99, max, &energy.unwrap(), block_mae, block_rms];
    for (index, (ours, numpy)) in ours.into_iter().zip(numpy).enumerate() {
        assert!(close(*ours, numpy), "figure {index}: {ours} {numpy}");
    }
}

/// Figures printed by `python3 tools/metrics_oracle.py`.
#[test]
fn figures_agree_with_numpy() {
    let (test, reference, mask) = oracle_pictures();
    let (test, reference) = (test.layer("").unwrap(), reference.layer("").unwrap());
    let all = [
        0.9895584058,
        0.03264859618,
        0.03781138587,
        0.01149688388,
        0.05097775554,
        0.0585740652,
        0.06433926128,
        0.9999999982,
        0.007197662902,
        0.008294532096,
    ];
    let masked = [
        0.9874600012,
        0.03274394341,
        0.03790526795,
        0.01135555165,
        0.05190596522,
        0.05912763142,
        0.0643416304,
        1.000337566,
        0.008135349456,
        0.009539171065,
    ];
    check(&measure(&test, &reference, WIDTH, None), all);
    check(&measure(&test, &reference, WIDTH, Some(&mask)), masked);
}

const SIDE: usize = 96;

/// A room-like picture: a smooth gradient, a sharp shadow, a bright patch, a little texture.
fn scene() -> Picture {
    let mut picture = Picture::new(SIDE as u32, SIDE as u32);
    let pixel = |i: usize| {
        let (x, y) = ((i % SIDE) as f32 / SIDE as f32, (i / SIDE) as f32 / SIDE as f32);
        let shadow = if (0.3..0.6).contains(&x) && y > 0.5 { 0.25 } else { 1.0 };
        let patch = if (x - 0.75).hypot(y - 0.25) < 0.1 { 5.0 } else { 1.0 };
        let texture = 1.0 + 0.1 * (40.0 * x).sin() * (33.0 * y).cos();
        [1.0, 0.8, 0.6].map(|tint| tint * shadow * patch * texture * (0.2 + x * y))
    };
    picture.insert_rgb("", (0..SIDE * SIDE).map(pixel));
    picture
}

/// The scene with each pixel's value taken through `change(pixel, value at a pixel)`, and its errors.
fn injected(change: impl Fn(usize, &dyn Fn(usize) -> f32) -> f32) -> Metrics {
    let reference = scene();
    let mut test = reference.clone();
    for (name, channel) in &mut test.channels {
        let plane = &reference.channels[name];
        *channel = (0..plane.len()).map(|i| change(i, &|i| plane[i])).collect();
    }
    let (test, reference) = (test.layer("").unwrap(), reference.layer("").unwrap());
    let flip = measure_flip(&test, &reference, SIDE, None);
    Metrics { flip, ..measure(&test, &reference, SIDE, None) }
}

#[test]
fn same_pictures_have_no_error() {
    let metrics = injected(|i, at| at(i));
    assert_eq!([metrics.mae, metrics.rms, metrics.relmse, metrics.max, metrics.block_rms], [0.0; 5]);
    assert_eq!((metrics.energy, metrics.flip), (Some(1.0), Some(0.0)));
}

#[test]
fn three_percent_of_lost_energy_are_caught() {
    let metrics = injected(|i, at| 0.97 * at(i));
    assert!((metrics.energy.unwrap() - 0.97).abs() < 1e-6);
    assert!((metrics.mae - 0.03).abs() < 1e-6 && (metrics.block_mae - 0.03).abs() < 1e-6);
    assert!(metrics.p95 < 0.031 && metrics.p99 < 0.031, "an even loss has no tail");
}

#[test]
fn a_dropped_column_is_caught() {
    let metrics = injected(|i, at| if i % SIDE == 48 { 0.0 } else { at(i) });
    assert!(metrics.max > 0.9 && metrics.p99 > 0.9, "{metrics:?}");
    assert!(metrics.p95 == 0.0 && metrics.mae < 0.02, "the mean alone would let it pass: {metrics:?}");
    assert!(metrics.rms > 3.0 * metrics.mae && metrics.flip.unwrap() > 0.02, "{metrics:?}");
}

#[test]
fn a_shift_by_one_pixel_is_caught() {
    let metrics = injected(|i, at| at(if i % SIDE == 0 { i } else { i - 1 }));
    assert!((metrics.energy.unwrap() - 1.0).abs() < 0.02, "the energy alone would let it pass: {metrics:?}");
    assert!(
        metrics.mae > 0.01 && metrics.max > 0.5 && metrics.p99 > 0.2 && metrics.flip.unwrap() > 0.01,
        "{metrics:?}"
    );
}

#[test]
fn noise_shrinks_in_blocks_and_bias_does_not() {
    let sign = |i: usize| if (i as u32).wrapping_mul(2654435761) >> 31 == 0 { -0.1 } else { 0.1 };
    let metrics = injected(|i, at| at(i) * (1.0 + sign(i)));
    assert!((metrics.mae - 0.1).abs() < 1e-3 && metrics.block_mae < 0.05, "{metrics:?}");
}

#[test]
fn values_that_are_no_numbers_are_counted_and_left_out() {
    let metrics = injected(|i, at| if i == 7 { f32::NAN } else { at(i) });
    assert_eq!((metrics.non_finite_test, metrics.non_finite_reference, metrics.pixels), (1, 0, SIDE * SIDE - 1));
    assert_eq!((metrics.mae, metrics.flip), (0.0, Some(0.0)));
}

#[test]
fn the_mask_hides_what_it_hides() {
    let reference = scene();
    let mut test = reference.clone();
    test.channels.get_mut("G").unwrap()[100..150].fill(1e6);
    let mask: Vec<bool> = (0..SIDE * SIDE).map(|i| !(100..150).contains(&i)).collect();
    let (test, reference) = (test.layer("").unwrap(), reference.layer("").unwrap());
    assert_eq!(measure(&test, &reference, SIDE, Some(&mask)).max, 0.0);
    assert_eq!(measure_flip(&test, &reference, SIDE, Some(&mask)), Some(0.0));
    assert_eq!(measure(&test, &reference, SIDE, Some(&vec![false; SIDE * SIDE])).pixels, 0);
}

#[test]
fn a_black_reference_gives_no_error_to_black_and_an_infinite_one_to_light() {
    let picture = |value: f32| {
        let mut picture = Picture::new(2, 2);
        picture.insert_rgb("", [[value; 3]; 4]);
        picture
    };
    let (black, grey) = (picture(0.0), picture(1.0));
    let [black, grey] = [&black, &grey].map(|picture| picture.layer("").unwrap());
    assert_eq!(measure(&black, &black, 2, None).mae, 0.0);
    assert_eq!(measure(&grey, &black, 2, None).mae, f64::INFINITY);
}

//! Every kind of capture against closed forms.

use super::{BARE_PLANE, PLANE, WHOLE, mean, measure};
use crate::common::build::{Builder, Facing, diffuse};
use crate::common::closed_forms::{parallelogram, polygon};
use crate::common::gpu;
use crate::common::probes::turned;
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::math::capture::seen_by_plane;
use hemicube::math::form_factor;
use hemicube::methods::captures::{CaptureMode, PLANE_APERTURE};
use hemicube::methods::probes::Probe;
use hemicube::scene::{Background, Light, Scene, SideLimit};
use std::f64::consts::PI;

/// Nothing but a sky of radiance 1: E = π at every size, to the rounding of as many single-precision weights; the plane
/// without compensation sees its form factor. Nothing changes when the place turns or moves.
#[test]
fn a_furnace_is_exact_at_every_size() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, -1.0, 1.0);
    b.background(Background::Constant(Vec3::ONE));
    let scene = b.build();
    for size in [8, 12, 64, 256] {
        for (capture, share) in WHOLE
            .map(|kind| (kind, 1.0))
            .into_iter()
            .chain([(BARE_PLANE, seen_by_plane((PLANE_APERTURE / 2.0).to_radians().tan()))])
        {
            for probe in measure(&scene, capture, size, &turned(Vec3::ZERO, 2)) {
                let sky = probe.sky.unwrap();
                let e = f64::from(sky.value.y) / PI;
                assert!((e / share - 1.0).abs() < 3e-6, "{capture:?} {size}: {e} of π, not {share}");
                let slope = sky.rotation[1].length().max(sky.translation[1].length());
                assert!(slope < 1e-5, "{capture:?} {size}: gradients {sky:?}");
                assert_eq!(probe.reflected.value, Vec3::ZERO);
                assert_eq!(probe.inverse_distance, 0.0);
            }
        }
    }
    assert!((seen_by_plane(2.0) - 0.831).abs() < 5e-4);
}

/// Inside a sphere that a lamp at its middle lights: E₁ = ρI/s² everywhere, and with cosine weights 1/R = 1/s, for the
/// distance is 2s·cosθ. Gradients are 0.
#[test]
fn the_integrating_sphere_by_every_kind() {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.sphere(white, Vec3::ZERO, 2.0, 96, Facing::In);
    b.light(Light::Point { position: Vec3::ZERO, intensity: Vec3::splat(3.0) });
    let scene = b.build();
    for capture in WHOLE {
        let probes = measure(&scene, capture, 32, &turned(vec3(0.0, -2.0 * 0.9995, 0.0), 16));
        let e = mean(&probes, |p| p.reflected.value.y) / (0.8 * 3.0 / 4.0);
        let r = mean(&probes, |p| p.inverse_distance) * 2.0;
        let slope = mean(&probes, |p| p.reflected.translation[1].length() + p.reflected.rotation[1].length()) / 0.6;
        eprintln!("{capture:?}: E {e:.4}, 1/R {r:.4} of the closed forms, gradients {slope:.4}");
        // 1/d grows without bound towards the horizon: texels that are wide there miss some of it, and a plane's border
        // stands for things whose distances it does not know.
        let of_r = match capture {
            CaptureMode::Plane { .. } => 0.25,
            CaptureMode::Hemisphere | CaptureMode::ComputeHemisphere => 0.08,
            _ => 0.02,
        };
        assert!((e - 1.0).abs() < 0.001 && (r - 1.0).abs() < of_r, "{capture:?}: {e} {r}");
        assert!(slope < 0.03, "{capture:?}: {slope}");
    }
}

/// The rectangle x ∈ [.3, 1.5], z ∈ [−.9, .7], y = 1, which a sun from below makes shine with radiance 1.
fn rectangle() -> (Scene, [DVec3; 4]) {
    let mut b = Builder::default();
    shining_rectangle(&mut b);
    (b.build(), parallelogram(dvec3(0.3, 1.0, -0.9), DVec3::X * 1.2, DVec3::Z * 1.6))
}

fn shining_rectangle(b: &mut Builder) {
    let white = b.material(diffuse(1.0));
    b.quad(white, vec3(0.3, 1.0, -0.9), Vec3::X * 1.2, Vec3::Z * 1.6);
    b.light(Light::Directional { direction: Vec3::Y, irradiance: Vec3::splat(std::f32::consts::PI) });
}

/// Root mean square deviation over turns of E, ∇_r E and ∇_t E from the closed form and its central differences.
fn deviations(scene: &Scene, corners: &[DVec3; 4], capture: CaptureMode, size: u32) -> [f64; 3] {
    let at = |p: DVec3, n: DVec3| polygon(p, n.normalize(), corners);
    let e = at(DVec3::ZERO, DVec3::Y);
    let step = 1e-4;
    let central = |plus: f64, minus: f64| (plus - minus) / (2.0 * step);
    let moved = [DVec3::X, DVec3::Z].map(|d| central(at(step * d, DVec3::Y), at(-step * d, DVec3::Y)));
    let tilted = [DVec3::X, DVec3::Z]
        .map(|d| central(at(DVec3::ZERO, DVec3::Y + step * d), at(DVec3::ZERO, DVec3::Y - step * d)));
    let probes = measure(scene, capture, size, &turned(Vec3::ZERO, 96));
    let rms = |of: &dyn Fn(&Probe) -> f64| (probes.iter().map(of).sum::<f64>() / probes.len() as f64).sqrt();
    let off =
        |v: Vec3, expected: [f64; 2]| (f64::from(v.x) - expected[0]).powi(2) + (f64::from(v.z) - expected[1]).powi(2);
    [
        rms(&|p| (f64::from(p.reflected.value.y) / e - 1.0).powi(2)),
        // E changes by (n × n′)·∇_r E = (n′ − n)·(∇_r E × n).
        rms(&|p| off(p.reflected.rotation[1].cross(Vec3::Y), tilted)) / tilted[0].hypot(tilted[1]),
        rms(&|p| off(p.reflected.translation[1], moved)) / moved[0].hypot(moved[1]),
    ]
}

/// A texel's centre decides what it sees, so that a light's side is off by a random part of a texel along each of the
/// texels it crosses: with h the texel's width the error falls between h (a side along the rows) and h^(3/2) (any other).
#[test]
fn a_rectangle_converges_by_every_kind() {
    let (scene, corners) = rectangle();
    let fine = scene.tessellated(&SideLimit::even(0.04));
    for capture in WHOLE {
        let scene = if capture == CaptureMode::Hemisphere { &fine } else { &scene };
        let errors = [16, 32, 64].map(|size| deviations(scene, &corners, capture, size));
        for (what, name) in ["E", "∇_r E", "∇_t E"].into_iter().enumerate() {
            let [coarse, middle, good] = errors.map(|e| e[what]);
            let order = (coarse / good).log(4.0);
            eprintln!("{capture:?}: {name} {coarse:.4}, {middle:.4}, {good:.4}: order {order:.2}");
            // A plane's texels are twice as wide.
            let scale = if capture == PLANE { 2.0 } else { 1.0 };
            assert!(good < 0.03 * scale, "{capture:?}: {name} {good} at 64²");
            assert!(order > 0.8, "{capture:?}: {name} falls as h^{order}");
        }
    }
}

/// Beside a wall of height 1, down to a millionth of the scene's size, where positions have three bits left:
/// E = ½πL(1 − x/√(x² + 1)). Half of what is seen lies in front of any near plane that the scene's size would give.
#[test]
fn records_beside_a_wall_see_it() {
    let mut b = Builder::default();
    let grey = b.material(diffuse(1.0));
    b.quad(grey, vec3(0.0, 0.0, 20.0), Vec3::NEG_Z * 40.0, Vec3::Y);
    b.light(Light::Directional { direction: Vec3::NEG_X, irradiance: Vec3::ONE });
    let scene = b.build();
    for capture in [CaptureMode::Hemicube, CaptureMode::Compute, PLANE] {
        for share in [1e-2f32, 1e-4, 1e-6] {
            let x = 20.0 * share;
            let probes = measure(&scene, capture, 32, &turned(vec3(x, 0.0, 0.0), 64));
            let e = mean(&probes, |p| p.reflected.value.y) * PI / form_factor::wall(f64::from(x), 1.0);
            eprintln!("{capture:?}: at {share:e} of the scene E is {e:.4} of the closed form");
            // By turns a centre on the wall's own plane falls to either side.
            assert!((e - 1.0).abs() < 0.02, "{capture:?}, {share:e}: {e}");
        }
    }
}

/// A black sheet behind the shining rectangle, farther by a 13,000th: of no texel is it seen in place of the nearer one, from
/// within the scene, where depths of 19 octaves are told apart in compute. Render passes tell them apart by what corners that are
/// rounded to 2⁻ᵇ of a texel leave of a depth: twice that, of texels that are 2/N wide at distance 1.
#[test]
fn the_nearer_of_two_sheets_is_seen() {
    const SIZE: u32 = 32;
    let sheets = |capture: CaptureMode, behind: Option<f32>| {
        let mut b = Builder::default();
        // First, so that of equals it is drawn.
        let black = b.material(diffuse(0.0));
        b.quad(black, vec3(-0.3, -0.5, 0.1), Vec3::X * 1e-3, Vec3::Z * 1e-3);
        if let Some(apart) = behind {
            b.quad(black, vec3(0.3, 1.0, -0.9) * (1.0 + apart), Vec3::X * 1.2, Vec3::Z * 1.6);
        }
        shining_rectangle(&mut b);
        measure(&b.build(), capture, SIZE, &turned(Vec3::ZERO, 16))
    };
    let bits = gpu().capabilities.limits.sub_pixel_precision_bits;
    let by_passes = (SIZE << bits) as f32 / 4.0;
    for (capture, distances) in
        [(CaptureMode::Compute, &[10e3, 11e3, 12e3, 13e3][..]), (CaptureMode::Hemicube, &[by_passes])]
    {
        let alone = sheets(capture, None);
        for apart in distances {
            for (one, two) in alone.iter().zip(&sheets(capture, Some(1.0 / apart))) {
                let [one, two] = [one, two].map(|p| p.reflected.value.y);
                assert!((two / one - 1.0).abs() < 1e-5, "{capture:?}, a {apart}th: {one} becomes {two}");
            }
        }
    }
}

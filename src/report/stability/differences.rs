//! Gradients in the Cornell box against central differences of E.

use super::area::GRADIENT;
use super::case::{place, slope_of_turn};
use super::exact::Exact;
use super::{Bench, Bound, Row, turn};
use crate::methods::captures::{CaptureMode, LIFT};
use crate::methods::probes::{Place, Probe, ProbeError};
use crate::scene::{Scene, cornell};
use glam::{DVec2, DVec3};

/// Bound where some see a surface edge-on, thinner than a texel, with outlines followed: 2 % at 64 texels a side. Where the
/// surface is seen in part, by the texels whose centres it happens to cover, they err as its width h.
const ALL: Bound = Bound::linear(0.02 * 32.0);
/// A surface is seen edge-on from nearer to its plane than this share of its distance: a texel at 64 a side.
const TEXEL: f64 = 2.0 / 64.0;
/// Points on the surfaces.
const POINTS: u32 = 50;
/// Turns of each of them.
const TURNS_OF_POINT: usize = 8;
/// Texels a side.
const SIZES: [u32; 4] = [16, 32, 64, 128];
/// Half the distance of a difference, in metres; the box measures 0.55. E is exact, so that it may be as small as that.
const STEP: f64 = 1e-5;
/// Half the angle of a difference, in radians.
const ANGLE: f64 = 1e-4;
/// Points whose R is nearer than this are left out: those within 2 cm of another surface.
const NEAREST: f64 = 0.1;
/// Surface cells, constant radiance on each, and samples of the lamp: the same for gradients and differences.
const CELLS: (u32, u32) = (1 << 14, 128);

/// A point with two tangents.
struct Point {
    position: DVec3,
    normal: DVec3,
    tangents: [DVec3; 2],
}

/// Translation and rotation gradients at random points: the summed length of the errors over that of the differences.
pub(super) fn cornell_gradients(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let scene = cornell();
    let points = points(bench, &scene)?;
    let exact = Exact::new(bench.surface(&scene, CELLS)?, triangles(&scene));
    let (low, high) = scene.bounds();
    let lift = f64::from(LIFT * (high - low).length() * 0.5);
    let lifted = |p: &Point| p.position + p.normal * lift;
    let moved = |p: &Point, t: DVec3, s: f64| exact.irradiance(lifted(p) + t * s * STEP, p.normal);
    let turned =
        |p: &Point, t: DVec3, s: f64| exact.irradiance(lifted(p), (p.normal + t * (s * ANGLE).tan()).normalize());
    let moves: Vec<DVec2> = points.iter().map(|p| difference(p, STEP, moved)).collect();
    let turns: Vec<DVec2> = points.iter().map(|p| difference(p, ANGLE, turned)).collect();
    let row = |quantity: &str, bound| Row {
        case: format!("Cornell box, {POINTS} points"),
        quantity: quantity.into(),
        expected: 1.0,
        got: 0.0,
        errors: Vec::new(),
        bound,
        capture: "",
    };
    // What a kind captures in another's way is that one's to measure.
    let own = |size: &u32| {
        bench.capture == CaptureMode::Hemicube || bench.capture.against_compute(&bench.device, &scene, *size).is_none()
    };
    let sizes: Vec<u32> = SIZES.into_iter().filter(own).collect();
    let mut rows = [
        row("∇_t E / differences, all points", ALL),
        row("∇_t E / differences, nothing edge-on", GRADIENT),
        row("dE/dn / differences, all points", GRADIENT),
        row("dE/dn / differences, nothing edge-on", GRADIENT),
    ];
    let resolved: Vec<bool> = points.iter().map(|p| !sees_edge_on(&exact.triangles, p.position)).collect();
    let places: Vec<Place> = points.iter().flat_map(|p| turns_of(p.position, p.normal)).collect();
    for size in sizes {
        let probes = bench.measure(&scene, &places, size, CELLS)?;
        let of_move = |probe: &Probe, _: &Point, t: DVec3| probe.reflected.translation[0].as_dvec3().dot(t);
        let of_turn = |probe: &Probe, p: &Point, t: DVec3| slope_of_turn(&probe.reflected, p.normal, t);
        let both = [(gradients(&probes, &points, of_move), &moves), (gradients(&probes, &points, of_turn), &turns)];
        for (rows, (got, expected)) in rows.chunks_mut(2).zip(both) {
            for (row, all) in rows.iter_mut().zip([true, false]) {
                // Each record by itself: an average over turns would hide what a single one is off by.
                let of_point =
                    |i: usize| got[i * TURNS_OF_POINT..][..TURNS_OF_POINT].iter().map(move |g| (*g, expected[i]));
                let kept = (0..points.len()).filter(|i| all || resolved[*i]);
                let pairs: Vec<(DVec2, DVec2)> = kept.flat_map(of_point).collect();
                let total: f64 = pairs.iter().map(|(_, e)| e.length()).sum();
                row.got = pairs.iter().map(|(g, e)| g.dot(e.normalize_or_zero())).sum::<f64>() / total;
                row.errors.push((size, pairs.iter().map(|(g, e)| (*g - *e).length()).sum::<f64>() / total));
            }
        }
    }
    Ok(rows.into())
}

/// Whether a point sees a triangle, not its own, so nearly along its plane that it is thinner than a texel.
fn sees_edge_on(triangles: &[[DVec3; 3]], p: DVec3) -> bool {
    triangles.iter().any(|[a, b, c]| {
        let height = (*b - *a).cross(*c - *a).normalize().dot(p - *a).abs();
        let nearest = [a, b, c].into_iter().map(|corner| p.distance(*corner)).fold(f64::MAX, f64::min);
        height > 1e-6 && height < TEXEL * nearest
    })
}

fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    (0..scene.triangles.len() as u32).map(|t| scene.corners(t).map(|c| c.as_dvec3())).collect()
}

/// Points spread by area over all that reflects, of those that see nothing near.
fn points(bench: &Bench, scene: &Scene) -> Result<Vec<Point>, ProbeError> {
    let candidates = candidates(scene);
    let places: Vec<Place> = candidates.iter().map(|p| place(p.position, p.normal, turn(0))).collect();
    let probes = bench.measure(scene, &places, SIZES[0], CELLS)?;
    let is_open = |probe: &Probe| probe.inverse_distance > 0.0 && f64::from(probe.inverse_distance) < 1.0 / NEAREST;
    let open = candidates.into_iter().zip(probes).filter(|(_, probe)| is_open(probe)).map(|(point, _)| point);
    Ok(open.take(POINTS as usize).collect())
}

/// Twice as many points as are wanted, a tenth of a triangle away from its sides.
fn candidates(scene: &Scene) -> Vec<Point> {
    let lamps: Vec<u32> = scene.emitters().iter().map(|e| e.triangle).collect();
    let triangles: Vec<u32> = (0..scene.triangles.len() as u32).filter(|t| !lamps.contains(t)).collect();
    let area = |t: u32| {
        let [a, b, c] = scene.corners(t);
        0.5 * f64::from((b - a).cross(c - a).length())
    };
    let total: f64 = triangles.iter().map(|t| area(*t)).sum();
    let point = |index: u32| {
        // By the golden ratio, so that any run of points is spread over all triangles.
        let mut rest = (0.5 + 0.618_033_988_75 * f64::from(index)).fract() * total;
        let triangle = triangles.iter().copied().find(|t| {
            rest -= area(*t);
            rest <= 0.0
        });
        let triangle = triangle.unwrap_or(triangles[triangles.len() - 1]);
        let [a, b, c] = scene.corners(triangle).map(|v| v.as_dvec3());
        let r = crate::math::sequence::triangle_point(index).as_dvec2() * 0.7 + DVec2::splat(0.1);
        let normal = (b - a).cross(c - a).normalize();
        Point { position: a + (b - a) * r.x + (c - a) * r.y, normal, tangents: normal.any_orthonormal_pair().into() }
    };
    (0..2 * POINTS).map(point).collect()
}

fn turns_of(position: DVec3, normal: DVec3) -> impl Iterator<Item = Place> {
    (0..TURNS_OF_POINT as u32).map(move |i| place(position, normal, turn(i)))
}

/// (E(+δ) − E(−δ)) / 2δ, δ = `step`, along both tangents of a point.
fn difference(point: &Point, step: f64, e: impl Fn(&Point, DVec3, f64) -> f64) -> DVec2 {
    DVec2::from(point.tangents.map(|t| (e(point, t, 1.0) - e(point, t, -1.0)) / (2.0 * step)))
}

/// Gradients along both tangents, of each record.
fn gradients(probes: &[Probe], points: &[Point], of: impl Fn(&Probe, &Point, DVec3) -> f64) -> Vec<DVec2> {
    let of_point = |(point, probes): (&Point, &[Probe])| {
        probes.iter().map(|p| DVec2::from(point.tangents.map(|t| of(p, point, t)))).collect::<Vec<_>>()
    };
    points.iter().zip(probes.chunks(TURNS_OF_POINT)).flat_map(of_point).collect()
}

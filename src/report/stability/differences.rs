//! Gradients in the Cornell box against central differences of E.

use super::area::GRADIENT;
use super::case::{place, slope_of_turn};
use super::{Bench, Row, SIZES, turn};
use crate::methods::probes::{Place, Probe, ProbeError};
use crate::scene::{Scene, cornell};
use glam::{DVec2, DVec3};

/// Points on the surfaces.
const POINTS: u32 = 50;
/// Turns of each of them; the same for both ends of a difference, whose aliasing then falls out in part.
const POINT_TURNS: u32 = 8;
/// Texels a side of the captures that differences are taken of.
const FINE: u32 = 128;
/// Half the distance of a difference, in metres; the box measures 0.55.
const STEP: f64 = 0.008;
/// Half the angle of a difference, in radians: what is left of third order is δ²/6, 10⁻³.
const ANGLE: f64 = 0.08;
/// Points whose R is nearer than this are left out, as the difference's own error is about (δ/R)²/6: within 10⁻³ here.
const NEAREST: f64 = 0.1;
/// Most that the differences' own standard error is allowed to add to the tolerance: noise does not excuse itself.
const MOST_UNCERTAIN: f64 = 0.01;
/// Surface cells, constant radiance on each, and samples of the lamp: the same for gradients and differences.
const CELLS: (u32, u32) = (1 << 16, 128);

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
    let moved = |p: &Point, t: DVec3, s: f64| (p.position + t * s * STEP, p.normal);
    let turned = |p: &Point, t: DVec3, s: f64| (p.position, (p.normal + t * (s * ANGLE).tan()).normalize());
    let moves = differences(bench, &scene, &points, STEP, moved)?;
    let turns = differences(bench, &scene, &points, ANGLE, turned)?;
    let row = |quantity: &str, differences: &[Difference]| Row {
        case: format!("Cornell box, {POINTS} points"),
        quantity: quantity.into(),
        expected: 1.0,
        got: 0.0,
        errors: Vec::new(),
        bound: GRADIENT.and(uncertainty(differences).min(MOST_UNCERTAIN)),
    };
    let mut rows = [row("∇_t E / differences", &moves), row("dE/dn / differences", &turns)];
    for size in SIZES {
        let places: Vec<Place> = points.iter().flat_map(|p| turns_of(p.position, p.normal)).collect();
        let probes = bench.measure(&scene, &places, size, CELLS)?;
        let of_move = |probe: &Probe, _: &Point, t: DVec3| probe.reflected.translation[0].as_dvec3().dot(t);
        let of_turn = |probe: &Probe, p: &Point, t: DVec3| slope_of_turn(&probe.reflected, p.normal, t);
        for (row, (got, expected)) in rows
            .iter_mut()
            .zip([(gradients(&probes, &points, of_move), &moves), (gradients(&probes, &points, of_turn), &turns)])
        {
            let all = total(expected);
            let along = |(g, e): (&DVec2, &Difference)| g.dot(e.slope.normalize_or_zero());
            row.got = got.iter().zip(expected).map(along).sum::<f64>() / all;
            let wrong = |(g, e): (&DVec2, &Difference)| (*g - e.slope).length();
            row.errors.push((size, got.iter().zip(expected).map(wrong).sum::<f64>() / all));
        }
    }
    Ok(rows.into())
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
    (0..POINT_TURNS).map(move |i| place(position, normal, turn(i)))
}

/// A difference of E along both tangents of a point.
#[derive(Clone, Copy)]
struct Difference {
    /// Mean over turns.
    slope: DVec2,
    /// Standard error of that mean.
    error: DVec2,
}

fn total(differences: &[Difference]) -> f64 {
    differences.iter().map(|d| d.slope.length()).sum()
}

/// How exactly differences are known, in the measure that gradients are held against them in.
fn uncertainty(differences: &[Difference]) -> f64 {
    differences.iter().map(|d| d.error.length()).sum::<f64>() / total(differences)
}

/// (E(+δ) − E(−δ)) / 2δ, δ = `step`, along both tangents of each point, from fine captures.
fn differences(
    bench: &Bench,
    scene: &Scene,
    points: &[Point],
    step: f64,
    at: impl Fn(&Point, DVec3, f64) -> (DVec3, DVec3),
) -> Result<Vec<Difference>, ProbeError> {
    let ends = |p: &Point| p.tangents.into_iter().flat_map(|t| [at(p, t, 1.0), at(p, t, -1.0)]).collect::<Vec<_>>();
    let places: Vec<Place> = points.iter().flat_map(ends).flat_map(|(p, n)| turns_of(p, n)).collect();
    let probes = bench.measure(scene, &places, FINE, CELLS)?;
    let turns = POINT_TURNS as usize;
    let one = |probes: &[Probe]| {
        let e = |end: usize, turn: usize| f64::from(probes[end * turns + turn].reflected.value.x);
        let slope = |i| DVec2::new(e(0, i) - e(1, i), e(2, i) - e(3, i)) / (2.0 * step);
        let mean = (0..turns).map(slope).sum::<DVec2>() / turns as f64;
        let variance = (0..turns).map(|i| (slope(i) - mean).powf(2.0)).sum::<DVec2>() / (turns * (turns - 1)) as f64;
        Difference { slope: mean, error: DVec2::new(variance.x.sqrt(), variance.y.sqrt()) }
    };
    Ok(probes.chunks(4 * turns).map(one).collect())
}

/// Gradients along both tangents of each point, means over turns.
fn gradients(probes: &[Probe], points: &[Point], of: impl Fn(&Probe, &Point, DVec3) -> f64) -> Vec<DVec2> {
    let one = |(point, probes): (&Point, &[Probe])| {
        let mean = |t: DVec3| probes.iter().map(|p| of(p, point, t)).sum::<f64>() / probes.len() as f64;
        DVec2::from(point.tangents.map(mean))
    };
    points.iter().zip(probes.chunks(POINT_TURNS as usize)).map(one).collect()
}

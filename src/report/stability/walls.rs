//! Cases of walls that start at the floor: walls, wedges, the harmonic mean beside a wall, slits.

use super::area::{GRADIENT, gradients, irradiance, lit, outline_bound};
use super::case::place;
use super::{Bench, Bound, Case, Known, Read, Row, SIZES, Site, turn};
use crate::math::form_factor;
use crate::methods::probes::ProbeError;
use crate::scene::Background;
use crate::scene::build::{Builder, diffuse};
use glam::{DVec3, Vec3, dvec3};
use std::f64::consts::PI;

/// Half a wall's length; its share of "without end" is within 10⁻⁵ of all.
const HALF: f64 = 200.0;

pub(super) fn cases() -> Vec<Case> {
    let mut all = vec![wall(), perpendicular_wall()];
    all.extend([5.0, 45.0, 90.0, 135.0, 175.0].map(wedge));
    all
}

/// Wall of height 1: E = ½πL(1 − x/√(x² + 1)), dE/dx = −½πL/(x² + 1)^{3/2}.
fn wall() -> Case {
    let corners = [dvec3(0.0, -HALF, 0.0), dvec3(0.0, HALF, 0.0), dvec3(0.0, HALF, 1.0), dvec3(0.0, -HALF, 1.0)];
    let site = |x: f64| {
        let position = dvec3(x, 0.3, 0.0);
        let slope = -0.5 * PI / x.hypot(1.0).powi(3);
        let mut known = vec![
            Known::new("E", Read::E, form_factor::wall(x, 1.0), outline_bound(position, DVec3::Z, &corners)),
            Known::new("dE/dx", Read::Move(DVec3::X), slope, GRADIENT),
            Known::new("dE/dy", Read::Move(DVec3::Y), 0.0, GRADIENT).relative_to(slope.abs()),
        ];
        known
            .extend(gradients(position, DVec3::Z, &corners, x).into_iter().filter(|k| k.quantity.starts_with("dE/dn")));
        Site { words: format!("x = {x}"), position, normal: DVec3::Z, known }
    };
    Case {
        name: "wall",
        scene: lit(&corners, DVec3::X),
        light: (2, 1),
        sites: [0.1, 0.25, 0.5, 1.0, 2.0].map(site).into(),
    }
}

/// Wedge of angle α between the floor and a wall without end: E = ½πL(1 + cos α) at every distance, so that ∇_t E is
/// nothing beside E/x. The wall ends at [`HALF`], so that the finite one's closed form is expected; it differs by x/200.
fn wedge(degrees: f64) -> Case {
    let (s, c) = degrees.to_radians().sin_cos();
    let along = dvec3(c, 0.0, s) * HALF;
    let base = [dvec3(0.0, -HALF, 0.0), dvec3(0.0, HALF, 0.0)];
    let corners = [base[0], base[1], base[1] + along, base[0] + along];
    let site = |x: f64| {
        let position = dvec3(x, 0.0, 0.0);
        let e = irradiance(position, DVec3::Z, &corners);
        // A wall that barely leaves the floor is a strip of few texels at the horizon: what is wrong there is measured
        // by the radiance that moves, L·∮cosθ dl, not by the little that is there.
        let bound = outline_bound(position, DVec3::Z, &corners);
        let scale = e.max(bound.factor * e) / x;
        let slope = {
            let at = |h: f64| irradiance(position + DVec3::X * h, DVec3::Z, &corners);
            (at(1e-4 * x) - at(-1e-4 * x)) / (2e-4 * x)
        };
        let known = vec![
            Known::new("E", Read::E, e, bound),
            Known::new("dE/dx", Read::Move(DVec3::X), slope, GRADIENT).relative_to(scale),
            Known::new("dE/dy", Read::Move(DVec3::Y), 0.0, GRADIENT).relative_to(scale),
        ];
        Site { words: format!("x = {x}"), position, normal: DVec3::Z, known }
    };
    let name = match degrees as u32 {
        5 => "wedge of 5°",
        45 => "wedge of 45°",
        90 => "wedge of 90°",
        135 => "wedge of 135°",
        _ => "wedge of 175°",
    };
    let normal = dvec3(s, 0.0, -c);
    Case { name, scene: lit(&corners, normal), light: (2, 1), sites: [0.1, 0.5, 2.0].map(site).into() }
}

/// Beside a wall without end the harmonic mean distance is R = (3π/2)x: 1/R = 2/(3πx).
fn perpendicular_wall() -> Case {
    let corners = [dvec3(0.0, -HALF, 0.0), dvec3(0.0, HALF, 0.0), dvec3(0.0, HALF, HALF), dvec3(0.0, -HALF, HALF)];
    let site = |x: f64| {
        let inverse = 2.0 / (3.0 * PI * x);
        // The integrand is cosθ/d: texels at the sides, a share of h of all, see the wall or not. Above the wall's end a
        // share of (x/200)² is missing; the capture's lift off the floor is 0.001.
        let bound = Bound::linear(0.25);
        let known = vec![Known::new("1/R", Read::InverseDistance, inverse, bound)];
        Site { words: format!("x = {x}"), position: dvec3(x, 0.0, 0.0), normal: DVec3::Z, known }
    };
    Case {
        name: "perpendicular wall",
        scene: lit(&corners, DVec3::X),
        light: (2, 1),
        sites: [0.1, 0.5, 2.0].map(site).into(),
    }
}

/// A slit of width w at height 1 in a plate without end below a sky: E = πF, F = ½w/√(1 + w²/4).
///
/// The stated limit: with N texels a side nothing narrower than a texel, w < 2/N, is sure to be seen. Turned along the
/// texels and in between their centres, it is lost for certain; one of a few texels is measured as well as any outline.
pub(super) fn slit_limit(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let mut rows = Vec::new();
    for size in SIZES {
        let texel = 2.0 / f64::from(size);
        for (texels, seen) in [(0.9, false), (1.1, true)] {
            let scene = slit(texels * texel);
            let probes = bench.measure(&scene, &[place(DVec3::ZERO, DVec3::Z, 0.0)], size, (4, 1))?;
            let e = f64::from(probes[0].sky.unwrap_or_default().value.x);
            // Beyond the plate, and through the texels of the slit.
            let beyond = PI * (1.0 - HALF / HALF.hypot(1.0)) + 1e-6;
            let is_seen = e > beyond + 0.1 * PI * form_factor::slit(texels * texel, 1.0);
            let quantity = if seen { "columns of texels lost" } else { "light seen" };
            rows.push(Row::none_of(&format!("slit of {texels} texels"), quantity, usize::from(is_seen != seen), size));
        }
    }
    let width = 0.25;
    let expected = PI * form_factor::slit(width, 1.0);
    // Two sides, each ∫ cosθ dl = 2 long; half a texel's diagonal off at most.
    let bound = Bound::linear(4.0 / 2f64.sqrt() / expected);
    let mut row = Row {
        capture: "",
        case: "slit of width 1/4 at height 1".into(),
        quantity: "E of the sky".into(),
        expected,
        got: 0.0,
        errors: Vec::new(),
        bound,
    };
    let places: Vec<_> = (0..super::TURNS).map(|i| place(DVec3::ZERO, DVec3::Z, turn(i))).collect();
    for size in SIZES {
        let probes = bench.measure(&slit(width), &places, size, (4, 1))?;
        let values = probes.iter().map(|p| f64::from(p.sky.unwrap_or_default().value.x));
        let n = f64::from(super::TURNS);
        row.got = values.clone().sum::<f64>() / n;
        row.errors.push((size, (values.map(|v| (v - expected).powi(2)).sum::<f64>() / n).sqrt() / expected));
    }
    rows.push(row);
    Ok(rows)
}

/// Two black plates at height 1 with a gap between them, under a sky of radiance 1.
fn slit(width: f64) -> crate::scene::Scene {
    let mut b = Builder::default();
    let black = b.material(diffuse(0.0));
    let (half, gap) = (HALF as f32, 0.5 * width as f32);
    for side in [-1.0, 1.0] {
        let corner = Vec3::new(if side < 0.0 { -half } else { gap }, -half, 1.0);
        b.quad(black, corner, Vec3::X * (half - gap), Vec3::Y * 2.0 * half);
    }
    b.background(Background::Constant(Vec3::ONE));
    b.build()
}

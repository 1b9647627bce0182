//! Cases of surfaces that are seen against nothing: rectangle, polygon, cube faces, plates, sphere.
//!
//! Captures see emitters as black (their light is direct), so radiance comes from white surfaces lit by a sun of
//! irradiance π at right angles: L = ρE/π = 1.

use super::case::place;
use super::{Bench, Bound, Case, Known, Read, Row, SIZES, Site, turn};
use crate::math::form_factor::{polygon, sphere};
use crate::methods::probes::{Place, ProbeError};
use crate::scene::build::{Builder, Facing, diffuse};
use crate::scene::{Background, Light, Scene};
use glam::{DVec3, Vec3, dvec3};
use std::f64::consts::PI;

/// Gradients: 2 % at 64 texels a side. An outline passes 1/h texels, h = 2/N; at each the edge that stands for it is off by
/// up to half a texel, a share of the order of h in cosθ/r. They are off to either side alike, so that the sum's share is
/// h/√(1/h).
pub(super) const GRADIENT: Bound = Bound { factor: 0.02 * 181.02, order: 1.5, floor: 0.0 };

/// Corners as seen from `p`.
fn seen(corners: &[DVec3], p: DVec3) -> Vec<DVec3> {
    corners.iter().map(|c| *c - p).collect()
}

/// E at `p` from a polygon of radiance 1.
pub(super) fn irradiance(p: DVec3, n: DVec3, corners: &[DVec3]) -> f64 {
    polygon(n, &seen(corners, p))
}

/// ∮ cosθ dl along the polygon's outline above the horizon, as seen from `p`.
fn outline(p: DVec3, n: DVec3, corners: &[DVec3]) -> f64 {
    const PIECES: usize = 256;
    let corners = seen(corners, p);
    let side = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let at = |k: usize| (a + (b - a) * (k as f64 / PIECES as f64)).normalize();
        (0..PIECES).map(|k| at(k).angle_between(at(k + 1)) * n.dot((at(k) + at(k + 1)) * 0.5).max(0.0)).sum::<f64>()
    };
    (0..corners.len()).map(side).sum()
}

/// Bound of E's error: texels along the outline count wholly or not at all, so that it is off by half a texel's diagonal
/// at most, h/√2, all along.
pub(super) fn outline_bound(p: DVec3, n: DVec3, corners: &[DVec3]) -> Bound {
    Bound::linear(outline(p, n, corners) / 2f64.sqrt() / irradiance(p, n, corners))
}

/// Both gradients of E at a site by central differences of the closed form, along two tangents each.
pub(super) fn gradients(p: DVec3, n: DVec3, corners: &[DVec3], length: f64) -> Vec<Known> {
    let (u, v) = n.any_orthonormal_pair();
    let step = 1e-4;
    let moves = |t: DVec3| {
        let at = |s: f64| irradiance(p + t * s * step * length, n, corners);
        (at(1.0) - at(-1.0)) / (2.0 * step * length)
    };
    let turns = |t: DVec3| {
        let at = |s: f64| irradiance(p, (n + t * s * step).normalize(), corners);
        (at(1.0) - at(-1.0)) / (2.0 * step)
    };
    let moved = moves(u).hypot(moves(v));
    let turned = turns(u).hypot(turns(v));
    let named = |name: &str, read, expected, scale| Known::new(name, read, expected, GRADIENT).relative_to(scale);
    vec![
        named(&format!("∇_t E along {u}"), Read::Move(u), moves(u), moved),
        named(&format!("∇_t E along {v}"), Read::Move(v), moves(v), moved),
        named(&format!("dE/dn towards {u}"), Read::Turn(u), turns(u), turned),
        named(&format!("dE/dn towards {v}"), Read::Turn(v), turns(v), turned),
    ]
}

/// A scene of one flat polygon, a fan from its first corner, lit to radiance 1 on the side of `n`.
pub(super) fn lit(corners: &[DVec3], n: DVec3) -> Scene {
    let mut b = Builder::default();
    let white = b.material(diffuse(1.0));
    for pair in corners[1..].windows(2) {
        b.triangle(white, [corners[0], pair[0], pair[1]].map(|c| c.as_vec3()));
    }
    b.light(Light::Directional { direction: -n.as_vec3(), irradiance: Vec3::splat(PI as f32) });
    b.build()
}

pub(super) fn cases() -> Vec<Case> {
    vec![rectangle(), rectangle_ahead(), pentagon(), plates(), sphere_light(), integrating_sphere()]
}

/// A site below a polygon, with all that is known of it.
fn below(words: &str, position: DVec3, normal: DVec3, corners: &[DVec3]) -> Site {
    let e = irradiance(position, normal, corners);
    let mut known = vec![Known::new("E", Read::E, e, outline_bound(position, normal, corners))];
    known.extend(gradients(position, normal, corners, 1.0));
    Site { words: words.into(), position, normal, known }
}

const RECTANGLE: [DVec3; 4] =
    [dvec3(0.3, -0.7, 1.0), dvec3(1.5, -0.7, 1.0), dvec3(1.5, 0.9, 1.0), dvec3(0.3, 0.9, 1.0)];

/// Within what a plane of the usual aperture sees.
fn rectangle_ahead() -> Case {
    let sites = vec![below("from the origin", DVec3::ZERO, DVec3::Z, &RECTANGLE)];
    Case { name: "rectangle ahead", scene: lit(&RECTANGLE, DVec3::NEG_Z), light: (2, 1), sites }
}

fn rectangle() -> Case {
    let site = below("tilted", dvec3(-0.2, 0.1, 0.2), dvec3(0.3, -0.2, 1.0).normalize(), &RECTANGLE);
    Case { name: "rectangle", scene: lit(&RECTANGLE, DVec3::NEG_Z), light: (2, 1), sites: vec![site] }
}

/// Some of it is below the horizon.
fn pentagon() -> Case {
    let corners = [
        dvec3(1.0, -0.8, -0.4),
        dvec3(1.0, 0.3, -0.5),
        dvec3(1.0, 0.9, 0.6),
        dvec3(1.0, 0.1, 1.3),
        dvec3(1.0, -1.0, 0.5),
    ];
    let sites = vec![below("cut by the horizon", DVec3::ZERO, DVec3::Z, &corners)];
    Case { name: "polygon", scene: lit(&corners, DVec3::NEG_X), light: (3, 1), sites }
}

/// Gauss and Legendre's rule of four points on [0, 1]: point and weight.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_7, 0.173_927_422_568_727),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273),
    (0.930_568_155_797_026_3, 0.173_927_422_568_727),
];

/// Form factors between faces of a unit cube: E/π of one face of radiance 1, averaged over another.
pub(super) fn cube_faces(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let opposite = [dvec3(0.0, 0.0, 1.0), dvec3(1.0, 0.0, 1.0), dvec3(1.0, 1.0, 1.0), dvec3(0.0, 1.0, 1.0)];
    let adjacent = [dvec3(0.0, 0.0, 0.0), dvec3(0.0, 1.0, 0.0), dvec3(0.0, 1.0, 1.0), dvec3(0.0, 0.0, 1.0)];
    let points: Vec<(f64, DVec3)> =
        GAUSS.iter().flat_map(|(x, wx)| GAUSS.map(|(y, wy)| (wx * wy, dvec3(*x, y, 0.0)))).collect();
    let places: Vec<Place> = points
        .iter()
        .zip(0..)
        .flat_map(|((_, p), i)| (0..4).map(move |k| place(*p, DVec3::Z, turn(4 * i + k))))
        .collect();
    let mut rows = Vec::new();
    for (name, corners, inwards, expected) in
        [("opposite", opposite, DVec3::NEG_Z, 0.199825), ("adjacent", adjacent, DVec3::X, 0.200044)]
    {
        let scene = lit(&corners, inwards);
        let mean_bound = |(w, p): &(f64, DVec3)| w * outline_bound(*p, DVec3::Z, &corners).factor;
        let mut row = Row {
            capture: "",
            case: format!("{name} face of a cube"),
            quantity: "form factor".into(),
            expected,
            got: 0.0,
            errors: Vec::new(),
            bound: Bound::linear(points.iter().map(mean_bound).sum()),
        };
        for size in SIZES {
            let probes = bench.measure(&scene, &places, size, (2, 1))?;
            let weights = points.iter().flat_map(|(w, _)| [w / 4.0; 4]);
            row.got = probes.iter().zip(weights).map(|(p, w)| w * f64::from(p.reflected.value.x) / PI).sum();
            row.errors.push((size, (row.got / expected - 1.0).abs()));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Plates without end: what the other reflects, M, arrives whole. The finite one's closed form is within 2·10⁻⁴ of M.
fn plates() -> Case {
    let half = 100.0;
    let plate = [dvec3(-half, -half, 0.0), dvec3(half, -half, 0.0), dvec3(half, half, 0.0), dvec3(-half, half, 0.0)];
    let (position, normal) = (dvec3(0.3, 0.2, 1.0), DVec3::NEG_Z);
    let bound = outline_bound(position, normal, &plate);
    let flat = Known::new("∇_t E along x", Read::Move(DVec3::X), 0.0, GRADIENT).relative_to(PI);
    let known = vec![Known::new("E = M", Read::E, PI, bound.and(2e-4)), flat];
    let site = Site { words: "at distance 1".into(), position, normal, known };
    Case { name: "parallel plates", scene: lit(&plate, DVec3::Z), light: (2, 1), sites: vec![site] }
}

/// A white ball under a sky: each of its points sees half of the sky, E = π, and reflects L = 1.
fn sphere_light() -> Case {
    let mut b = Builder::default();
    let white = b.material(diffuse(1.0));
    b.sphere(white, Vec3::ZERO, 0.5, 64, Facing::Out);
    b.background(Background::Constant(Vec3::ONE));
    let site = |words: &str, degrees: f64, distance: f64| {
        let (s, c) = degrees.to_radians().sin_cos();
        let (h, position, normal) = (0.5 / distance, dvec3(0.0, 0.0, -distance), dvec3(s, 0.0, c));
        let e = sphere(h, c);
        // The outline is a circle of angular radius asin h; the sky's 4096 lights and the facets are within 0.3 %.
        let outline = 2.0 * PI * h * c.max(h);
        let bound = Bound::linear(outline / 2f64.sqrt() / e.max(1e-9)).and(3e-3);
        let known = if e > 0.0 {
            Known::new("E", Read::E, e, bound)
        } else {
            Known::new("E", Read::E, 0.0, Bound::flat(0.0)).relative_to(1.0)
        };
        Site { words: words.into(), position, normal, known: vec![known] }
    };
    let sites = vec![
        // A circle about the middle of the texels would be the same at every turn, and turns would average nothing.
        site("nearly overhead", 7.0, 1.0),
        site("inclined", 50.0, 1.0),
        site("cut by the horizon", 75.0, 1.0),
        site("below the horizon", 130.0, 1.0),
        site("far away", 30.0, 5.0),
    ];
    Case { name: "sphere light", scene: b.build(), light: (1 << 14, 1024), sites }
}

/// A point light of intensity 1 inside a sphere of albedo ρ and radius 1: E₁ = ρ everywhere on it, wherever the light is;
/// with the light at the centre all walls are alike, as in a furnace: E₁ = ρ at any place inside, without gradients.
fn integrating_sphere() -> Case {
    let mut b = Builder::default();
    let (grey, rho) = (b.material(diffuse(0.8)), 0.8);
    b.sphere(grey, Vec3::ZERO, 1.0, 64, Facing::In);
    b.light(Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE });
    let facets = Bound::flat(3e-3);
    let site = |words: &str, position: DVec3, normal: DVec3| {
        let (u, v) = normal.any_orthonormal_pair();
        // Radiance ripples over the facets, 0.1 %, and moves in over 1/(1 − |p|).
        let near = rho / (1.0 - position.length());
        let zero = |name: &str, read, scale| Known::new(name, read, 0.0, Bound::flat(0.01)).relative_to(scale);
        let known = vec![
            Known::new("E₁ = ρI/s²", Read::E, rho, facets),
            zero("∇_t E", Read::Move(u), near),
            zero("∇_t E", Read::Move(v), near),
            zero("dE/dn", Read::Turn(u), rho),
            zero("dE/dn", Read::Turn(v), rho),
        ];
        Site { words: words.into(), position, normal, known }
    };
    let sites = vec![
        site("furnace, from the centre", DVec3::ZERO, DVec3::Z),
        site("furnace, halfway out", dvec3(0.3, 0.2, -0.3), dvec3(0.6, 0.0, 0.8)),
    ];
    Case { name: "integrating sphere", scene: b.build(), light: (1 << 16, 1), sites }
}

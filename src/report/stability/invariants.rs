//! Changes that must not change the light, and extremes: single records at 32 texels a side.

use super::area::{irradiance, lit, outline_bound};
use super::case::place;
use super::{Bench, Row, turn};
use crate::math::capture::Projection;
use crate::methods::captures::CaptureMode;
use crate::methods::probes::{Irradiance, Place, Probe, ProbeError};
use crate::scene::build::{Builder, diffuse};
use crate::scene::{Light, Material, Scene, cornell};
use glam::{DVec3, Vec3, Vec4, dvec3, vec3};
use std::f64::consts::PI;

const SIZE: u32 = 32;
/// Cells of the Cornell box and samples of its lamp.
const CELLS: (u32, u32) = (1 << 14, 64);

/// Places in the Cornell box whose coordinates are whole numbers of 2⁻²⁰ metres.
fn places() -> Vec<Place> {
    let at = |x: f64, y: f64, z: f64, n: DVec3, i| place(dvec3(x, y, z), n, turn(i));
    vec![
        at(0.25, 0.0, 0.0625, DVec3::Y, 0),
        at(0.0, 0.25, 0.25, DVec3::X, 1),
        at(0.125, 0.375, 0.125, dvec3(0.0, 0.6, -0.8), 2),
        at(0.5, 0.03125, 0.4375, dvec3(-0.6, 0.8, 0.0), 3),
    ]
}

fn scaled(scene: &Scene, scale: f32) -> Scene {
    let mut scene = scene.clone();
    scene.positions.iter_mut().for_each(|p| *p *= scale);
    scene
}

fn moved(places: &[Place], scale: f32) -> Vec<Place> {
    places.iter().map(|p| Place { position: p.position * scale, ..*p }).collect()
}

/// All numbers of a record, of a world that is `scale` times as large, in those of the original.
fn numbers(probe: &Probe, scale: f32) -> Vec<f32> {
    let light = |l: &Irradiance| {
        let translation = l.translation.map(|t| t * scale);
        [&[l.value][..], &l.rotation, &translation].concat().iter().flat_map(|v| v.to_array()).collect::<Vec<_>>()
    };
    let mut all = light(&probe.reflected);
    all.extend(probe.sky.iter().flat_map(light));
    all.push(probe.inverse_distance * scale);
    all
}

/// Numbers that differ in any bit; two zeros are the same.
fn different(a: &[Probe], b: &[Probe], scale: f32, strength: f32) -> usize {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| {
        let (mut a, b) = (numbers(a, scale), numbers(b, 1.0));
        let light = a.len() - 1;
        a[..light].iter_mut().for_each(|v| *v /= strength);
        a.into_iter().zip(b)
    });
    pairs.filter(|(a, b)| a != b).count()
}

pub(super) fn world_by_powers_of_two(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let (scene, places) = (cornell(), places());
    let reference = bench.measure(&scene, &places, SIZE, CELLS)?;
    [10, -10, 30, -20]
        .map(|power| {
            let scale = 2f32.powi(power);
            let probes = bench.measure(&scaled(&scene, scale), &moved(&places, scale), SIZE, CELLS)?;
            let count = different(&probes, &reference, scale, 1.0);
            Ok(Row::none_of(&format!("world × 2^{power}"), "numbers with other bits", count, SIZE))
        })
        .into_iter()
        .collect()
}

pub(super) fn emission_by_powers_of_two(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let (scene, places) = (cornell(), places());
    let reference = bench.measure(&scene, &places, SIZE, CELLS)?;
    [12, -12, 60, -60]
        .map(|power| {
            let strength = 2f32.powi(power);
            let mut brighter = scene.clone();
            brighter.materials.iter_mut().for_each(|m| m.emission *= strength);
            let probes = bench.measure(&brighter, &places, SIZE, CELLS)?;
            let count = different(&probes, &reference, 1.0, strength);
            Ok(Row::none_of(&format!("emission × 2^{power}"), "numbers with other bits", count, SIZE))
        })
        .into_iter()
        .collect()
}

/// The world at other scales than powers of two: what rounding changes, a texel here and there.
pub(super) fn scales(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let (scene, places) = (cornell(), places());
    let mean = |probes: &[Probe]| probes.iter().map(|p| f64::from(p.reflected.value.x)).sum::<f64>();
    let reference = mean(&bench.measure(&scene, &places, SIZE, CELLS)?);
    [1e-4f32, 1e-2, 1e3, 1e5]
        .map(|scale| {
            let got = mean(&bench.measure(&scaled(&scene, scale), &moved(&places, scale), SIZE, CELLS)?);
            // Four records of 3072 texels: some edge texels may fall to the other side.
            Ok(Row::single(&format!("world × {scale:e}"), "E", [reference, got, reference], SIZE, 2e-3))
        })
        .into_iter()
        .collect()
}

/// The box far from the origin, at places and corners that single precision holds exactly: by 2¹⁷, 10⁵ and some, positions
/// are on a grid of 2⁻⁷. In a box 64 times as large the same shift is on half a unit of the last place of the small one.
pub(super) fn far_origin(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    const SCALE: f32 = 64.0;
    let snapped = |p: Vec3| (p * SCALE * 16.0).round() / 16.0;
    let mut near = cornell();
    near.positions.iter_mut().for_each(|p| *p = snapped(*p));
    let near_places: Vec<Place> = places().iter().map(|p| Place { position: snapped(p.position), ..*p }).collect();
    let e = |shift: Vec3| {
        let mut scene = near.clone();
        scene.positions.iter_mut().for_each(|p| *p += shift);
        let places: Vec<Place> = near_places.iter().map(|p| Place { position: p.position + shift, ..*p }).collect();
        Ok::<_, ProbeError>(mean_of(&bench.measure(&scene, &places, SIZE, CELLS)?, |p| p.reflected.value.x))
    };
    let reference = e(Vec3::ZERO)?;
    [vec3(131_072.0, 0.0, 0.0), vec3(-131_072.0, 131_072.0, 131_072.0)]
        .map(|shift| {
            let got = e(shift)?;
            let case = format!("origin {:.1e} away", shift.length());
            // Directions to corners are off by 2⁻⁸ in some tens of units, 10⁻⁴: a thousandth of a texel of the outlines.
            Ok(Row::single(&case, "E", [reference, got, reference], SIZE, 2e-3))
        })
        .into_iter()
        .collect()
}

fn coloured(color: Vec3) -> Material {
    Material { base_color: Vec4::from((color, 1.0)), ..diffuse(0.0) }
}

const PATCH: [DVec3; 4] = [dvec3(0.3, -0.7, 1.0), dvec3(1.5, -0.7, 1.0), dvec3(1.5, 0.9, 1.0), dvec3(0.3, 0.9, 1.0)];

fn sun(irradiance: f32) -> Light {
    Light::Directional { direction: Vec3::Z, irradiance: Vec3::splat(irradiance) }
}

fn mean_of(probes: &[Probe], of: impl Fn(&Probe) -> f32) -> f64 {
    probes.iter().map(|p| f64::from(of(p))).sum::<f64>() / probes.len() as f64
}

fn all_turns(position: DVec3, count: u32) -> Vec<Place> {
    (0..count).map(|i| place(position, DVec3::Z, turn(i))).collect()
}

/// A patch of radiance 10⁶ beside one of radiance 1 of another colour: neither takes from the other.
pub(super) fn radiance_range(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let mirrored = PATCH.map(|c| dvec3(-c.x, c.y, c.z));
    let mut b = Builder::default();
    let (red, blue) = (b.material(coloured(Vec3::X)), b.material(coloured(Vec3::Z * 1e-6)));
    for (material, corners) in [(red, PATCH), (blue, mirrored)] {
        let [a, b_, c, d] = corners.map(|c| c.as_vec3());
        b.triangle(material, [a, b_, c]);
        b.triangle(material, [a, c, d]);
    }
    b.light(sun(1e6 * PI as f32));
    let probes = bench.measure(&b.build(), &all_turns(DVec3::ZERO, 24), SIZE, (4, 1))?;
    let row = |name: &str, corners: &[DVec3], strength: f64, got: f64| {
        let expected = strength * irradiance(DVec3::ZERO, DVec3::Z, corners);
        let tolerance = outline_bound(DVec3::ZERO, DVec3::Z, corners).at(SIZE) / 24f64.sqrt();
        Row::single("radiance 10⁶ : 1", name, [expected, got, expected], SIZE, tolerance)
    };
    Ok(vec![
        row("E of the bright patch", &PATCH, 1e6, mean_of(&probes, |p| p.reflected.value.x)),
        row("E of the dim patch", &mirrored, 1.0, mean_of(&probes, |p| p.reflected.value.z)),
    ])
}

/// Light down to what single precision barely holds: no NaN, never negative; exact as long as numbers are normal.
pub(super) fn near_black(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let scene = |strength: f32| {
        let mut scene = lit(&PATCH, DVec3::NEG_Z);
        scene.lights = vec![sun(strength * PI as f32)];
        scene
    };
    let places = all_turns(DVec3::ZERO, 4);
    let mut rows = Vec::new();
    for strength in [1e-30f32, 1e-37, 1e-40, 1e-44, 0.0] {
        let probes = bench.measure(&scene(strength), &places, SIZE, (2, 1))?;
        let wrong =
            |p: &&Probe| numbers(p, 1.0).iter().any(|v| !v.is_finite()) || p.reflected.value.min_element() < 0.0;
        let count = probes.iter().filter(wrong).count();
        rows.push(Row::none_of(&format!("radiance {strength:e}"), "records that are no numbers", count, SIZE));
    }
    Ok(rows)
}

/// A wall without thickness between a light of 10⁶ and the dark: records on both sides of it, and in front of a block.
/// The wall is wider than what it shadows, so that its outline has no part in this.
pub(super) fn thin_wall(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    b.quad(white, vec3(0.0, -10.0, -10.0), Vec3::Y * 20.0, Vec3::Z * 20.0);
    b.quad(white, vec3(-1.0, -1.0, -1.0), Vec3::Y * 2.0, Vec3::Z * 2.0);
    b.quad(white, vec3(1.0, -1.0, -1.0), Vec3::Y * 2.0, Vec3::Z * 2.0);
    b.light(Light::Point { position: vec3(0.5, 0.1, 0.0), intensity: Vec3::splat(1e6) });
    let sides = |x: f64, n: DVec3| (0..8).map(move |i| place(dvec3(x, 0.2, 0.3 - 0.1 * f64::from(i)), n, turn(i)));
    let dark: Vec<Place> = sides(0.0, DVec3::NEG_X).chain(sides(-1.0, DVec3::X)).collect();
    let bright: Vec<Place> = sides(0.0, DVec3::X).collect();
    let scene = b.build();
    let light = |p: &&Probe| p.reflected.value != Vec3::ZERO;
    let leaks = bench.measure(&scene, &dark, SIZE, (1 << 12, 1))?.iter().filter(light).count();
    let lost = bench.measure(&scene, &bright, SIZE, (1 << 12, 1))?.iter().filter(|p| !light(p)).count();
    Ok(vec![
        Row::none_of("thin wall, 10⁶ on its other side", "records with light", leaks, SIZE),
        Row::none_of("thin wall, its lit side", "records without light", lost, SIZE),
    ])
}

/// Two closed rooms that share a wall, and so its corners and edges, without thickness; 10⁶ in one of them. Records in the
/// other stand in its corners and beside the shared edges.
pub(super) fn two_rooms(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let mut b = Builder::default();
    let white = b.material(diffuse(0.8));
    let square = |b: &mut Builder, corner: Vec3, u: Vec3, v: Vec3| b.quad(white, corner, u, v);
    for x in [-1.0, 0.0] {
        for at in [0.0, 1.0] {
            square(&mut b, vec3(x, at, 0.0), Vec3::X, Vec3::Z);
            square(&mut b, vec3(x, 0.0, at), Vec3::X, Vec3::Y);
        }
    }
    for x in [-1.0, 0.0, 1.0] {
        square(&mut b, vec3(x, 0.0, 0.0), Vec3::Y, Vec3::Z);
    }
    b.light(Light::Point { position: vec3(0.5, 0.4, 0.6), intensity: Vec3::splat(1e6) });
    let scene = b.build();
    let room = |sign: f64| {
        let floor = (0..64).map(move |i| {
            let along = (0.5 + f64::from(i) * 0.618_034).fract();
            let away = 10f64.powf(-1.0 - 4.0 * f64::from(i) / 64.0);
            place(dvec3(sign * away, 0.0, along), DVec3::Y, turn(i))
        });
        let wall = (0..64).map(move |i| {
            let along = (0.5 + f64::from(i) * 0.618_034).fract();
            let away = 10f64.powf(-1.0 - 4.0 * f64::from(i) / 64.0);
            place(dvec3(0.0, away, along), DVec3::X * sign, turn(i))
        });
        floor.chain(wall).collect::<Vec<_>>()
    };
    let light = |p: &&Probe| p.reflected.value != Vec3::ZERO;
    let most = |probes: &[Probe]| probes.iter().map(|p| f64::from(p.reflected.value.x)).fold(0.0, f64::max);
    let dark = bench.measure(&scene, &room(-1.0), SIZE, (1 << 12, 1))?;
    let bright = bench.measure(&scene, &room(1.0), SIZE, (1 << 12, 1))?;
    let lost = bright.iter().filter(|p| !light(p)).count();
    // Beside the shared edge a rasteriser's fixed-point sides may lose the wall's foot: at most a side's lowest row of
    // texels, ¼ sin²h of the hemisphere. In compute nothing is lost.
    let row_of_texels = 0.25 * (2.0 / f64::from(SIZE)).sin().powi(2);
    let tolerance = if bench.capture == CaptureMode::Compute { 0.0 } else { row_of_texels };
    let leak = [0.0, most(&dark), most(&bright)];
    Ok(vec![
        Row::single("two rooms, 10⁶ in the other", "E, in parts of the other's", leak, SIZE, tolerance),
        Row::none_of("two rooms, the lit one", "records without light", lost, SIZE),
    ])
}

/// The rectangle cut into 2048 needles: not a texel is lost between them.
pub(super) fn needles(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    const COUNT: usize = 1024;
    let mut b = Builder::default();
    let white = b.material(diffuse(1.0));
    let [a, b_, c, d] = PATCH;
    let at = |from: DVec3, to: DVec3, i: usize| (from + (to - from) * (i as f64 / COUNT as f64)).as_vec3();
    for i in 0..COUNT {
        let (p, q, r, s) = (at(a, d, i), at(b_, c, i), at(b_, c, i + 1), at(a, d, i + 1));
        b.triangle(white, [p, q, r]);
        b.triangle(white, [p, r, s]);
    }
    b.light(sun(PI as f32));
    let places = all_turns(DVec3::ZERO, 8);
    let whole = mean_of(&bench.measure(&lit(&PATCH, DVec3::NEG_Z), &places, SIZE, (2, 1))?, |p| p.reflected.value.x);
    let needles = mean_of(&bench.measure(&b.build(), &places, SIZE, (2048, 1))?, |p| p.reflected.value.x);
    // Rounding, to 1/16 of a texel on some devices, may give a texel on the outline of one turn in eight to the other side.
    let width = match bench.capture.projection() {
        Projection::Plane { half_width, .. } => 2.0 * half_width / f64::from(SIZE),
        _ => 2.0 / f64::from(SIZE),
    };
    let tolerance = width * width / (whole * places.len() as f64);
    Ok(vec![Row::single("rectangle of 2048 needles", "E", [whole, needles, whole], SIZE, tolerance)])
}

/// Triangles without area, without a normal, or in the place of another: as if they were not there, and the same each time.
pub(super) fn bad_triangles(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    let places = all_turns(DVec3::ZERO, 4);
    let clean = bench.measure(&lit(&PATCH, DVec3::NEG_Z), &places, SIZE, (2, 1))?;
    let with = |extra: &[[Vec3; 3]]| {
        let mut b = Builder::default();
        let white = b.material(diffuse(1.0));
        let [p, q, r, s] = PATCH.map(|c| c.as_vec3());
        [[p, q, r], [p, r, s]].iter().chain(extra).for_each(|t| b.triangle(white, *t));
        b.light(sun(PI as f32));
        b.build()
    };
    let [p, q, r, s] = PATCH.map(|c| c.as_vec3());
    let point = vec3(0.1, 0.1, 0.5);
    let flat = with(&[[point; 3], [point, point, q], [point, point * 2.0, point * 3.0]]);
    let twice = with(&[[p, q, r], [p, r, s]]);
    let mut rows = Vec::new();
    for (name, scene) in [("triangles without area or normal", flat), ("triangles twice in one place", twice)] {
        let [first, again] = [0, 1].map(|_| bench.measure(&scene, &places, SIZE, (4, 1)));
        let (first, again) = (first?, again?);
        let e = |probes: &[Probe]| mean_of(probes, |p| p.reflected.value.x);
        rows.push(Row::single(name, "E", [e(&clean), e(&first), e(&clean)], SIZE, 1e-5));
        rows.push(Row::none_of(name, "numbers that change", different(&first, &again, 1.0, 1.0), SIZE));
    }
    Ok(rows)
}

/// A light of a quarter of a texel's width: a record sees a texel of it or nothing, and the mean over many places is right.
pub(super) fn small_light(bench: &Bench) -> Result<Vec<Row>, ProbeError> {
    const MANY: u32 = 4096;
    let side = 0.5 / f64::from(SIZE);
    let corner = dvec3(0.3, 0.2, 1.0);
    let corners = [corner, corner + DVec3::X * side, corner + dvec3(side, side, 0.0), corner + DVec3::Y * side];
    // Roberts 2018's R2 sequence, over a square of eight texels.
    let around = |i: u32| (dvec3(0.754_877_666, 0.569_840_291, 0.0) * f64::from(i)).fract() * (16.0 / f64::from(SIZE));
    let places: Vec<Place> = (0..MANY).map(|i| place(around(i), DVec3::Z, turn(i))).collect();
    let probes = bench.measure(&lit(&corners, DVec3::NEG_Z), &places, SIZE, (2, 1))?;
    let known = |i: u32| irradiance(around(i), DVec3::Z, &corners);
    let expected = (0..MANY).map(known).sum::<f64>() / f64::from(MANY);
    let got = mean_of(&probes, |p| p.reflected.value.x);
    let square = |(probe, i): (&Probe, u32)| (f64::from(probe.reflected.value.x) - known(i)).powi(2);
    let standard_error = (probes.iter().zip(0..).map(square).sum::<f64>()).sqrt() / f64::from(MANY);
    let broken = |p: &&Probe| numbers(p, 1.0).iter().any(|v| !v.is_finite());
    Ok(vec![
        Row::single("light of 1/16 texel", "mean E", [expected, got, expected], SIZE, 3.0 * standard_error / expected),
        Row::none_of("light of 1/16 texel", "records that are no numbers", probes.iter().filter(broken).count(), SIZE),
    ])
}

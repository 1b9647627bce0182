//! The leak guard: a dark room with thin walls, bright light outside, in closed form.

use super::{ALL, by, common, first, points};
use crate::volume::Reader;
use crate::volume::place::{Common, Measured, uniform};
use glam::{DVec3, UVec3, dvec3};
use std::convert::Infallible;

/// Distance along a ray to a room's walls of 5 cm, from outside or from inside, and to the ground; or 20.
fn to_walls(from: DVec3, way: DVec3) -> f64 {
    let [low, high] = ROOM;
    let slab = |low: DVec3, high: DVec3| {
        let (a, b) = ((low - from) / way, (high - from) / way);
        (a.min(b).max_element(), a.max(b).min_element())
    };
    let (_, leaves) = slab(low, high);
    if from.cmpgt(low).all() && from.cmplt(high).all() {
        return leaves;
    }
    let (enters, leaves) = slab(low - 0.05, high + 0.05);
    let ground = if way.y < 0.0 { -from.y / way.y } else { 20.0 };
    if enters < leaves && enters > 0.0 { enters.min(ground) } else { ground }.min(20.0)
}

const ROOM: [DVec3; 2] = [dvec3(-1.13, 0.62, -1.08), dvec3(1.07, 2.82, 1.12)];

fn behind_walls(place: DVec3, ways: &[(DVec3, f64)]) -> Measured {
    let mut seen = vec![crate::volume::place::Seen::default(); crate::math::octahedron::CELLS];
    let mut whole = vec![0.0; seen.len()];
    let mut sums = vec![[0.0; 2]; seen.len()];
    for (way, weight) in ways {
        let (cell, r) = (crate::math::octahedron::cell(*way), to_walls(place, *way));
        whole[cell] += weight / (r * r);
        sums[cell][0] += weight / r;
        sums[cell][1] += weight;
    }
    for ((seen, sum), whole) in seen.iter_mut().zip(sums).zip(whole) {
        seen.moments = sum.map(|sum| (sum / whole) as f32);
    }
    let is_in = place.cmpgt(ROOM[0]).all() && place.cmplt(ROOM[1]).all();
    let light = glam::Vec3::splat(if is_in { 0.0 } else { 1.0 });
    Measured { coefficients: vec![light; 4], gradients: vec![[glam::Vec3::ZERO; 3]; 4], seen, ..Measured::default() }
}

/// Bright outside, dark inside, samples half a metre apart, wherever the room stands on their grid.
#[test]
fn walls_keep_light_out() {
    let ways = crate::math::sh::sphere_rule(60);
    for shift in [DVec3::ZERO, dvec3(0.2, 0.05, 0.11), dvec3(0.31, 0.16, 0.27)] {
        // The outermost samples are half a metre apart 5 cm inside; none stands in a wall.
        let bounds = [dvec3(-2.05, -0.05, -2.05) + shift, dvec3(2.05, 4.05, 2.05) + shift];
        let common = Common { bounds, moments: true, ..common() };
        let mut look =
            |places: &[DVec3]| Ok::<_, Infallible>(places.iter().map(|place| behind_walls(*place, &ways)).collect());
        let (volume, _) = uniform(&common, UVec3::splat(9), &mut look).unwrap();
        let reader = Reader::new(&volume);
        for way in ALL {
            let (mut bright, mut mean) = (0, 0.0);
            for point in points(10_000) {
                let t = (point - super::common().bounds[0]) / (super::common().bounds[1] - super::common().bounds[0]);
                let point = ROOM[0] + 0.05 + t * (ROOM[1] - ROOM[0] - 0.1);
                let light = first(&reader.read(point, by(way)).unwrap());
                mean += light / 1e4;
                bright += u32::from(light > 0.01);
            }
            eprintln!("{shift} {way:?}: {:.4} % in the mean, {bright} of 10,000 points above 1 %", 1e2 * mean);
            assert!(mean < 1e-3 && bright < 100, "{way:?}: {mean} {bright}");
        }
    }
}

//! Emissive triangles as samples: where their shadows are looked from, and which samples belong to which triangle.

use super::light_set::{Extent, Face, LightSet, NEAR, brightness, frame, with};
use crate::math::sequence::triangle_point;
use crate::scene::{Emitter, Scene};
use crate::vk::gpu_types::LightSample;
use std::f32::consts::PI;

/// Most emitting sides of triangles that have samples of their own; beyond it, samples are shared out by power alone.
pub const MOST_FACES: usize = 1024;

/// A side of an emissive triangle, and its power but for π.
struct Side {
    emitter: Emitter,
    back: bool,
    power: f64,
}

/// Cuts the emitters into about `count` samples.
///
/// Each side that shines has its share by power, and one at least; within a triangle they follow the triangular van der
/// Corput sequence. Above [`MOST_FACES`] sides the samples step through the cumulated power instead (systematic sampling).
pub(super) fn add_emitters(scene: &Scene, extent: Extent, count: u32, set: &mut LightSet) {
    let sides: Vec<Side> = scene.emitters().into_iter().flat_map(sides).collect();
    let total: f64 = sides.iter().map(|side| side.power).sum();
    if total <= 0.0 {
        return;
    }
    if sides.len() > MOST_FACES {
        return add_by_power(scene, extent, count, (&sides, total), set);
    }
    for side in &sides {
        let own = (f64::from(count) * side.power / total).round().max(1.0) as u32;
        let first = set.samples.len() as u32;
        for index in 0..own {
            add_sample(scene, extent, side, index, side.emitter.area / own as f32, set);
        }
        let [a, b, c] = scene.corners(side.emitter.triangle);
        let corners = if side.back { [a, c, b] } else { [a, b, c] };
        set.faces.push(Face { corners, samples: first..first + own });
    }
}

fn sides(emitter: Emitter) -> impl Iterator<Item = Side> {
    let power = f64::from(brightness(emitter.radiance) * emitter.area);
    let backs = if emitter.double_sided { 0..2 } else { 0..1 };
    backs.map(move |back| Side { emitter, back: back == 1, power })
}

fn add_by_power(scene: &Scene, extent: Extent, count: u32, (sides, total): (&[Side], f64), set: &mut LightSet) {
    let (mut at, mut passed, mut taken) = (0, 0.0, 0);
    for index in 0..count {
        let target = (f64::from(index) + 0.5) / f64::from(count) * total;
        while at + 1 < sides.len() && passed + sides[at].power <= target {
            passed += sides[at].power;
            (at, taken) = (at + 1, 0);
        }
        // Area that the sample stands for: 1/(count · pdf), pdf = (power/total)/area.
        let area = (total / (f64::from(count) * sides[at].power)) as f32 * sides[at].emitter.area;
        add_sample(scene, extent, &sides[at], taken, area, set);
        taken += 1;
    }
}

/// Adds point `index` of a triangle, which stands for `area`.
fn add_sample(scene: &Scene, extent: Extent, side: &Side, index: u32, area: f32, set: &mut LightSet) {
    let point = scene.surface(side.emitter.triangle, triangle_point(index));
    let normal = if side.back { -point.geometric_normal } else { point.geometric_normal };
    let origin = point.position + normal * (extent.radius * NEAR);
    let mut view = frame(origin, normal, extent.radius * NEAR, set.guard());
    view.horizon = with(normal, -normal.dot(origin));
    let sample = LightSample {
        position: with(point.position, area / PI),
        direction: with(normal, 0.0),
        power: with(point.emission * area, 0.0),
    };
    set.push(view, sample);
}

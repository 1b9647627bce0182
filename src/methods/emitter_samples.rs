//! Emissive triangles as samples: where their shadows are looked from, and which samples belong to which triangle.

use super::far_view::{FarViews, Seen};
use super::light_set::{Extent, Face, LightSet, for_shell, frame, with};
use crate::math::sequence::triangle_point;
use crate::scene::emission::piece_corners;
use crate::scene::{Emitter, Scene};
use crate::vk::gpu_types::LightSample;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Most emitting sides of triangles that have samples of their own; beyond it, samples are shared out by power alone.
pub const MOST_FACES: usize = 1024;
/// Most samples of more sides than that, and the texels a side of their shadow views.
const MOST_SHARED: u32 = 2048;
const SHARED_SHADOW_SIZE: u32 = 128;
/// Pieces of emissive triangles with textures or masks that are looked at, all together.
const MOST_PIECES: u64 = 1 << 23;

/// Samples of emitters by what they are like: `even` ones shine alike all over and have faces, the others are samples alone;
/// `far` ones are far from all that they light.
pub(super) struct EmitterSets {
    pub even: LightSet,
    pub uneven: LightSet,
    pub far_even: LightSet,
    pub far_uneven: LightSet,
}

/// A side of an emissive triangle, and its power but for π.
struct Side {
    emitter: Emitter,
    back: bool,
    power: f64,
}

/// Cuts the emitters into about `count` samples.
///
/// Each side that shines has its share by power, and one at least; within a triangle of one radiance they follow the triangular
/// van der Corput sequence, within others they are where its texels shine. Above [`MOST_FACES`] sides, samples step through the
/// cumulated power instead (systematic sampling), in an order in which neighbours in place follow each other.
pub(super) fn add_emitters(scene: &Scene, extent: Extent, views: &FarViews, count: u32, sets: &mut EmitterSets) {
    let emitters = scene.emitters();
    let varying = emitters.iter().filter(|e| scene.emission_varies(e.triangle)).count() as u64;
    let level = (MOST_PIECES / varying.max(1)).max(1).ilog2() / 2;
    let many = emitters.iter().map(|e| 1 + usize::from(e.double_sided)).sum::<usize>() > MOST_FACES;
    let mut sides = Vec::new();
    for mut emitter in emitters {
        // The mean over all pieces that samples are taken from. Of many each is small.
        let pieces = (!many && scene.emission_varies(emitter.triangle)).then(|| pieces(scene, &emitter, level));
        if let Some(pieces) = &pieces {
            emitter.radiance = pieces.iter().sum::<Vec3>() / pieces.len() as f32;
        }
        let power = f64::from(emitter.radiance.max_element() * emitter.area);
        let backs = if emitter.double_sided { 0..2 } else { 0..1 };
        if power > 0.0 {
            sides.extend(backs.map(|back| Side { emitter, back: back == 1, power }));
        }
    }
    let total: f64 = sides.iter().map(|side| side.power).sum();
    if total <= 0.0 {
        return;
    }
    let place = Placing { scene, extent, views };
    if many {
        let count = count.max(MOST_SHARED.min(sides.len() as u32));
        return place.add_by_power(count, (sides, total), sets);
    }
    for side in &sides {
        let own = (f64::from(count) * side.power / total).round().max(1.0) as u32;
        for seen in views.seen(&scene.corners(side.emitter.triangle)) {
            let (even, uneven) = sets.of(seen);
            if scene.emission_varies(side.emitter.triangle) {
                place.add_pieces((side, seen), own, level, uneven);
            } else {
                place.add_face((side, seen), own, even);
            }
        }
    }
}

impl EmitterSets {
    fn of(&mut self, seen: Seen<'_>) -> (&mut LightSet, &mut LightSet) {
        match seen {
            Seen::Towards(_) => (&mut self.far_even, &mut self.far_uneven),
            Seen::Around(_) => (&mut self.even, &mut self.uneven),
        }
    }
}

fn pieces(scene: &Scene, emitter: &Emitter, most: u32) -> Vec<Vec3> {
    scene.emission_of_pieces(emitter.triangle, scene.emission_level(emitter.triangle, most))
}

/// Where samples are placed.
struct Placing<'a> {
    scene: &'a Scene,
    extent: Extent,
    views: &'a FarViews,
}

impl Placing<'_> {
    fn add_by_power(&self, count: u32, (mut sides, total): (Vec<Side>, f64), sets: &mut EmitterSets) {
        let [low, high] = self.extent.bounds;
        sides.sort_by_cached_key(|side| {
            let [a, b, c] = self.scene.corners(side.emitter.triangle);
            let at = ((a + b + c) / 3.0 - low) / (high - low).max(Vec3::splat(f32::MIN_POSITIVE));
            (morton(at), side.emitter.triangle, side.back)
        });
        for set in [&mut sets.uneven, &mut sets.far_uneven] {
            set.shadow_size = set.shadow_size.min(SHARED_SHADOW_SIZE);
        }
        let (mut at, mut passed, mut taken) = (0, 0.0, 0);
        for index in 0..count {
            let target = (f64::from(index) + 0.5) / f64::from(count) * total;
            while at + 1 < sides.len() && passed + sides[at].power <= target {
                passed += sides[at].power;
                (at, taken) = (at + 1, 0);
            }
            let side = &sides[at];
            // Area that the sample stands for: 1/(count · pdf), pdf = (power/total)/area.
            let area = (total / (f64::from(count) * side.power)) as f32 * side.emitter.area;
            for seen in self.views.seen(&self.scene.corners(side.emitter.triangle)) {
                let uneven = sets.of(seen).1;
                self.add((side, seen), triangle_point(taken), side.emitter.radiance, area, uneven);
                // Its disc is the triangle's own: a larger one would dim what is near.
                if let Some(sample) = uneven.samples.last_mut() {
                    sample.position[3] = sample.position[3].min(side.emitter.area / PI);
                }
            }
            taken += 1;
        }
    }

    /// Adds `own` samples of a triangle that shines alike all over, as a face.
    fn add_face(&self, (side, seen): (&Side, Seen<'_>), own: u32, set: &mut LightSet) {
        let first = set.samples.len() as u32;
        let Emitter { triangle, radiance, area, .. } = side.emitter;
        (0..own).for_each(|index| self.add((side, seen), triangle_point(index), radiance, area / own as f32, set));
        let [a, b, c] = self.scene.corners(triangle);
        let corners = if side.back { [a, c, b] } else { [a, b, c] };
        set.faces.push(Face { corners, samples: first..first + own });
    }

    /// Adds `own` samples where the pieces of a triangle shine, each as bright as the others; their colours sum to the whole.
    fn add_pieces(&self, (side, seen): (&Side, Seen<'_>), own: u32, most: u32, set: &mut LightSet) {
        let triangle = side.emitter.triangle;
        let level = self.scene.emission_level(triangle, most);
        let pieces = self.scene.emission_of_pieces(triangle, level);
        let weight = |piece: Vec3| f64::from(piece.max_element());
        let total: f64 = pieces.iter().map(|piece| weight(*piece)).sum();
        let (mut at, mut passed, mut chosen) = (0, 0.0, Vec::new());
        for index in 0..own {
            let target = (f64::from(index) + 0.5) / f64::from(own) * total;
            while at + 1 < pieces.len() && passed + weight(pieces[at]) <= target {
                passed += weight(pieces[at]);
                at += 1;
            }
            chosen.push(at);
        }
        let piece_area = f64::from(side.emitter.area) / pieces.len() as f64;
        let area = |piece: Vec3| (total / weight(piece) / f64::from(own) * piece_area) as f32;
        let sum: Vec3 = chosen.iter().map(|i| pieces[*i] * area(pieces[*i])).sum();
        let whole = side.emitter.radiance * side.emitter.area;
        let share = Vec3::select(sum.cmpgt(Vec3::ZERO), whole / sum.max(Vec3::splat(f32::MIN_POSITIVE)), Vec3::ONE);
        for i in chosen {
            let centre = piece_corners(i as u32, level).iter().sum::<glam::DVec3>() / 3.0;
            let at = Vec2::new(centre.y as f32, centre.z as f32);
            self.add((side, seen), at, pieces[i] * share, area(pieces[i]), set);
        }
    }

    /// Adds a sample of that radiance which stands for `area`.
    fn add(&self, (side, seen): (&Side, Seen<'_>), at: Vec2, radiance: Vec3, area: f32, set: &mut LightSet) {
        let point = self.scene.surface(side.emitter.triangle, at);
        let normal = if side.back { -point.geometric_normal } else { point.geometric_normal };
        let near = self.extent.near(point.position);
        let origin = point.position + normal * near;
        let mut view = match seen {
            Seen::Towards(receivers) => receivers.view(origin, near),
            Seen::Around(_) => frame(origin, normal, near, set.guard()),
        };
        view.horizon = with(normal, -normal.dot(origin));
        let sample = LightSample {
            position: with(point.position, area / PI),
            direction: with(normal, 0.0),
            power: with(radiance * area, 0.0),
            ..LightSample::default()
        };
        set.push(view, for_shell(sample, seen));
    }
}

/// The bits of three coordinates in [0, 1] in turn, ten of each (Morton 1966).
fn morton(at: Vec3) -> u32 {
    let spread = |x: f32| (0..10).map(|i| ((x * 1023.0) as u32 >> i & 1) << (3 * i)).sum::<u32>();
    spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
}

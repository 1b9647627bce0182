//! Cascades of parallel shadow views: what is small and lies together in a far larger scene has views of its own, as fine there as
//! if nothing else were (cascaded shadow maps, Dimitrov 2007).

use super::light_set::{Extent, LightSet, parallel_frame, parallel_sample, with};
use crate::scene::Scene;
use crate::vk::gpu_types::{Frame, LightSample};
use glam::Vec3;

/// A triangle is detail if it reaches less far from its middle than this share of the scene's radius.
const DETAIL: f32 = 1.0 / 64.0;
/// Detail that fills more of the scene than this share of its radius has no views of its own.
const APART: f32 = 1.0 / 8.0;
/// Radius of the innermost view, in radii of the detail.
const MARGIN: f32 = 2.0;
/// Radius of each further view, in radii of the one within.
const STEP: f32 = 8.0;

/// Concentric balls, each with a shadow view of what lies in it and not in the next smaller one.
#[derive(Clone, Debug)]
pub struct Cascades {
    centre: Vec3,
    /// Radii of the balls, from within; outside of the last lies the rest of the scene.
    radii: Vec<f32>,
    extent: Extent,
}

impl Cascades {
    /// Of `scene`: none but the whole, unless all of its detail lies together.
    pub fn of(scene: &Scene, extent: Extent) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| scene.positions[v as usize]);
        let is_detail = |t: &[Vec3; 3]| {
            let middle = t.iter().sum::<Vec3>() / 3.0;
            t.iter().all(|corner| corner.distance(middle) < DETAIL * extent.radius)
        };
        let detail = scene.triangles.iter().map(corners).filter(is_detail).flatten();
        let grown = |(low, high): (Vec3, Vec3), p: Vec3| (low.min(p), high.max(p));
        let (low, high) = detail.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), grown);
        let (centre, radius) = ((low + high) * 0.5, 0.5 * (high - low).length());
        let mut cascades = Self { centre, radii: Vec::new(), extent };
        if radius > 0.0 && radius < APART * extent.radius {
            let radii = std::iter::successors(Some(MARGIN * radius), |r| Some(STEP * r));
            cascades.radii.extend(radii.take_while(|r| *r < 0.5 * extent.radius));
        }
        cascades
    }

    /// Adds light of irradiance `irradiance` that goes along `direction`: a sample for each cascade.
    pub fn push(&self, direction: Vec3, irradiance: Vec3, set: &mut LightSet) {
        let mut inner = 0.0;
        for outer in self.radii.iter().copied() {
            set.push(self.view(direction, outer), self.sample(direction, irradiance, [inner, outer]));
            inner = outer;
        }
        let whole = parallel_frame(direction, self.extent);
        set.push(whole, self.sample(direction, irradiance, [inner, 0.0]));
    }

    /// Samples that each light has.
    pub fn count(&self) -> u32 {
        self.radii.len() as u32 + 1
    }

    fn sample(&self, direction: Vec3, irradiance: Vec3, [inner, outer]: [f32; 2]) -> LightSample {
        let sample = parallel_sample(direction, irradiance);
        if inner == 0.0 && outer == 0.0 {
            return sample;
        }
        LightSample { position: with(self.centre, outer), direction: with(direction, inner), ..sample }
    }

    /// A view of the ball of radius `outer`, deep enough for all that stands before it.
    fn view(&self, direction: Vec3, outer: f32) -> Frame {
        let view = parallel_frame(direction, self.extent);
        let origin = Vec3::from_slice(&view.origin[..3]);
        let to_centre = self.centre - origin;
        let aside = to_centre - direction * direction.dot(to_centre);
        let scale = 1.0 / (1.02 * outer);
        let [tangent, bitangent] = [view.tangent, view.bitangent].map(|[x, y, z, _]| [x, y, z, scale]);
        Frame { origin: with(origin + aside, 0.0), tangent, bitangent, ..view }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::{shadow::LightKind, views::Views};
    use crate::scene::build::{Builder, Facing, diffuse};

    fn cascades(ground: f32) -> Cascades {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, ground);
        b.cuboid(grey, Vec3::new(3.0, 0.0, -1.0), Vec3::new(5.0, 2.0, 1.0), Facing::Out);
        let scene = b.build();
        let (low, high) = scene.bounds();
        Cascades::of(&scene, Extent { bounds: [low, high], radius: 0.5 * (high - low).length() })
    }

    /// Each point of the scene belongs to one cascade; a scene that is no larger than its detail has one.
    #[test]
    fn shells_follow_one_another() {
        assert_eq!(cascades(4.0).count(), 1);
        let all = cascades(1e4);
        let mut set = LightSet::empty("sun", LightKind::Directional, Views::Orthographic, 64);
        all.push(Vec3::NEG_Y, Vec3::ONE, &mut set);
        assert_eq!((set.samples.len() as u32, all.count()), (5, 5));
        let shells: Vec<_> = set.samples.iter().map(|s| (s.direction[3], s.position[3])).collect();
        assert!(shells.windows(2).all(|pair| pair[0].1 == pair[1].0 && pair[0].1 > pair[0].0), "{shells:?}");
        assert_eq!((shells[0].0, shells[4].1), (0.0, 0.0));
        assert!((Vec3::from_slice(&set.samples[0].position[..3]) - Vec3::new(4.0, 1.0, 0.0)).length() < 1e-3);
    }
}

//! Cascades of parallel shadow views: the core of a far larger scene has views of its own, as fine there
//! as if nothing else were (cascaded shadow maps, Dimitrov 2007).

use super::far_view::MARGIN;
use super::light_set::{Extent, LightSet, parallel_frame, parallel_sample, parallel_view};
use crate::math::core::Core;
use crate::vk::gpu_types::LightSample;
use glam::Vec3;

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
    /// Of a scene: none but the whole, unless it has a core.
    pub fn of(extent: Extent) -> Self {
        let Core { centre, radius, is_apart } = extent.core;
        let first = is_apart.then_some(MARGIN * radius);
        let radii = std::iter::successors(first, |r| Some(STEP * r)).take_while(|r| *r < 0.5 * extent.radius).collect();
        Self { centre, radii, extent }
    }

    /// Adds light of irradiance `irradiance` that goes along `direction`: a sample for each cascade.
    pub fn push(&self, direction: Vec3, irradiance: Vec3, set: &mut LightSet) {
        let mut inner = 0.0;
        for outer in self.radii.iter().copied() {
            set.push(
                parallel_view(direction, self.extent, self.centre, outer),
                Self::sample(direction, irradiance, [inner, outer]),
            );
            inner = outer;
        }
        let whole = parallel_frame(direction, self.extent);
        set.push(whole, Self::sample(direction, irradiance, [inner, 0.0]));
    }

    /// Samples that each light has.
    pub fn count(&self) -> u32 {
        self.radii.len() as u32 + 1
    }

    fn sample(direction: Vec3, irradiance: Vec3, [inner, outer]: [f32; 2]) -> LightSample {
        LightSample { shell: [inner, outer, 0.0, 0.0], ..parallel_sample(direction, irradiance) }
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
        Cascades::of(Extent { bounds: [low, high], radius: 0.5 * (high - low).length(), core: scene.core() })
    }

    /// Each point of the scene belongs to one cascade; a scene that is no larger than its detail has one.
    #[test]
    fn shells_follow_one_another() {
        assert_eq!(cascades(4.0).count(), 1);
        let all = cascades(1e4);
        let mut set = LightSet::empty("sun", LightKind::Directional, Views::Orthographic, 64);
        all.push(Vec3::NEG_Y, Vec3::ONE, &mut set);
        assert_eq!((set.samples.len() as u32, all.count()), (5, 5));
        let shells: Vec<_> = set.samples.iter().map(|s| (s.shell[0], s.shell[1])).collect();
        assert!(shells.windows(2).all(|pair| pair[0].1 == pair[1].0 && pair[0].1 > pair[0].0), "{shells:?}");
        assert_eq!((shells[0].0, shells[4].1), (0.0, 0.0));
        // Within the box.
        assert!((all.centre - Vec3::new(4.0, 1.0, 0.0)).abs().max_element() < 1.0);
    }
}

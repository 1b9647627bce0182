//! The core of a scene: the ball about its finest triangles, where these lie apart from all else.
//!
//! Offsets from surfaces, near planes of lights and shadow maps go by the size of what is near. A ground that reaches to the
//! horizon, a dome, a stray triangle far away make the scene's radius useless for that.

use glam::Vec3;
use rayon::prelude::*;

/// Triangles that are looked at, at most: every n-th of more.
const MOST: usize = 1 << 18;
/// All else is so many times as far from the core's centre as the core's surface is, at least.
const GAP: f32 = 16.0;
/// A core's radius in parts of its distance from the origin, at least: single precision holds no finer places there.
const FINEST: f32 = 1.0 / 16.0;

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Core {
    /// Its centre.
    pub centre: Vec3,
    /// Its radius.
    pub radius: f32,
    /// Whether it is less than the whole scene.
    pub is_apart: bool,
}

impl Core {
    /// That of `triangles`; the ball about their bounding box where none lies apart.
    pub fn of(triangles: impl ExactSizeIterator<Item = [Vec3; 3]> + Clone) -> Self {
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = triangles.clone().flatten().fold(empty, |(low, high), p| (low.min(p), high.max(p)));
        if low.x > high.x {
            return Self { centre: Vec3::ZERO, radius: 1.0, is_apart: false };
        }
        let whole = Self { centre: (low + high) * 0.5, radius: (high - low).length() * 0.5, is_apart: false };
        Self::apart(triangles).unwrap_or(whole)
    }

    fn apart(triangles: impl ExactSizeIterator<Item = [Vec3; 3]>) -> Option<Self> {
        let every = triangles.len().div_ceil(MOST).max(1);
        let sized: Vec<_> = triangles.step_by(every).map(Measured::of).filter(|t| t.reach > 0.0).collect();
        let centre = Vec3::from_array([0, 1, 2].map(|axis| median(&sized, axis)));
        let mut by_distance: Vec<_> = sized.iter().map(|t| (t.middle.distance(centre) + t.reach, t.weight())).collect();
        by_distance.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let half = 0.5 * by_distance.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut within = 0.0;
        let radius = by_distance.windows(2).find_map(|pair| {
            within += pair[0].1;
            (within >= half && pair[1].0 >= GAP * pair[0].0).then_some(pair[0].0)
        })?;
        Some(Self { centre, radius: radius.max(FINEST * centre.length()), is_apart: true })
    }

    /// Size of what is near `place`: the core's radius within it, the distance from its centre beyond.
    pub fn scale_at(&self, place: Vec3) -> f32 {
        self.radius.max(place.distance(self.centre))
    }

    /// Centre and radius, as shaders read them.
    pub fn to_array(&self) -> [f32; 4] {
        self.centre.extend(self.radius).to_array()
    }
}

/// A triangle by its middle and the distance of its furthest corner from there.
struct Measured {
    middle: Vec3,
    reach: f32,
}

impl Measured {
    fn of(corners: [Vec3; 3]) -> Self {
        let middle = corners.iter().sum::<Vec3>() / 3.0;
        Self { middle, reach: corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f32::max) }
    }

    /// Fine triangles count for more: as many of half the size cover a quarter of the area.
    fn weight(&self) -> f64 {
        f64::from(self.reach).powi(-2)
    }
}

/// Weighted median of the middles' coordinates along an axis.
fn median(triangles: &[Measured], axis: usize) -> f32 {
    let mut all: Vec<_> = triangles.iter().map(|t| (t.middle[axis], t.weight())).collect();
    all.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let half = 0.5 * all.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut before = 0.0;
    let reached = |(_, weight): &&(f32, f64)| {
        before += weight;
        before >= half
    };
    all.iter().find(reached).map_or(0.0, |(place, _)| *place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    /// The twelve triangles of a cube.
    fn cube(centre: Vec3, half: f32) -> Vec<[Vec3; 3]> {
        let face = |axis: usize, side: f32| {
            let place = |u: f32, v: f32| {
                let mut p = Vec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                centre + half * p
            };
            let [a, b, c, d] = [place(-1.0, -1.0), place(1.0, -1.0), place(1.0, 1.0), place(-1.0, 1.0)];
            [[a, b, c], [a, c, d]]
        };
        (0..3).flat_map(|axis| [-1.0, 1.0].map(|side| face(axis, side))).flatten().collect()
    }

    fn core(triangles: &[[Vec3; 3]]) -> Core {
        Core::of(triangles.iter().copied())
    }

    /// A ground, a dome of many small triangles and a stray triangle leave the core where it is.
    #[test]
    fn what_is_far_away_moves_no_core() {
        let house = [cube(vec3(3.0, 1.0, 0.0), 2.0), cube(vec3(3.0, 0.0, 1.0), 0.5)].concat();
        let alone = core(&house);
        assert!(!alone.is_apart && (alone.centre - vec3(3.0, 1.0, 0.0)).length() < 1e-5);
        let ground = |half: f32| {
            let at = |x: f32, z: f32| vec3(x * half, -1.0, z * half);
            vec![[at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)], [at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]]
        };
        let dome = |radius: f32| {
            let (rows, columns) = (64, 128);
            let at = |row: i32, column: i32| {
                let (high, around) = (row as f32 / rows as f32, column as f32 / columns as f32);
                let ((s, c), (sa, ca)) = ((high * 3.1).sin_cos(), (around * std::f32::consts::TAU).sin_cos());
                radius * vec3(s * ca, c, s * sa)
            };
            let of = |i: i32| [at(i / columns, i), at(i / columns + 1, i), at(i / columns, i + 1)];
            (0..rows * columns).map(of).collect::<Vec<_>>()
        };
        let stray = vec![[vec3(1e6, 0.0, 0.0), vec3(1e6, 1.0, 0.0), vec3(1e6, 0.0, 1.0)]];
        for far in [ground(200.0), ground(1e6), dome(1e3), stray] {
            let found = core(&[house.clone(), far].concat());
            assert!(found.is_apart && (found.centre - alone.centre).length() < 3.0, "{found:?}");
            assert!((2.0..8.0).contains(&found.radius), "{found:?}");
            assert_eq!(
                (found.scale_at(found.centre), found.scale_at(vec3(1e4, 0.0, 0.0)).round() > 9990.0),
                (found.radius, true)
            );
        }
    }

    /// Without triangles, and with one, the core is the whole.
    #[test]
    fn few_triangles_are_a_whole() {
        assert_eq!(core(&[]).radius, 1.0);
        assert!(!core(&cube(Vec3::ZERO, 1.0)[..1]).is_apart);
    }
}

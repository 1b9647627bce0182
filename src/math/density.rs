//! How densely a surface is cut into cells: evenly, and more finely where the scene has detail or is looked at from.
//!
//! All of it follows from the scene: a camera that a user moves changes no cell.

use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// Nearer to a camera than this share of the surface's radius, nothing is cut more finely.
const NEAREST: f32 = 1.0 / 256.0;
/// Most places of detail. Each costs an evaluation for each triangle, and may cut some triangles.
const MOST_PLACES: usize = 64;
/// Smallest detail that counts, as a share of the surface's radius.
const SMALLEST: f32 = 1.0 / (1 << 20) as f32;
/// Sides of triangles beside a place of detail are cut only if they are longer than so many of its sizes: then few rooms are cut for
/// the boxes in them.
const WHOLE: f32 = 7.0;

/// Share of the cells that are even.
const EVEN: f64 = 0.5;
/// The same where a core has foci.
const EVEN_AROUND_CORE: f64 = 0.125;

/// A place near which cells are finer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Its centre.
    pub position: Vec3,
    /// What is nearer is taken to be this far.
    pub nearest: f32,
    /// Its share of the cells that are not even.
    pub share: f32,
    /// Sides of triangles that are no longer than this need not be cut for it.
    pub whole: f32,
    /// In the core of a far larger scene: cells grow faster with the distance, or most of them would lie beyond.
    pub in_core: bool,
}

/// Cells to an area.
///
/// Half of the cells are all of one area. The others become smaller with the distance from the foci, as areas of one solid angle
/// do that are looked at from there. So none grows to more than twice the even area. Around the core of a far larger scene an
/// eighth is even: there a cell may grow to eight times that area.
#[derive(Clone, Debug)]
pub struct Density {
    /// Cells to a unit of area everywhere.
    even: f64,
    /// Foci, and how many cells to a unit of area each adds at distance 1.
    foci: Vec<(Focus, f64)>,
}

impl Focus {
    /// A camera that looks at a surface whose bounding box is `2 radius` across.
    pub fn camera(position: Vec3, radius: f32) -> Self {
        Self { position, nearest: radius * NEAREST, share: 1.0, whole: radius * NEAREST, in_core: false }
    }

    /// Where a surface has small triangles, at most `MOST_PLACES` places; together they have a share of 1.
    ///
    /// Each place is a cube of a grid as coarse as the triangles in it are large, however many these are: a detailed figure counts
    /// by its size, not by its triangles. Where there are too many places, the finest grids are left out.
    pub fn detail(triangles: &[[Vec3; 3]], radius: f32) -> Vec<Self> {
        let mut finest = (radius * SMALLEST).max(f32::MIN_POSITIVE).log2().ceil() as i32;
        let sized: Vec<(Vec3, f32)> =
            triangles.iter().map(centre_and_reach).filter(|(_, reach)| *reach > 0.0).collect();
        loop {
            let cubes = cubes(&sized, finest);
            if cubes.len() <= MOST_PLACES {
                let share = 1.0 / cubes.len() as f32;
                let place =
                    |(size, position)| Self { position, nearest: size, share, whole: WHOLE * size, in_core: false };
                return cubes.into_iter().map(place).collect();
            }
            finest += 1;
        }
    }

    /// Square of the distance at which the focus counts.
    fn distance_squared(&self, distance: f32) -> f32 {
        distance * distance + self.nearest * self.nearest
    }

    /// Cells to a unit of area beside those at distance 1 from other foci, `away` from here: as areas of one solid angle, or of one
    /// form factor of a plane that passes at `nearest`.
    fn density(&self, away: f32) -> f64 {
        let squared = f64::from(self.distance_squared(away));
        if self.in_core { f64::from(self.nearest) * squared.powf(-1.5) } else { squared.recip() }
    }

    /// How long a side of a triangle may be whose middle is there: as long as it is away.
    pub fn longest_side(&self, middle: Vec3) -> f32 {
        middle.distance(self.position).max(self.whole)
    }
}

/// Middle of a triangle, and how far its corners are from there at most.
fn centre_and_reach(corners: &[Vec3; 3]) -> (Vec3, f32) {
    let middle = corners.iter().sum::<Vec3>() / 3.0;
    (middle, corners.iter().map(|c| c.distance(middle)).fold(0.0, f32::max))
}

/// Cubes that hold middles of triangles: their size, 2ⁿ and at least 2^`finest`, and the mean of these middles.
fn cubes(triangles: &[(Vec3, f32)], finest: i32) -> Vec<(f32, Vec3)> {
    let mut cubes = BTreeMap::new();
    for (middle, reach) in triangles {
        let level = (reach.log2().ceil() as i32).max(finest);
        let place = (*middle / (level as f32).exp2()).floor().as_ivec3().to_array();
        let (sum, count) = cubes.entry((level, place)).or_insert((DVec3::ZERO, 0.0));
        *sum += middle.as_dvec3();
        *count += 1.0;
        if cubes.len() > 8 * MOST_PLACES {
            break;
        }
    }
    cubes.into_iter().map(|((level, _), (sum, count))| ((level as f32).exp2(), (sum / count).as_vec3())).collect()
}

impl Density {
    /// That which cuts `triangles` into about `cells` cells.
    pub fn new(triangles: impl Iterator<Item = [Vec3; 3]>, cells: u32, foci: &[Focus]) -> Self {
        let mut area = 0.0;
        let mut angles = vec![0.0; foci.len()];
        for corners in triangles {
            let own = area_of(&corners);
            area += own;
            let (middle, reach) = centre_and_reach(&corners);
            for (angle, focus) in angles.iter_mut().zip(foci) {
                *angle += own * density(middle, reach, focus);
            }
        }
        let cells = f64::from(cells.max(1));
        let ratio = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
        if foci.is_empty() {
            return Self { even: ratio(cells, area), foci: Vec::new() };
        }
        let even = cells * if foci.iter().any(|focus| focus.in_core) { EVEN_AROUND_CORE } else { EVEN };
        let shares: f64 = foci.iter().map(|focus| f64::from(focus.share)).sum();
        let near =
            |(angle, focus): (&f64, &Focus)| (*focus, ratio((cells - even) * f64::from(focus.share) / shares, *angle));
        Self { even: ratio(even, area), foci: angles.iter().zip(foci).map(near).collect() }
    }

    /// Parts that the sides of a triangle are cut into, so that its r² cells are as dense; but none smaller than `least`.
    pub fn resolution(&self, corners: &[Vec3; 3], least: f64) -> u32 {
        let (middle, reach) = centre_and_reach(corners);
        let near: f64 = self.foci.iter().map(|(focus, near)| near * density(middle, reach, focus)).sum();
        let cell = (1.0 / (self.even + near)).max(least);
        (area_of(corners) / cell).sqrt().round().clamp(1.0, 1024.0) as u32
    }

    /// Whether a triangle has at most `most` cells, as small everywhere as at its corner nearest to a focus, and no side longer than
    /// a focus is away from there: cells of one size do for it.
    pub fn is_even(&self, corners: &[Vec3; 3], most: f64) -> bool {
        let [a, b, c] = *corners;
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let most = most / area_of(corners);
        let mut dense = self.even;
        for (focus, near) in &self.foci {
            let nearest = corners.iter().map(|p| p.distance(focus.position)).fold(f32::INFINITY, f32::min);
            let away = focus.distance_squared(nearest);
            dense += near * focus.density(nearest);
            if dense > most || longest > away {
                return false;
            }
        }
        dense <= most
    }
}

fn area_of([a, b, c]: &[Vec3; 3]) -> f64 {
    f64::from((*b - *a).cross(*c - *a).length()) * 0.5
}

/// That of a triangle by a focus, halfway between the distance of its middle and the least that a point of it may have.
fn density(middle: Vec3, reach: f32, focus: &Focus) -> f64 {
    let distance = middle.distance(focus.position);
    focus.density(0.5 * (distance + (distance - reach).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor of unit squares, two triangles each, around the origin.
    fn floor(half: i32) -> Vec<[Vec3; 3]> {
        let square = |x: i32, z: i32| {
            let at = |x: i32, z: i32| Vec3::new(x as f32, 0.0, z as f32);
            [[at(x, z), at(x, z + 1), at(x + 1, z)], [at(x + 1, z + 1), at(x + 1, z), at(x, z + 1)]]
        };
        (-half..half).flat_map(|x| (-half..half).flat_map(move |z| square(x, z))).collect()
    }

    fn counts(triangles: &[[Vec3; 3]], density: &Density) -> Vec<u32> {
        triangles.iter().map(|t| density.resolution(t, 0.0).pow(2)).collect()
    }

    #[test]
    fn about_as_many_cells_as_asked_for() {
        let floor = floor(20);
        for foci in [&[][..], &[Focus::camera(Vec3::Y, 28.0)]] {
            let density = Density::new(floor.iter().copied(), 1 << 18, foci);
            let all = f64::from(counts(&floor, &density).iter().sum::<u32>());
            assert!((all / f64::from(1 << 18) - 1.0).abs() < 0.02, "{all} with {foci:?}");
        }
    }

    #[test]
    fn finer_near_a_camera_and_nowhere_much_coarser() {
        let floor = floor(20);
        let even = counts(&floor, &Density::new(floor.iter().copied(), 1 << 18, &[]));
        let seen = counts(&floor, &Density::new(floor.iter().copied(), 1 << 18, &[Focus::camera(Vec3::Y, 28.0)]));
        assert!(seen.iter().zip(&even).all(|(s, e)| f64::from(*s) > 0.45 * f64::from(*e)));
        let below = floor.iter().position(|t| t[0] == Vec3::ZERO).unwrap();
        assert!(seen[below] > 20 * even[below], "{} {}", seen[below], even[below]);
    }

    /// The same triangle is even far from a focus, not beside it; a larger one not where it has too many cells.
    #[test]
    fn what_is_small_and_far_is_even() {
        let floor = floor(20);
        let density = Density::new(floor.iter().copied(), 1 << 14, &[Focus::camera(Vec3::Y, 28.0)]);
        let even = |[x, z]: [f32; 2], side: f32, most: f64| {
            density
                .is_even(&[[0.0, 0.0], [0.0, side], [side, 0.0]].map(|[dx, dz]| Vec3::new(x + dx, 0.0, z + dz)), most)
        };
        assert!(even([10.0, 3.0], 4.0, 1e3) && !even([0.0, 0.0], 4.0, 1e9));
        assert!(even([0.0, 0.0], 0.5, 1e3) && !even([0.0, 0.0], 0.5, 10.0));
        // Half of the cells are even: 16384 / 2 over 1600 of area, 41 of 8.
        assert!(!even([10.0, 3.0], 4.0, 41.0));
        let all = Density::new(floor.iter().copied(), 1 << 14, &[]);
        assert!(all.is_even(&floor[0], 5.2) && !all.is_even(&floor[0], 5.0), "16384 over 3200 triangles are 5.12");
    }

    /// A ground of two kilometres under a figure of a metre, which is all of the detail: the same however many triangles it has.
    #[test]
    fn detail_is_found_by_its_size() {
        let ground = floor(1).into_iter().map(|t| t.map(|p| p * 1000.0));
        for parts in [2, 12] {
            let figure =
                floor(parts).into_iter().map(|t| t.map(|p| p * (0.5 / parts as f32) + Vec3::new(300.0, 1.0, 0.0)));
            let all: Vec<_> = ground.clone().chain(figure).collect();
            let places = Focus::detail(&all, 1414.0);
            assert!(!places.is_empty() && places.len() <= MOST_PLACES);
            let near =
                places.iter().filter(|p| p.position.distance(Vec3::new(300.0, 1.0, 0.0)) < 1.0 && p.nearest <= 1.0);
            assert!(near.count() * 2 > places.len(), "{places:?}");
            let density = Density::new(all.iter().copied(), 1 << 17, &places);
            let square = |x: f32| [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]].map(|[dx, dz]| Vec3::new(x + dx, 0.0, dz - 0.5));
            let (beside, far) = (density.resolution(&square(299.5), 0.0), density.resolution(&square(-700.0), 0.0));
            assert!(beside >= 16 && far == 1, "{beside} {far}");
        }
    }
}

//! How densely a surface is cut into cells: evenly, and more finely where an eye is near.

use glam::{DVec3, Vec3};

/// Nearer to the eye than this share of the surface's radius, nothing is cut more finely.
const NEAREST: f32 = 1.0 / 256.0;

/// Where a surface is looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Its place.
    pub position: Vec3,
    /// What is nearer is taken to be this far.
    pub nearest: f32,
}

/// Cells to an area.
///
/// An image shows what is near to its eye in more detail, and so are records spread: by their distance in pixels. Half of the
/// cells are all of one area, and half of one solid angle as the eye sees them, so that none grows to more than twice that
/// area for it.
#[derive(Clone, Copy, Debug)]
pub struct Density {
    eye: Option<Eye>,
    /// Cells to a unit of area everywhere.
    even: f64,
    /// Cells to a unit of area at distance 1 of the eye, more.
    near: f64,
}

impl Eye {
    /// Looks at a surface whose bounding box is `2 radius` across.
    pub fn new(position: Vec3, radius: f32) -> Self {
        Self { position, nearest: radius * NEAREST }
    }
}

impl Density {
    /// That which cuts `triangles` into about `cells` cells.
    pub fn new(triangles: impl Iterator<Item = [Vec3; 3]>, cells: u32, eye: Option<Eye>) -> Self {
        let (mut area, mut angle) = (0.0, 0.0);
        for corners in triangles {
            area += area_of(&corners);
            angle += eye.map_or(0.0, |eye| area_of(&corners) / distance_squared(&corners, eye));
        }
        let half = f64::from(cells.max(1)) * 0.5;
        let share = |of: f64| if of > 0.0 { half / of } else { 0.0 };
        let even = share(area);
        Self { eye, even: if eye.is_some() { even } else { 2.0 * even }, near: share(angle) }
    }

    /// Parts that the sides of a triangle are cut into, so that its r² cells are as dense; but none smaller than `least`.
    pub fn resolution(&self, corners: &[Vec3; 3], least: f64) -> u32 {
        let near = self.eye.map_or(0.0, |eye| self.near / distance_squared(corners, eye));
        let cell = (1.0 / (self.even + near)).max(least);
        (area_of(corners) / cell).sqrt().round().clamp(1.0, 1024.0) as u32
    }

    /// Whether a triangle has at most `most` cells, as small everywhere as at its corner nearest to the eye, and no side longer than
    /// the eye is away from there: cells of one size do for it.
    pub fn is_even(&self, corners: &[Vec3; 3], most: f64) -> bool {
        let [a, b, c] = *corners;
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let (near, allowed) = self.eye.map_or((0.0, f32::INFINITY), |eye| {
            let nearest = corners.iter().map(|p| p.distance_squared(eye.position)).fold(f32::INFINITY, f32::min);
            let away = nearest + eye.nearest.powi(2);
            (self.near / f64::from(away), away)
        });
        longest <= allowed && area_of(corners) * (self.even + near) <= most
    }
}

fn area_of([a, b, c]: &[Vec3; 3]) -> f64 {
    f64::from((*b - *a).cross(*c - *a).length()) * 0.5
}

/// Halfway between the distance of a triangle's middle and the least that a point of it may have.
fn distance_squared(corners: &[Vec3; 3], eye: Eye) -> f64 {
    let corners = corners.map(|c| c.as_dvec3());
    let middle = corners.iter().sum::<DVec3>() / 3.0;
    let reach = corners.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
    let distance = middle.distance(eye.position.as_dvec3());
    let near = 0.5 * (distance + (distance - reach).max(0.0));
    near.powi(2) + f64::from(eye.nearest).powi(2)
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
        for eye in [None, Some(Eye::new(Vec3::Y, 28.0))] {
            let density = Density::new(floor.iter().copied(), 1 << 18, eye);
            let all = f64::from(counts(&floor, &density).iter().sum::<u32>());
            assert!((all / f64::from(1 << 18) - 1.0).abs() < 0.02, "{all} with {eye:?}");
        }
    }

    #[test]
    fn finer_near_the_eye_and_nowhere_much_coarser() {
        let floor = floor(20);
        let even = counts(&floor, &Density::new(floor.iter().copied(), 1 << 18, None));
        let seen = counts(&floor, &Density::new(floor.iter().copied(), 1 << 18, Some(Eye::new(Vec3::Y, 28.0))));
        assert!(seen.iter().zip(&even).all(|(s, e)| f64::from(*s) > 0.45 * f64::from(*e)));
        let below = floor.iter().position(|t| t[0] == Vec3::ZERO).unwrap();
        assert!(seen[below] > 20 * even[below], "{} {}", seen[below], even[below]);
    }

    /// The same triangle is even far from the eye, not beside it; a larger one not where it has too many cells.
    #[test]
    fn what_is_small_and_far_is_even() {
        let floor = floor(20);
        let density = Density::new(floor.iter().copied(), 1 << 14, Some(Eye::new(Vec3::Y, 28.0)));
        let even = |[x, z]: [f32; 2], side: f32, most: f64| {
            density
                .is_even(&[[0.0, 0.0], [0.0, side], [side, 0.0]].map(|[dx, dz]| Vec3::new(x + dx, 0.0, z + dz)), most)
        };
        assert!(even([10.0, 3.0], 4.0, 1e3) && !even([0.0, 0.0], 4.0, 1e9));
        assert!(even([0.0, 0.0], 0.5, 1e3) && !even([0.0, 0.0], 0.5, 10.0));
        // Half of the cells are even: 16384 / 2 over 1600 of area, 41 of 8.
        assert!(!even([10.0, 3.0], 4.0, 41.0));
        let all = Density::new(floor.iter().copied(), 1 << 14, None);
        assert!(all.is_even(&floor[0], 5.2) && !all.is_even(&floor[0], 5.0), "16384 over 3200 triangles are 5.12");
    }
}

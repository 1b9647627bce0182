//! Radiance from outside the scene, and directions drawn in proportion to it.

use crate::math::sampling::Discrete;
use crate::scene::{Background, EnvironmentMap};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The background, ready for sampling.
pub struct Sky<'a> {
    background: &'a Background,
    /// Over a map's texels, by radiance × solid angle.
    texels: Option<Discrete>,
}

/// A direction towards the sky.
pub struct SkySample {
    /// Unit direction.
    pub direction: DVec3,
    /// W·sr⁻¹·m⁻².
    pub radiance: DVec3,
    /// Per steradian.
    pub density: f64,
}

impl<'a> Sky<'a> {
    /// Tabulates a map; constant backgrounds need no table.
    pub fn new(background: &'a Background) -> Self {
        let texels = match background {
            Background::Map(map) => Discrete::new(texel_weights(map)),
            _ => None,
        };
        Self { background, texels }
    }

    /// Whether any light can come from the sky.
    pub fn is_black(&self) -> bool {
        self.background.is_black()
    }

    /// Whether [`Sky::sample`] can give directions.
    pub fn is_map(&self) -> bool {
        self.texels.is_some()
    }

    /// Radiance from `direction`, W·sr⁻¹·m⁻².
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        self.background.radiance(direction.as_vec3()).as_dvec3()
    }

    /// A direction in proportion to a map's radiance. `None` for a constant sky: a cosine-distributed direction is already
    /// as good as any.
    ///
    /// The bilinear lookup is a sum of tents over the texels' centres: a texel is chosen by its radiance × solid angle, then a
    /// place under its tent. Where rows end at a pole the tent is folded back, as the lookup goes on with the last row.
    pub fn sample(&self, u: f64, v: f64) -> Option<SkySample> {
        let (Background::Map(map), Some(texels)) = (self.background, &self.texels) else { return None };
        let (i, place) = texels.sample(u);
        let (x, y) = (i % map.width as usize, i / map.width as usize);
        let across = (x as f64 + 0.5 + tent(place)) / f64::from(map.width);
        let down = (y as f64 + 0.5 + tent(v)) / f64::from(map.height);
        let down = if down > 1.0 { 2.0 - down } else { down.abs() };
        let phi = TAU * (across - 0.5);
        let (sin, cos) = (PI * down).sin_cos();
        let direction = DVec3::new(sin * phi.sin(), cos, -sin * phi.cos());
        let density = density(map, texels, (across, down), sin);
        (density > 0.0 && density.is_finite()).then(|| SkySample {
            direction,
            radiance: self.radiance(direction),
            density,
        })
    }

    /// Density of [`Sky::sample`] at `direction`, per steradian.
    pub fn density(&self, direction: DVec3) -> f64 {
        let (Background::Map(map), Some(texels)) = (self.background, &self.texels) else { return 0.0 };
        density(map, texels, coordinates(direction), (1.0 - direction.y * direction.y).max(0.0).sqrt())
    }
}

/// Density of samples at a place in the map, per steradian.
fn density(map: &EnvironmentMap, texels: &Discrete, (u, v): (f64, f64), sin: f64) -> f64 {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
    let (x0, y0) = (x.floor(), y.floor());
    let at = |dx: i64, dy: i64| {
        let column = (x0 as i64 + dx).rem_euclid(width);
        let row = (y0 as i64 + dy).clamp(0, height - 1);
        texels.probability((row * width + column) as usize)
    };
    let row = |dy| at(0, dy) + (at(1, dy) - at(0, dy)) * (x - x0);
    let texel = row(0) + (row(1) - row(0)) * (y - y0);
    texel * (width * height) as f64 / (TAU * PI * sin)
}

/// A place under the tent 1 − |x| on [−1, 1], by a number in [0, 1).
fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// Place of a direction in the map, both in [0, 1], v down from +Y.
fn coordinates(direction: DVec3) -> (f64, f64) {
    (0.5 + direction.x.atan2(-direction.z) / TAU, direction.y.clamp(-1.0, 1.0).acos() / PI)
}

/// Radiance × solid angle of each texel.
fn texel_weights(map: &EnvironmentMap) -> impl Iterator<Item = f64> {
    (0..map.height).flat_map(move |y| {
        let row = &map.rgb[y as usize * map.width as usize..][..map.width as usize];
        row.iter().map(move |texel| texel.iter().copied().map(f64::from).sum::<f64>() * map.solid_angle(y))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::uniform_sphere;

    #[test]
    fn density_integrates_to_one_and_matches_the_samples() {
        let mut rgb = vec![[0.1f32; 3]; 32 * 16];
        rgb[5 * 32 + 20] = [90.0; 3];
        let background = Background::Map(EnvironmentMap { width: 32, height: 16, rgb });
        let sky = Sky::new(&background);
        let n = 400;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let mean: f64 = (0..n * n).map(|i| sky.density(uniform_sphere(at(i % n), at(i / n)))).sum();
        assert!((mean * 4.0 * PI / f64::from(n * n) - 1.0).abs() < 0.01);
        for i in 0..1000 {
            let s = sky.sample(at(i % n), at((i * 7) % n)).unwrap();
            assert!((sky.density(s.direction) / s.density - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn samples_of_a_sun_bring_its_light_alike() {
        let mut rgb = vec![[0.0f32; 3]; 256 * 128];
        rgb[40 * 256 + 100] = [1e6; 3];
        let background = Background::Map(EnvironmentMap { width: 256, height: 128, rgb });
        let sky = Sky::new(&background);
        let at = |i: u32| (f64::from(i) + 0.5) / 100.0;
        let value = |i: u32| sky.sample(at(i % 10), at(i / 10)).map_or(0.0, |s| s.radiance.x / s.density);
        let values: Vec<f64> = (0..100).map(value).collect();
        let mean = values.iter().sum::<f64>() / 100.0;
        assert!(values.iter().all(|v| (v / mean - 1.0).abs() < 0.03), "{values:?}");
    }

    #[test]
    fn the_centre_looks_along_minus_z_and_right_is_plus_x() {
        let (u, v) = coordinates(DVec3::NEG_Z);
        assert_eq!((u, v), (0.5, 0.5));
        assert_eq!(coordinates(DVec3::X).0, 0.75);
        assert_eq!(coordinates(DVec3::Y).1, 0.0);
    }
}

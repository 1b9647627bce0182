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
    pub fn sample(&self, u: f64, v: f64) -> Option<SkySample> {
        let (Background::Map(map), Some(texels)) = (self.background, &self.texels) else { return None };
        let (i, place) = texels.sample(u);
        let (x, y) = (i % map.width as usize, i / map.width as usize);
        let phi = TAU * ((x as f64 + place) / f64::from(map.width) - 0.5);
        let (sin, cos) = (PI * (y as f64 + v) / f64::from(map.height)).sin_cos();
        let direction = DVec3::new(sin * phi.sin(), cos, -sin * phi.cos());
        let density = self.texel_density(map, texels, i, sin);
        (density > 0.0 && density.is_finite()).then(|| SkySample {
            direction,
            radiance: self.radiance(direction),
            density,
        })
    }

    /// Density of [`Sky::sample`] at `direction`, per steradian.
    pub fn density(&self, direction: DVec3) -> f64 {
        let (Background::Map(map), Some(texels)) = (self.background, &self.texels) else { return 0.0 };
        let (u, v) = coordinates(direction);
        let index = |t: f64, n: u32| ((t * f64::from(n)) as usize).min(n as usize - 1);
        let i = index(v, map.height) * map.width as usize + index(u, map.width);
        self.texel_density(map, texels, i, (1.0 - direction.y * direction.y).max(0.0).sqrt())
    }

    fn texel_density(&self, map: &EnvironmentMap, texels: &Discrete, i: usize, sin: f64) -> f64 {
        texels.probability(i) * f64::from(map.width) * f64::from(map.height) / (TAU * PI * sin)
    }
}

/// Place of a direction in the map, both in [0, 1], v down from +Y.
fn coordinates(direction: DVec3) -> (f64, f64) {
    (0.5 + direction.x.atan2(-direction.z) / TAU, direction.y.clamp(-1.0, 1.0).acos() / PI)
}

fn texel(map: &EnvironmentMap, x: i64, y: i64) -> DVec3 {
    let x = x.rem_euclid(i64::from(map.width)) as usize;
    let y = y.clamp(0, i64::from(map.height) - 1) as usize;
    DVec3::from_array(map.rgb[y * map.width as usize + x].map(f64::from))
}

/// Mean radiance of a texel and its neighbours × solid angle: not zero wherever the bilinear lookup is not.
fn texel_weights(map: &EnvironmentMap) -> impl Iterator<Item = f64> {
    (0..i64::from(map.height)).flat_map(move |y| {
        let sin = (PI * (y as f64 + 0.5) / f64::from(map.height)).sin();
        (0..i64::from(map.width)).map(move |x| {
            let near = |dx, dy| texel(map, x + dx, y + dy).element_sum();
            let around: f64 = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| near(dx, dy))).sum();
            (around + near(0, 0)) * sin
        })
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
    fn the_centre_looks_along_minus_z_and_right_is_plus_x() {
        let (u, v) = coordinates(DVec3::NEG_Z);
        assert_eq!((u, v), (0.5, 0.5));
        assert_eq!(coordinates(DVec3::X).0, 0.75);
        assert_eq!(coordinates(DVec3::Y).1, 0.0);
    }
}

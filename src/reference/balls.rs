//! White, diffuse balls drawn over a picture, each in its own light: the samples of an irradiance volume, made visible.

use super::tracer::Tracer;
use super::view::View;
use crate::image::Picture;
use crate::math::sh;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;
use std::ops::RangeInclusive;

/// A ball.
#[derive(Clone, Debug)]
pub struct Ball {
    /// Its centre, relative to the scene's origin.
    pub centre: DVec3,
    /// Its radius, in the scene's units.
    pub radius: f64,
    /// Coefficients of the radiance around it, W·sr⁻¹·m⁻²; a ball without light is drawn red.
    pub light: Option<Vec<DVec3>>,
}

/// Draws `balls` over the colour of `picture`, which shows `view` of the tracer's scene. Surfaces in front hide them. Returns the number
/// of pixels drawn.
pub fn draw(picture: &mut Picture, tracer: &Tracer, view: &View, balls: &[Ball]) -> usize {
    let Some([r, g, b]) = picture.rgb("") else { return 0 };
    let mean = [r, g, b].iter().flat_map(|channel| channel.iter()).sum::<f32>() / (3 * r.len()) as f32;
    let red = Vec3::X * if mean > 0.0 { 2.0 * mean } else { 1.0 };
    let covered: Vec<(usize, Vec3)> = nearest(view, balls)
        .into_par_iter()
        .enumerate()
        .filter_map(|(pixel, (distance, number))| {
            let ball = balls.get(number)?;
            let (origin, direction) = ray(view, pixel);
            tracer.free(origin, direction, distance).then(|| {
                let normal = (origin + distance * direction - ball.centre) / ball.radius;
                (pixel, ball.light.as_ref().map_or(red, |light| reflected(light, normal)))
            })
        })
        .collect();
    for (axis, channel) in ["R", "G", "B"].into_iter().enumerate() {
        if let Some(values) = picture.channels.get_mut(channel) {
            covered.iter().for_each(|(pixel, colour)| values[*pixel] = colour[axis]);
        }
    }
    covered.len()
}

fn ray(view: &View, pixel: usize) -> (DVec3, DVec3) {
    let width = view.width as usize;
    view.ray((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5)
}

/// Of each pixel the distance to the nearest ball and its number; `usize::MAX` for none.
fn nearest(view: &View, balls: &[Ball]) -> Vec<(f64, usize)> {
    let mut found = vec![(f64::INFINITY, usize::MAX); view.width as usize * view.height as usize];
    for (number, ball) in balls.iter().enumerate() {
        let Some([columns, rows]) = rectangle(view, ball) else { continue };
        for row in rows {
            for column in columns.clone() {
                let pixel = row * view.width as usize + column;
                let (origin, direction) = ray(view, pixel);
                if let Some(distance) = meets(ball, origin, direction).filter(|d| *d < found[pixel].0) {
                    found[pixel] = (distance, number);
                }
            }
        }
    }
    found
}

/// Columns and rows of pixels around a ball; none for one that is not wholly before the eye.
fn rectangle(view: &View, ball: &Ball) -> Option<[RangeInclusive<usize>; 2]> {
    let (mut low, mut high) = (glam::DVec2::INFINITY, glam::DVec2::NEG_INFINITY);
    for i in 0..8 {
        let side = |bit: i32| if i >> bit & 1 == 1 { ball.radius } else { -ball.radius };
        let at = view.project(ball.centre + DVec3::new(side(0), side(1), side(2)))?;
        (low, high) = (low.min(at), high.max(at));
    }
    let size = glam::DVec2::new(f64::from(view.width), f64::from(view.height));
    let is_seen = high.cmpge(glam::DVec2::ZERO).all() && low.cmplt(size).all();
    let (low, high) = (low.clamp(glam::DVec2::ZERO, size - 1.0), high.clamp(glam::DVec2::ZERO, size - 1.0));
    is_seen.then_some([low.x as usize..=high.x as usize, low.y as usize..=high.y as usize])
}

/// Distance along a ray to a ball.
fn meets(ball: &Ball, origin: DVec3, direction: DVec3) -> Option<f64> {
    let offset = ball.centre - origin;
    let along = offset.dot(direction);
    let beside = (offset - along * direction).length_squared();
    let half = (ball.radius * ball.radius - beside).max(0.0).sqrt();
    (half > 0.0 && along > half).then_some(along - half)
}

/// Radiance of a white surface with the unit normal `n`.
fn reflected(light: &[DVec3], n: DVec3) -> Vec3 {
    let channel = |c: usize| {
        let coefficients: Vec<f64> = light.iter().map(|v| v[c]).collect();
        (sh::irradiance(&coefficients, n) * FRAC_1_PI).max(0.0) as f32
    };
    Vec3::new(channel(0), channel(1), channel(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::build::look;
    use crate::scene::cornell;

    /// Of two equal balls along the axis of sight the nearer one is seen, with the area of its silhouette; and none behind a wall.
    #[test]
    fn the_nearest_ball_before_the_walls_is_drawn() {
        let scene = cornell();
        let tracer = Tracer::new(&scene);
        let (low, high) = scene.bounds();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let middle = low.midpoint(high).with_y(low.y + 0.75 * (high.y - low.y));
        let eye = middle.with_z(low.z + 0.02);
        let view = View::new(&look(eye, middle, 60.0), 128, 128);
        let ball = |z: f64, light: f64| Ball {
            centre: middle.with_z(z),
            radius: 0.02,
            light: Some(vec![DVec3::splat(light)]),
        };
        let picture = || {
            let mut picture = Picture::new(128, 128);
            picture.insert_rgb("", std::iter::repeat_n([0.5; 3], 128 * 128));
            picture
        };
        let mut shown = picture();
        let count = draw(&mut shown, &tracer, &view, &[ball(middle.z + 0.1, 1.0), ball(middle.z, 2.0)]);
        // The sine of the silhouette's half angle is radius over distance.
        let tangent = (0.02 / (middle.z - eye.z)).asin().tan();
        let expected = std::f64::consts::PI * (64.0 * tangent / 30_f64.to_radians().tan()).powi(2);
        assert!((count as f64 / expected - 1.0).abs() < 0.05, "{count} pixels, {expected}");
        let radiance = 2.0 / (4.0 * std::f64::consts::PI).sqrt();
        let centre = shown.rgb("").unwrap()[1][64 * 128 + 64];
        assert!((f64::from(centre) - radiance).abs() < 1e-6, "{centre} {radiance}");
        let mut hidden = picture();
        assert_eq!(draw(&mut hidden, &tracer, &view, &[ball(high.z + 0.1, 1.0)]), 0);
        assert_eq!(hidden, picture());
    }
}

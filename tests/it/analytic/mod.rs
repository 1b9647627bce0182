//! The renderer on the device against closed forms, and against itself under changes that must not change the light.

mod area_lights;
mod changes;
mod one_bounce;
mod punctual_lights;
mod sky;
mod thin_walls;

use hemicube::image::Picture;

fn difference(a: &Picture, b: &Picture, layer: &str) -> hemicube::image::metrics::Metrics {
    let mask = hemicube::image::metrics::mask(b.scalar("mask").unwrap());
    let (a, b) = (a.layer(layer).unwrap(), b.layer(layer).unwrap());
    hemicube::image::metrics::measure(&a, &b, 96, Some(&mask))
}

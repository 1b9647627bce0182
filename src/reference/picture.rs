//! Layers of a finished or unfinished image.

use super::film::Estimate;
use super::path::Layers;
use super::progressive::Progressive;
use super::tracer::Tracer;
use super::view::{Pixel, View};
use crate::image::Picture;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Names of the irradiance layers by number of reflections.
pub const BOUNCE_LAYERS: [&str; 4] = ["dir", "b1", "b2", "b3plus"];

/// Irradiance at every pixel to the layers that every renderer of the crate writes.
///
/// `direct.*`, `indirect.*` and `emission.*` are radiance towards the camera and sum to `R, G, B`; the sky behind
/// everything counts as emission. `irradiance.*` is indirect, `irradiance_direct.*` direct irradiance, both W·m⁻².
/// `mask` is 1 where a surface is seen that does more than emit. Positions are in the scene file's world.
pub fn picture(tracer: &Tracer, view: &View, pixels: &[Pixel], direct: &[DVec3], indirect: &[DVec3]) -> Picture {
    let mut out = Picture::new(view.width, view.height);
    let surface = |f: &dyn Fn(&Pixel, usize) -> DVec3| -> Vec<[f32; 3]> {
        pixels.iter().enumerate().map(|(i, pixel)| f(pixel, i).as_vec3().to_array()).collect()
    };
    let albedo = |pixel: &Pixel| pixel.surface.map_or(DVec3::ZERO, |s| s.albedo);
    let emission = |pixel: &Pixel| pixel.surface.map_or_else(|| tracer.sky.radiance(pixel.direction), |s| s.emission);
    let reflected = |pixel: &Pixel, e: DVec3| albedo(pixel) * e * FRAC_1_PI;
    out.insert_rgb("", surface(&|p, i| reflected(p, direct[i] + indirect[i]) + emission(p)));
    out.insert_rgb("direct", surface(&|p, i| reflected(p, direct[i])));
    out.insert_rgb("indirect", surface(&|p, i| reflected(p, indirect[i])));
    out.insert_rgb("emission", surface(&|p, _| emission(p)));
    out.insert_rgb("irradiance", surface(&|_, i| indirect[i]));
    out.insert_rgb("irradiance_direct", surface(&|_, i| direct[i]));
    out.insert_rgb("albedo", surface(&|p, _| albedo(p)));
    out.insert_xyz("N", surface(&|p, _| p.surface.map_or(DVec3::ZERO, |s| s.normal)));
    let origin = tracer.scene.origin;
    out.insert_xyz("P", surface(&|p, _| p.surface.map_or(DVec3::ZERO, |s| s.position + origin)));
    out.insert_scalar("Z", pixels.iter().map(|p| p.depth as f32));
    out.insert_scalar("mask", pixels.iter().map(|p| f32::from(u8::from(p.reflector().is_some()))));
    out
}

impl Progressive<'_, '_> {
    /// The image so far: [`picture`]'s layers, the layers by number of reflections as far as they were asked for, and
    /// `stderr.irradiance`, `stderr.dir`, …: standard errors per pixel and channel.
    pub fn picture(&self) -> Picture {
        let estimates: Vec<Estimate> = (0..self.pixels.len()).map(|i| self.estimate(i)).collect();
        let direct: Vec<DVec3> = estimates.iter().map(|e| e.mean[0]).collect();
        let indirect: Vec<DVec3> = estimates.iter().map(Estimate::indirect).collect();
        let mut out = picture(self.tracer, &self.view, &self.pixels, &direct, &indirect);
        let rgb = |f: &dyn Fn(&Estimate) -> DVec3| -> Vec<[f32; 3]> {
            estimates.iter().map(|e| f(e).as_vec3().to_array()).collect()
        };
        let asked = (self.settings.bounces.min(3) + 1) as usize;
        for (i, name) in BOUNCE_LAYERS.iter().enumerate().take(asked) {
            let pick = |layers: &Layers| layers[i];
            out.insert_rgb(name, rgb(&|e| pick(&e.mean)));
            out.insert_rgb(&format!("stderr.{name}"), rgb(&|e| pick(&e.stderr)));
        }
        out.insert_rgb("stderr.irradiance", rgb(&|e| e.stderr_indirect));
        out
    }
}

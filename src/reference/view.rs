//! A camera and an image size: rays through pixel centres, and the surface that each pixel sees.

use super::surface::SurfacePoint;
use super::tracer::Tracer;
use crate::scene::{Camera, Lens};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A camera's view at an image size.
#[derive(Debug, Clone)]
pub struct View {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    camera: Camera,
    /// Half extents of the image: tangents of the half angles, or scene units for parallel projection.
    half: DVec2,
}

/// What the centre of a pixel sees.
#[derive(Debug, Clone, Copy)]
pub struct Pixel {
    /// Unit direction of the ray.
    pub direction: DVec3,
    /// The surface, if the ray meets one.
    pub surface: Option<SurfacePoint>,
    /// Distance along the view axis, scene units; 0 where nothing is seen.
    pub depth: f64,
    /// Width of the pixel at that distance, scene units.
    pub footprint: f64,
}

impl Pixel {
    /// The surface, if it reflects: where irradiance is asked for.
    pub fn reflector(&self) -> Option<&SurfacePoint> {
        self.surface.as_ref().filter(|surface| !surface.emitter)
    }
}

impl View {
    /// The view through `camera` of an image of the given size in pixels.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let half_height = match camera.lens {
            Lens::Perspective { yfov, .. } => (0.5 * yfov).tan(),
            Lens::Orthographic { ymag, .. } => ymag,
        };
        let half = DVec2::new(half_height * f64::from(width) / f64::from(height), half_height);
        Self { width, height, camera: camera.clone(), half }
    }

    /// Origin and unit direction of the ray through the pixel position (x, y), in pixels from the top left corner.
    pub fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let at = DVec2::new(2.0 * x / f64::from(self.width) - 1.0, 1.0 - 2.0 * y / f64::from(self.height)) * self.half;
        let pose = &self.camera.camera_to_world;
        match self.camera.lens {
            Lens::Perspective { .. } => (pose.w_axis.truncate(), pose.transform_vector3(at.extend(-1.0)).normalize()),
            Lens::Orthographic { .. } => {
                (pose.transform_point3(at.extend(0.0)), pose.transform_vector3(DVec3::NEG_Z).normalize())
            }
        }
    }

    /// The pixel position of a point, in pixels from the top left corner; none behind the eye.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let local = self.camera.camera_to_world.inverse().transform_point3(point);
        if local.z >= 0.0 {
            return None;
        }
        let at = match self.camera.lens {
            Lens::Perspective { .. } => local.truncate() / -local.z,
            Lens::Orthographic { .. } => local.truncate(),
        } / self.half;
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        Some(DVec2::new(1.0 + at.x, 1.0 - at.y) * size / 2.0)
    }

    /// What the pixel with this index (row by row from the top) sees.
    pub fn pixel(&self, tracer: &Tracer, index: usize) -> Pixel {
        let (x, y) = (index % self.width as usize, index / self.width as usize);
        let (origin, direction) = self.ray(x as f64 + 0.5, y as f64 + 0.5);
        let surface = tracer.hit(origin, direction).map(|hit| tracer.surface(&hit, direction));
        let pose = &self.camera.camera_to_world;
        let axis = -pose.z_axis.truncate().normalize();
        let depth = surface.map_or(0.0, |s| (s.position - pose.w_axis.truncate()).dot(axis));
        let pixel_size = 2.0 * self.half.y / f64::from(self.height);
        let footprint = match self.camera.lens {
            Lens::Perspective { .. } => pixel_size * depth,
            Lens::Orthographic { .. } => pixel_size,
        };
        Pixel { direction, surface, depth, footprint }
    }

    /// What every pixel sees, row by row from the top.
    pub fn pixels(&self, tracer: &Tracer) -> Vec<Pixel> {
        let count = self.width as usize * self.height as usize;
        tracer.count_rays(count as u64);
        (0..count).into_par_iter().map(|i| self.pixel(tracer, i)).collect()
    }
}

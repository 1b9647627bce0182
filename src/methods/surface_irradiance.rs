//! Irradiance of the surface itself, without a camera and without records: direct light and reflected light of both sides of
//! each of its cells. Bakes are made of it.
//!
//! Direct light is that of the same surface in white: what leaves a white cell is its irradiance/π. Reflected light is that of
//! the surface cache's places ([`super::surface_cache`]).

use super::captures::CaptureMode;
use super::light_set::LightSettings;
use super::probes::{Result, light_surfaces};
use super::surface_cache::{Bounced, Looking, SurfaceCacheSettings, read_surface, reflected_irradiance};
use super::{Ground, surface_cache};
use crate::math::cells;
use crate::passes::cluster_tree::Detail;
use crate::passes::geometry::{CellBudget, Geometry};
use crate::passes::material::Textures;
use crate::scene::{Part, Scene};
use crate::vk::Device;
use crate::vk::pass::Recorder;
use glam::{DVec2, DVec3, Vec3};
use std::f32::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// What is computed, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceIrradianceSettings {
    /// Whether direct light is computed.
    pub direct: bool,
    /// Reflections of the reflected light: 0 for none, [`surface_cache::ALL_BOUNCES`] for all.
    pub bounces: u32,
    /// Of all bounces, the share of the light that may be missing.
    pub tolerance: f32,
    /// How all bounces are summed.
    pub solver: surface_cache::Solver,
    /// Places that capture, about. `None`: by the number of cells.
    pub places: Option<u32>,
    /// Texels a side of their captures: even, 8 to 256.
    pub capture_size: u32,
    /// Cells that the surface is cut into, about; each triangle has at least one.
    pub surface_cells: u32,
    /// Direct light on the surfaces.
    pub lights: LightSettings,
}

/// The surface's irradiance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceIrradiance {
    /// Triangles, in an order of their own: corners are vertices of the scene.
    pub triangles: Vec<[u32; 3]>,
    /// Those of each material.
    pub parts: Vec<Part>,
    /// First cell of each triangle, and the end.
    pub first_cell: Vec<u32>,
    /// Of the front and the back of each cell by light that nothing reflected, W·m⁻²; zeros where it was not asked for.
    pub direct: Vec<[[f32; 3]; 2]>,
    /// The same by light that surfaces reflected.
    pub reflected: Vec<[[f32; 3]; 2]>,
    /// What was done for that.
    pub bounced: Bounced,
}

impl SurfaceIrradiance {
    /// Computes that of `scene`. `on_progress` hears stages done, of five.
    ///
    /// # Errors
    /// The device's, or too many lights.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        settings: &SurfaceIrradianceSettings,
        on_progress: &mut dyn FnMut(u64),
    ) -> Result<Self> {
        let mut recorder = Recorder::new(device);
        let direct = settings.direct.then(|| direct(device, &mut recorder, scene, settings)).transpose()?;
        on_progress(1);
        let in_compute = CaptureMode::Auto.against_compute(device, scene, settings.capture_size).is_none();
        let textures = Textures::new(device, scene)?;
        let budget = CellBudget::even(settings.surface_cells);
        let geometry = Geometry::new(device, scene, &budget, in_compute.then_some(Detail::Exact))?;
        let ground = Ground { scene, geometry: &geometry, textures: textures.as_ref() };
        let count = 2 * geometry.cell_count as usize;
        let (reflected, bounced) = if settings.bounces > 0 {
            light_surfaces(device, &mut recorder, &ground, scene, &settings.lights)?;
            let cache = settings.cache(in_compute);
            reflected_irradiance(device, &mut recorder, &ground, &cache, &mut |done| on_progress(2 + done))?
        } else {
            (vec![[0.0; 3]; count], Bounced::default())
        };
        let (_, first_cell) = read_surface(device, &mut recorder, &ground)?;
        let (triangles, parts) = (geometry.triangles.clone(), geometry.parts.clone());
        let direct = direct.unwrap_or_else(|| vec![[0.0; 3]; count]);
        Ok(Self { triangles, parts, first_cell, direct: pairs(&direct), reflected: pairs(&reflected), bounced })
    }

    /// Cells of a triangle.
    pub fn cells(&self, triangle: usize) -> Range<usize> {
        self.first_cell[triangle] as usize..self.first_cell[triangle + 1] as usize
    }

    /// The middle of a triangle's cell: weights of its second and third corner.
    pub fn middle(&self, triangle: usize, cell: usize) -> DVec2 {
        let cells = self.cells(triangle);
        let third = DVec2::splat(1.0 / 3.0);
        cells::point((cells.len() as u32).isqrt(), (cell - cells.start) as u32, third)
    }

    /// Direct and reflected light together of a cell's front (0) or back (1).
    pub fn whole(&self, cell: usize, side: usize) -> DVec3 {
        Vec3::from(self.direct[cell][side]).as_dvec3() + Vec3::from(self.reflected[cell][side]).as_dvec3()
    }
}

impl SurfaceIrradianceSettings {
    fn cache(&self, in_compute: bool) -> SurfaceCacheSettings {
        let Self { bounces, tolerance, solver, places, capture_size, .. } = *self;
        let looking = Looking { size: capture_size, in_compute, lod_error: 0.0, shared: false };
        SurfaceCacheSettings { bounces, tolerance, solver, places, looking }
    }
}

/// Irradiance by direct light of both sides of each cell.
fn direct(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    scene: &Scene,
    settings: &SurfaceIrradianceSettings,
) -> Result<Vec<[f32; 3]>> {
    let white = scene.whitened();
    let textures = Textures::new(device, &white)?;
    let geometry = Geometry::new(device, &white, &CellBudget::even(settings.surface_cells), None)?;
    let ground = Ground { scene: &white, geometry: &geometry, textures: textures.as_ref() };
    light_surfaces(device, recorder, &ground, scene, &settings.lights)?;
    let (radiance, _) = read_surface(device, recorder, &ground)?;
    Ok(radiance.into_iter().map(|rgb| rgb.map(|value| value * PI)).collect())
}

fn pairs(sides: &[[f32; 3]]) -> Vec<[[f32; 3]; 2]> {
    sides.chunks_exact(2).map(|both| [both[0], both[1]]).collect()
}

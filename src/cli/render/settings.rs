//! What the flags make of a frame.

use super::Kind;
use super::args::RenderArgs;
use super::choices::{CompensationArg, HiddenArg, NeighboursArg, RadiusArg, SolverArg};
use crate::cli::choices::{CaptureOptions, WeightArg};
use hemicube::methods::captures::{PLANE_APERTURE, SLICES, SLICES_NEAR};
use hemicube::methods::surface_cache::Solver;
use hemicube::passes::integrate::{Gradients, Radius};
use hemicube::passes::resolve::Plane;
use hemicube::passes::splat::Weight;
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, image_size};

impl RenderArgs {
    /// What the frame is made with.
    pub(super) fn settings(&self, camera: &Camera, kind: Kind) -> Settings {
        let (width, height) = image_size(camera, self.image.width, self.image.height);
        let mut settings =
            Settings { width, height, bounces: self.bounces, full_plan: self.full_plan, ..Settings::default() };
        settings.bounce_tolerance = self.bounce_tolerance;
        settings.bounce_solver = match self.bounce_solver {
            SolverArg::Plain => Solver::Plain,
            SolverArg::Accelerated => Solver::Accelerated,
        };
        settings.places = self.places;
        let cache = &mut settings.cache;
        cache.accuracy = self.accuracy;
        cache.lod_error = self.lod_error;
        cache.min_radius = self.min_radius;
        cache.max_radius = self.max_radius;
        cache.covered = self.coverage;
        cache.contrast = self.contrast;
        cache.normal_limit = self.normal_limit;
        cache.capture_size = self.capture_size;
        cache.capture = self.capture.mode(&CaptureOptions {
            aperture: self.aperture.unwrap_or(PLANE_APERTURE),
            compensated: self.compensation != Some(CompensationArg::Off),
            slices: self.slices.unwrap_or(SLICES),
            slices_near: self.slices_near.unwrap_or(SLICES_NEAR),
        });
        cache.seed = self.seed;
        cache.batch = self.batch;
        let [rotation, translation] = self.gradients.has();
        cache.gradients = Gradients { rotation, translation };
        cache.radius = match self.radius {
            RadiusArg::Harmonic => Radius::Harmonic,
            RadiusArg::Hessian => Radius::Hessian,
        };
        cache.weight = match self.weight {
            WeightArg::Bounded => Weight::Bounded,
            WeightArg::Ward => Weight::Ward,
        };
        cache.clamped = self.neighbours == NeighboursArg::Clamp;
        cache.hidden = self.hidden == HiddenArg::Reject;
        settings.lights.area_samples = self.light_samples;
        settings.surface_cells = self.surface_cells;
        settings.tessellation = self.tessellate;
        settings.counts_work = self.measure;
        settings.planes = match kind {
            Kind::Exr => {
                let layers = self.layers.clone().unwrap_or_default();
                Plane::ALL.into_iter().filter(|p| layers.contains(layer_name(*p))).collect()
            }
            _ => vec![Plane::Final],
        };
        settings
    }
}

/// Name of a plane in `--layers`.
fn layer_name(plane: Plane) -> &'static str {
    match plane {
        Plane::Final => "",
        Plane::Direct => "direct",
        Plane::Indirect => "indirect",
        Plane::Irradiance => "irradiance",
        Plane::DirectIrradiance => "irradiance_direct",
        Plane::Albedo => "albedo",
        Plane::Emission => "emission",
        Plane::Normal => "N",
        Plane::Position => "P",
        Plane::Depth => "Z",
        Plane::Records => "records",
        Plane::Mask => "mask",
    }
}

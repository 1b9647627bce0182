//! Light at points in space, as spherical harmonics: six faces captured at each, without a horizon.
//!
//! What is measured is the light that surfaces reflect, and the sky's own. Emitters' own light is left out, as everywhere in this
//! crate's captures: it is direct light, which renderers add by themselves.

use super::captures::{CaptureMode, NEAR};
use super::gather::{Gather, GatherDesc, Gathering};
use super::light_set::LightSettings;
use super::probes::{ProbeError, Result, light_surfaces};
use super::{Ground, Sky};
use crate::math::capture::{Basis, Projection};
use crate::passes::capture_compute::CaptureCompute;
use crate::passes::cluster_tree::{Detail, TreeSize};
use crate::passes::geometry::{CellBudget, Geometry};
use crate::passes::material::Textures;
use crate::scene::Scene;
use crate::vk::gpu_types::Frame;
use crate::vk::pass::Recorder;
use crate::vk::{Device, Error as VulkanError};
use glam::Vec3;
use std::sync::Arc;

/// The farthest distance that counts, in radii of the scene's bounding sphere: all of the scene is nearer from any point in it.
const FARTHEST: f32 = 2.0;

/// How points look at the scene and how the scene is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereProbeSettings {
    /// Order of the harmonics, 1 to [`crate::math::sh::MAX_ORDER`]: its square is the number of coefficients.
    pub order: u32,
    /// Texels a side of each of the six faces: even, from 8 to 256.
    pub capture_size: u32,
    /// [`CaptureMode::Hemicube`] for render passes, [`CaptureMode::Compute`] for compute, [`CaptureMode::Auto`] for what the
    /// device is faster by.
    pub capture: CaptureMode,
    /// Whether gradients are computed.
    pub gradients: bool,
    /// Keeps distances by direction, none longer than this or twice the radius of the scene's bounding sphere, whichever is longer.
    pub distances: Option<f32>,
    /// Direct light on the surfaces.
    pub lights: LightSettings,
    /// Cells that the surfaces are cut into, about; each triangle has at least one.
    pub surface_cells: u32,
}

impl SphereProbeSettings {
    /// Surface cells for a scene where nothing says how many: enough for what a face's texel sees of it.
    pub fn usual_cells(scene: &Scene) -> u32 {
        (40 * scene.triangles.len() as u64).clamp(1 << 16, 1 << 20) as u32
    }
}

/// A scene with its surfaces lit, ready to be looked at from any point.
pub struct SphereProbes<'a> {
    scene: &'a Scene,
    geometry: Geometry,
    textures: Option<Textures>,
    gather: Gather,
    _sky: Option<Sky>,
}

impl<'a> SphereProbes<'a> {
    /// Uploads `scene`, lights its surfaces directly and builds the passes that look at them.
    ///
    /// # Errors
    /// The device's, or too many lights.
    pub fn new(
        device: &Arc<Device>,
        recorder: &mut Recorder,
        scene: &'a Scene,
        settings: &SphereProbeSettings,
    ) -> Result<Self> {
        let in_compute = runs_in_compute(device, scene, settings);
        let textures = Textures::new(device, scene)?;
        let cells = CellBudget::even(settings.surface_cells);
        let geometry = Geometry::new(device, scene, &cells, in_compute.then_some(Detail::Exact))?;
        let has_sky = !scene.background.is_black();
        let sky = has_sky.then(|| Sky::new(device, &scene.background, settings.capture_size, false)).transpose()?;
        let ground = Ground { scene, geometry: &geometry, textures: textures.as_ref() };
        light_surfaces(device, recorder, &ground, scene, &settings.lights)?;
        let desc = GatherDesc {
            projection: Projection::Cube,
            basis: Basis::Sh(settings.order),
            size: settings.capture_size,
            gradients: settings.gradients,
            in_compute,
            distances: settings.distances.map(|reach| reach.max(FARTHEST * geometry.radius)),
        };
        let gather = Gather::new(device, &ground, sky.as_ref().map(Sky::captured), desc)?;
        Ok(Self { scene, geometry, textures, gather, _sky: sky })
    }

    /// Measures at all `points`, relative to the scene's origin, in batches; `done` hears how many a batch had. Coefficients and
    /// gradients are along the world's axes.
    ///
    /// # Errors
    /// The device's.
    pub fn measure(
        &self,
        recorder: &mut Recorder,
        points: &[Vec3],
        mut done: impl FnMut(usize),
    ) -> Result<Vec<Gathering>> {
        let ground = Ground { scene: self.scene, geometry: &self.geometry, textures: self.textures.as_ref() };
        let mut measured = Vec::with_capacity(points.len());
        for batch in points.chunks(self.gather.capacity()) {
            let frames: Vec<Frame> = batch.iter().map(|point| frame(*point, self.geometry.radius)).collect();
            measured.extend(self.gather.run(recorder, &ground, &frames)?);
            done(batch.len());
        }
        Ok(measured)
    }
}

/// [`SphereProbes`] that go on by render passes where the device's driver ends the loops of captures in compute, unless compute
/// was asked for.
pub struct SteadyProbes<'a> {
    device: Arc<Device>,
    scene: &'a Scene,
    settings: SphereProbeSettings,
    probes: SphereProbes<'a>,
}

impl<'a> SteadyProbes<'a> {
    /// As [`SphereProbes::new`].
    ///
    /// # Errors
    /// The device's, or too many lights.
    pub fn new(
        device: &Arc<Device>,
        recorder: &mut Recorder,
        scene: &'a Scene,
        settings: &SphereProbeSettings,
    ) -> Result<Self> {
        let probes = SphereProbes::new(device, recorder, scene, settings)?;
        Ok(Self { device: device.clone(), scene, settings: *settings, probes })
    }

    /// As [`SphereProbes::measure`]. `done` hears of some points twice where captures begin again.
    ///
    /// # Errors
    /// The device's.
    pub fn measure(
        &mut self,
        recorder: &mut Recorder,
        points: &[Vec3],
        done: &mut dyn FnMut(usize),
    ) -> Result<Vec<Gathering>> {
        match self.probes.measure(recorder, points, &mut *done) {
            Err(ProbeError::Vulkan(VulkanError::LoopsEnded { .. })) if self.settings.capture == CaptureMode::Auto => {
                self.settings.capture = CaptureMode::Hemicube;
                self.probes = SphereProbes::new(&self.device, recorder, self.scene, &self.settings)?;
                self.probes.measure(recorder, points, done)
            }
            found => found,
        }
    }
}

fn runs_in_compute(device: &Device, scene: &Scene, settings: &SphereProbeSettings) -> bool {
    let asked = match settings.capture {
        CaptureMode::Auto => device.is_cpu(),
        mode => mode.wants_compute(),
    };
    asked
        && CaptureCompute::misfit(device, scene, Projection::Cube, settings.capture_size).is_none()
        && TreeSize::exact(scene.triangles.len()).misfit(device).is_none()
}

/// A cube with the world's axes, which sees in all directions.
fn frame(point: Vec3, scene_radius: f32) -> Frame {
    Frame {
        origin: point.extend(scene_radius * NEAR).to_array(),
        tangent: Vec3::X.extend(1.0).to_array(),
        bitangent: Vec3::Y.extend(1.0).to_array(),
        normal: Vec3::Z.extend(1.0).to_array(),
        horizon: [0.0, 0.0, 0.0, 1.0],
    }
}

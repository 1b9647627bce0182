//! Irradiance at given places: what a record of the cache holds, without a camera.
//!
//! The same passes as in the cache: direct light on the surface cells once, then captures and their integrals in batches.
//! What the cache does with records (placing, splatting) has no part here, so that single records can be held against
//! closed forms, and so that light can be baked at vertices or lightmap texels.

use super::captures::{CaptureMode, CaptureSettings, Captures, LIFT, NEAR, NoSlices};
use super::casters::Casters;
use super::direct::DirectLight;
use super::light_samples::{TooManyLights, light_sets};
use super::light_set::{Extent, LightSettings};
use super::surface_cache::read_surface;
use super::{Ground, Sky};
use crate::math::cells;
use crate::passes::cluster_tree::Detail;
use crate::passes::geometry::{CellBudget, Geometry};
use crate::passes::integrate::{Gradients, Integrate, Limits, Radius};
use crate::passes::material::Textures;
use crate::scene::Scene;
use crate::vk::gpu_types::{Frame, Payload, Record};
use crate::vk::pass::Recorder;
use crate::vk::{Buffer, Device, Error as VulkanError, Memory};
use glam::{DVec3, Vec3, Vec4};
use std::sync::Arc;

/// Where irradiance is measured: a point of a surface that need not be part of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position, relative to the scene's origin.
    pub position: Vec3,
    /// Unit shading normal: the axis of the hemicube.
    pub normal: Vec3,
    /// Unit geometric normal, on the side of the shading normal: nothing below its plane is seen.
    pub geometric: Vec3,
    /// Turn of the hemicube about the normal, in radians: averages over turns have less aliasing.
    pub turn: f32,
}

/// Irradiance and its gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// E of each colour channel, W·m⁻².
    pub value: Vec3,
    /// ∇_r E of each channel: E changes by (n × n′)·∇_r E as the normal turns from n to n′. Zero if not asked for.
    pub rotation: [Vec3; 3],
    /// ∇_t E of each channel, W·m⁻² per unit of length, in the plane across the normal. Zero if not asked for.
    pub translation: [Vec3; 3],
}

/// What is found at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe {
    /// By light that surfaces reflect.
    pub reflected: Irradiance,
    /// By the sky's own light, where the background shines.
    pub sky: Option<Irradiance>,
    /// 1/R: the harmonic mean, cosine-weighted, of the distances that are seen. The sky is infinitely far.
    pub inverse_distance: f32,
}

/// A piece of the surface that has one radiance on each side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCell {
    /// Corners, counter-clockwise as seen from the front.
    pub corners: [DVec3; 3],
    /// Radiance to the front and to the back, W·sr⁻¹·m⁻².
    pub radiance: [Vec3; 2],
}

/// How places look at the scene and how the scene is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeSettings {
    /// How places look at the scene. Hemispheres by render passes want a scene that is cut small ([`Scene::tessellated`]); so
    /// do those in compute where they do not fit, as [`CaptureMode::against_compute`] says.
    pub capture: CaptureMode,
    /// Texels a side of a capture (a hemicube's top): even, from 8 to 256.
    pub capture_size: u32,
    /// Gradients that are computed.
    pub gradients: Gradients,
    /// Direct light on the surfaces.
    pub lights: LightSettings,
    /// Cells that the surfaces are cut into, about; each triangle has at least one.
    pub surface_cells: u32,
}

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The device or the driver.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The scene's lights.
    #[error(transparent)]
    Lights(#[from] TooManyLights),
    /// The way to capture.
    #[error(transparent)]
    Slices(#[from] NoSlices),
}

/// What may go wrong, or not.
pub type Result<T, E = ProbeError> = std::result::Result<T, E>;

/// A scene with its surfaces lit, ready to be looked at from anywhere.
pub struct Probes<'a> {
    scene: &'a Scene,
    geometry: Geometry,
    textures: Option<Textures>,
    captures: Captures,
    integrate: Integrate,
    records: Buffer,
    payloads: Buffer,
    results: [Buffer; 2],
    sky: Option<Sky>,
}

impl<'a> Probes<'a> {
    /// Uploads `scene`, lights its surfaces directly and builds the passes that look at them.
    pub fn new(
        device: &Arc<Device>,
        recorder: &mut Recorder,
        scene: &'a Scene,
        settings: &ProbeSettings,
    ) -> Result<Self> {
        let size = settings.capture_size;
        settings.capture.check(device, scene, size)?;
        let textures = Textures::new(device, scene)?;
        let in_compute = settings.capture.against_compute(device, scene, size).is_none();
        let geometry = Geometry::new(
            device,
            scene,
            &CellBudget::even(settings.surface_cells),
            in_compute.then_some(Detail::Exact),
        )?;
        let has_sky = !scene.background.is_black();
        let sky = has_sky.then(|| Sky::new(device, &scene.background, size, false)).transpose()?;
        let ground = Ground { scene, geometry: &geometry, textures: textures.as_ref() };
        light_surfaces(device, recorder, &ground, scene, &settings.lights)?;

        let captures = Captures::new(
            device,
            &ground,
            in_compute,
            CaptureSettings { mode: settings.capture, size, lod_error: 0.0, shared: false },
            (sky.as_ref().map(Sky::captured), settings.gradients.translation),
            None,
        )?;
        recorder.submit(|recording| captures.prepare(recording))?;
        let capacity = captures.capacity;
        let buffer = |bytes: usize, memory| Buffer::new(device, "records", u64::from(capacity) * bytes as u64, memory);
        let payload_bytes = size_of::<Payload>() * if has_sky { 2 } else { 1 };
        let records = buffer(size_of::<Record>(), Memory::Device)?;
        let payloads = buffer(payload_bytes, Memory::Device)?;
        let results = [buffer(size_of::<Record>(), Memory::Readback)?, buffer(payload_bytes, Memory::Readback)?];
        let limits = Limits { scene_radius: geometry.radius };
        let both = (&records, &payloads);
        let quantities = (settings.gradients, Radius::Harmonic);
        let integrate = Integrate::new(
            device,
            &geometry,
            &captures.captured(),
            both,
            sky.as_ref().map(Sky::captured),
            quantities,
            limits,
        )?;
        Ok(Self { scene, geometry, textures, captures, integrate, records, payloads, results, sky })
    }

    /// Whether gradients know of what is seen edge-on, thinner than a texel ([`crate::math::outline`]).
    pub fn follows_outlines(&self) -> bool {
        self.captures.follows_outlines
    }

    /// Measures all `places`, in batches; `done` hears how many a batch had.
    pub fn measure(
        &self,
        recorder: &mut Recorder,
        places: &[Place],
        mut done: impl FnMut(usize),
    ) -> Result<Vec<Probe>> {
        let mut probes = Vec::with_capacity(places.len());
        for batch in places.chunks(self.captures.capacity as usize) {
            self.batch(recorder, batch)?;
            probes.extend(self.read(batch.len()));
            done(batch.len());
        }
        Ok(probes)
    }

    /// The lit surface as captures see it, read back: every cell with its radiance.
    pub fn surface(&self, recorder: &mut Recorder, device: &Arc<Device>) -> Result<Vec<SurfaceCell>> {
        let ground = Ground { scene: self.scene, geometry: &self.geometry, textures: self.textures.as_ref() };
        let (radiance, first) = read_surface(device, recorder, &ground)?;
        let radiance = radiance.as_chunks::<2>().0;
        let of_triangle = |(triangle, range): (&[u32; 3], &[u32])| {
            let [p0, p1, p2] = triangle.map(|v| self.scene.positions[v as usize].as_dvec3());
            let count = range[1] - range[0];
            let cell = |i: u32| SurfaceCell {
                corners: cells::corners(count.isqrt(), i).map(|b| p0 + (p1 - p0) * b.x + (p2 - p0) * b.y),
                radiance: radiance[(range[0] + i) as usize].map(Vec3::from),
            };
            (0..count).map(cell).collect::<Vec<_>>()
        };
        Ok(self.geometry.triangles.iter().zip(first.windows(2)).flat_map(of_triangle).collect())
    }

    fn batch(&self, recorder: &mut Recorder, places: &[Place]) -> Result<()> {
        let geometry = &self.geometry;
        let frames: Vec<Frame> = places.iter().map(|place| frame(place, geometry, self.captures.scale())).collect();
        let records: Vec<Record> = places.iter().map(record).collect();
        self.captures.frames().upload(&frames)?;
        self.records.upload(&records)?;
        let ground = Ground { scene: self.scene, geometry: &self.geometry, textures: self.textures.as_ref() };
        let count = places.len() as u32;
        recorder.submit(|recording| {
            self.captures.record(recording, &ground, count)?;
            recording.pass("integrate", |c| {
                self.integrate.record(c, count);
                Ok(())
            })?;
            recording.pass("readback", |c| {
                c.copy_buffer(&self.records, &self.results[0], self.records.size);
                c.copy_buffer(&self.payloads, &self.results[1], self.payloads.size);
                Ok(())
            })
        })?;
        Ok(self.captures.check(recorder)?)
    }

    fn read(&self, count: usize) -> Vec<Probe> {
        let kinds = if self.sky.is_some() { 2 } else { 1 };
        let records: Vec<Record> = self.results[0].read(count);
        let payloads: Vec<Payload> = self.results[1].read(count * kinds);
        records
            .iter()
            .zip(payloads.chunks(kinds))
            .map(|(record, payloads)| Probe {
                reflected: irradiance(&payloads[0]),
                sky: payloads.get(1).map(irradiance),
                inverse_distance: record.normal[3],
            })
            .collect()
    }
}

/// Lights the surface cells directly, by the lights of `lit_by`, each reflecting to both sides what reaches them.
pub(super) fn light_surfaces(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    ground: &Ground<'_>,
    lit_by: &Scene,
    settings: &LightSettings,
) -> Result<()> {
    recorder.submit(|recording| {
        recording.pass("clear", |c| {
            c.fill(&ground.geometry.cell_radiance, 0);
            Ok(())
        })
    })?;
    let extent = Extent::of(ground.geometry);
    let casters = Arc::new(Casters::exact(device, ground)?);
    for set in light_sets(lit_by, extent, settings, !lit_by.background.is_black())? {
        DirectLight::new(device, set, ground, &casters, (true, false))?.run(recorder, ground, (true, None), |_| {})?;
    }
    Ok(())
}

/// The capture frame of a place; twin of `place_records.comp`.
pub(super) fn frame(place: &Place, geometry: &Geometry, scale: f32) -> Frame {
    let Place { position, normal: n, geometric, turn } = *place;
    // Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin 2017: a frame without a branch on the normal.
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let across = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let along = Vec3::new(b, sign + n.y * n.y * a, -n.y);
    let tangent = turn.cos() * across + turn.sin() * along;
    let origin = position + geometric * (geometry.core.scale_at(position) * LIFT);
    Frame {
        origin: with(origin, geometry.radius * NEAR),
        tangent: with(tangent, scale),
        bitangent: with(n.cross(tangent), scale),
        normal: with(n, 1.0),
        horizon: with(geometric, -geometric.dot(origin)),
    }
}

fn record(place: &Place) -> Record {
    Record {
        position: with(place.position, 0.0),
        normal: with(place.normal, 0.0),
        geometric: with(place.geometric, 1.0),
    }
}

fn irradiance(payload: &Payload) -> Irradiance {
    let xyz = |v: [f32; 4]| Vec4::from_array(v).truncate();
    Irradiance {
        value: xyz(payload.irradiance),
        rotation: payload.rotation.map(xyz),
        translation: payload.translation.map(xyz),
    }
}

fn with(v: Vec3, w: f32) -> [f32; 4] {
    v.extend(w).to_array()
}

//! A frame: the plan, then its passes in order.
//!
//! [`Plan::of`] says what a scene needs before anything is built; [`render`] builds that and nothing else, and runs it.

mod camera;
mod memory;
mod output;
mod plan;
mod settings;

pub use memory::{TooLarge, check as check_memory, largest_of, memory_needs};
pub use plan::{LeftOut, Plan};
pub use settings::{Settings, SettingsError};

use crate::image::Picture;
use crate::methods::captures::{CaptureMode, NoSlices};
use crate::methods::casters::{Casters, CoarseSurface};
use crate::methods::direct::DirectLight;
use crate::methods::irradiance_cache::{CacheStats, Features, IrradianceCache};
use crate::methods::light_samples::{TooManyLights, light_sets};
use crate::methods::light_set::{Extent, LightSet};
use crate::methods::records::Records;
use crate::methods::{Ground, Sky};
use crate::passes::gbuffer::{GBuffer, Targets};
use crate::passes::geometry::Geometry;
use crate::passes::material::Textures;
use crate::passes::resolve::{Inputs, Plane, Resolve};
use crate::scene::{Camera, Scene};
use crate::vk::pass::{PassTime, Recorder};
use crate::vk::{Buffer, Device, Error as VulkanError, Memory, MemoryUse, Span, barrier};
use camera::View;
use std::sync::Arc;
use std::time::Instant;

/// What can go wrong in a frame.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The device or the driver.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The settings.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The scene's lights.
    #[error(transparent)]
    Lights(#[from] TooManyLights),
    /// The scene's size.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The way to capture.
    #[error(transparent)]
    Slices(#[from] NoSlices),
}

/// A finished frame and what it cost.
pub struct Rendered {
    /// The layers that were asked for.
    pub picture: Picture,
    /// What ran and what did not.
    pub plan: Plan,
    /// What went otherwise than planned, a line each, for the user.
    pub warnings: Vec<String>,
    /// What the cache did.
    pub cache: CacheStats,
    /// Every pass that ran, in order.
    pub passes: Vec<PassTime>,
    /// Every submission.
    pub submissions: Vec<Span>,
    /// Stages on the CPU, on the same clock as the passes ([`Device::opened`]).
    pub stages: Vec<(String, Span)>,
    /// Device memory.
    pub memory: MemoryUse,
}

/// Hears how far a long stage is: its name, done and all.
pub type OnProgress<'a> = &'a mut dyn FnMut(&'static str, u64, u64);

/// Renders `scene` from `camera`.
///
/// Where the device ends the loops of captures in compute, whole workgroups share each view; where that is not enough, or the
/// surface turns out too large for compute once it is arranged, with levels of detail and without, and nobody asked for compute,
/// render passes capture. A warning says so, and the plan.
pub fn render(
    device: &Arc<Device>,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    on_progress: OnProgress<'_>,
) -> Result<Rendered, RenderError> {
    render_with(device, scene, camera, settings, &mut None, on_progress)
}

/// Renders `scene` from `camera` with the records that `kept` holds from earlier views of the same scene under the same settings of the
/// cache, and keeps those that it adds. None are kept where the frame fails.
///
/// # Errors
/// The same as [`render`].
pub fn render_with(
    device: &Arc<Device>,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    kept: &mut Option<Records>,
    on_progress: OnProgress<'_>,
) -> Result<Rendered, RenderError> {
    let (mut clock, mut settings, mut instead) = (Clock::new(device), settings.clone(), None);
    loop {
        match render_as_set(device, scene, camera, &settings, (kept, &mut clock), on_progress) {
            Err(RenderError::Vulkan(VulkanError::LoopsEnded { shared: false })) => {
                instead = Some(Instead::Workgroups);
                settings.cache.share_views = true;
            }
            Err(RenderError::Vulkan(VulkanError::LoopsEnded { .. })) if settings.cache.capture == CaptureMode::Auto => {
                instead = Some(Instead::RenderPasses);
                settings.cache.capture = CaptureMode::Hemicube;
            }
            Err(RenderError::Memory(error)) if settings.cache.capture == CaptureMode::Auto => {
                instead = Some(Instead::TooLarge(error));
                settings.cache.capture = CaptureMode::Hemicube;
            }
            Err(error) => {
                *kept = None;
                return Err(error);
            }
            Ok(rendered) => return Ok(rendered.drawn(instead)),
        }
        *kept = None;
        clock.lap("captures in compute, given up");
    }
}

/// What drew a frame that was planned otherwise.
enum Instead {
    /// Whole workgroups, for the device had ended the loops of captures in compute.
    Workgroups,
    /// Render passes, for that reason.
    RenderPasses,
    /// Render passes, for captures in compute took too much memory.
    TooLarge(TooLarge),
}

impl Rendered {
    fn drawn(mut self, instead: Option<Instead>) -> Self {
        let (why, by) = match instead {
            None => return self,
            Some(Instead::Workgroups) => (LOOPS_ENDED.into(), "whole workgroups drew the frame anew"),
            Some(Instead::RenderPasses) => {
                (LOOPS_ENDED.into(), "render passes drew the frame anew; --capture hemicube takes them at once")
            }
            Some(Instead::TooLarge(ref error)) => {
                (format!("captures in compute do not fit: {error}"), "render passes drew the frame")
            }
        };
        if !matches!(instead, Some(Instead::Workgroups)) {
            self.plan = self.plan.of_render_passes(&why);
        }
        self.warnings.push(format!("{why}, and {by}"));
        self
    }
}

const LOOPS_ENDED: &str = "the device ended the loops of captures in compute before all was drawn";

fn render_as_set(
    device: &Arc<Device>,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    (kept, clock): (&mut Option<Records>, &mut Clock),
    on_progress: OnProgress<'_>,
) -> Result<Rendered, RenderError> {
    settings.check(device)?;
    let mut plan = Plan::of(scene, camera, settings, Some(device));
    let cut = plan.cut.map(|limit| scene.tessellated(&limit));
    let scene = cut.as_ref().unwrap_or(scene);
    if cut.is_some() {
        plan = Plan::of(scene, camera, settings, Some(device)).of_cut();
        clock.lap("tessellate");
    }
    if plan.captures {
        settings.cache.capture.check(device, scene, settings.cache.capture_size)?;
    }
    let (arrangement, mut plan, warning) = memory::arrange(device, scene, plan, settings)?;
    clock.lap("arrange scene");
    let size = [settings.width, settings.height];
    let view = View::new(scene, camera, size);

    // What the scene is made of.
    let textures = Textures::new(device, scene)?;
    let textures = textures.as_ref();
    let geometry = Geometry::of(device, scene, arrangement)?;
    let sky = plan.sky.then(|| Sky::new(device, &scene.background, true)).transpose()?;
    clock.lap("upload scene");

    // What is seen.
    let gbuffer = GBuffer::new(device, scene, &geometry, textures, size, plan.emission)?;
    // What lights it directly.
    let extent = Extent { bounds: geometry.bounds, radius: geometry.radius };
    let sets = light_sets(scene, extent, &settings.lights, plan.sky && plan.captures && settings.bounces > 0)?;
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    let direct =
        plan.lights.then(|| Buffer::new(device, "direct irradiance", pixels * 16, Memory::Device)).transpose()?;
    let ground = Ground { scene, geometry: &geometry, textures };
    let pixels = direct.as_ref().map(|direct| (&gbuffer.targets, direct));
    let cells = plan.captures && settings.bounces > 0;
    let coarse = plan.coarse_casters.then(|| CoarseSurface::new(device, &ground)).transpose()?.flatten();
    if plan.coarse_casters && coarse.is_none() {
        plan = plan.of_own_casters();
    }
    let lights = build_lights(device, sets, &ground, coarse.as_ref(), pixels, cells)?;
    // What it reflects.
    let counts_records = settings.planes.contains(&Plane::Records);
    let features = Features {
        sky: sky.as_ref().map(Sky::captured),
        in_compute: plan.compute,
        counts_records,
        counts_work: settings.counts_work,
    };
    if plan.captures && kept.as_ref().is_none_or(|store| store.shape() != settings.cache.kept(sky.is_some())) {
        *kept = Some(Records::new(device, settings.cache.kept(sky.is_some()))?);
    }
    let store = kept.as_mut().filter(|_| plan.captures);
    let new_cache =
        |store: &Records| IrradianceCache::new(device, &ground, &gbuffer.targets, store, features, settings.cache);
    let cache = store.as_deref().map(new_cache).transpose()?;
    // The image.
    let inputs = Inputs {
        gbuffer: &gbuffer.targets,
        sums: cache.as_ref().map(|cache| &cache.splat.sums),
        direct: direct.as_ref(),
        sky: sky.as_ref().map(Sky::seen),
    };
    let resolve = Resolve::new(device, &inputs, &settings.planes)?;
    clock.lap("build passes");
    on_progress("build passes", 1, 1);

    let mut recorder = Recorder::new(device);
    recorder.submit(|recording| {
        recording.pass("clear", |c| {
            if let Some(direct) = &direct {
                c.fill(direct, 0);
            }
            c.fill(&geometry.cell_radiance, 0);
            Ok(())
        })?;
        recording.pass("gbuffer", |c| {
            gbuffer.record(c, scene, &geometry, textures, view.world_to_clip, view.eye);
            Ok(())
        })
    })?;
    let total = lights.iter().map(DirectLight::sample_count).sum::<usize>() as u64;
    let mut lit = 0;
    for light in &lights {
        light.run(&mut recorder, &ground, |samples| {
            lit += samples as u64;
            on_progress("direct light", lit, total);
        })?;
    }
    let cache_stats = match cache.as_ref().zip(store) {
        Some((cache, store)) => {
            let viewpoint = view.viewpoint(&settings.cache, geometry.radius);
            cache.run(&mut recorder, &ground, (&gbuffer.targets, &viewpoint), store, |_, share| {
                on_progress("records", (share * 1000.0) as u64, 1000);
            })?
        }
        None => CacheStats::default(),
    };
    recorder.submit(|recording| {
        recording.pass("resolve", |c| {
            resolve.record(c, view.clip_to_world_direction, view.axis);
            Ok(())
        })?;
        recording.pass("readback", |c| {
            barrier::full(c);
            resolve.record_readback(c);
            Ok(())
        })
    })?;
    clock.lap("run passes");
    let picture = output::picture(&resolve, &settings.planes, size, scene.origin);
    clock.lap("read result");
    Ok(Rendered {
        picture,
        plan,
        warnings: warning.into_iter().chain(sky.and_then(|sky| sky.note)).collect(),
        cache: cache_stats,
        passes: recorder.passes,
        submissions: recorder.submissions,
        stages: std::mem::take(&mut clock.stages),
        memory: device.memory(),
    })
}

fn build_lights<'a>(
    device: &Arc<Device>,
    sets: Vec<LightSet>,
    ground: &Ground<'a>,
    coarse: Option<&'a CoarseSurface>,
    pixels: Option<(&Targets, &Buffer)>,
    cells: bool,
) -> Result<Vec<DirectLight<'a>>, VulkanError> {
    let needed = |set: &LightSet| cells || !set.cells_only;
    let sets: Vec<_> = sets.into_iter().filter(needed).collect();
    let coarse = coarse.map(|coarse| Casters::coarse(device, coarse)).transpose()?.map(Arc::new);
    let is_exact = |set: &LightSet| coarse.is_none() || !set.cells_only;
    let exact = sets.iter().any(is_exact).then(|| Casters::exact(device, ground)).transpose()?.map(Arc::new);
    let new = |set: LightSet| {
        let casters = if is_exact(&set) { &exact } else { &coarse };
        casters.as_ref().map(|casters| DirectLight::new(device, set, ground, casters, pixels, cells))
    };
    sets.into_iter().filter_map(new).collect()
}

/// Splits the time since it was made into named stages, on the clock of the device.
struct Clock {
    started: Instant,
    last_ms: f64,
    stages: Vec<(String, Span)>,
}

impl Clock {
    fn new(device: &Device) -> Self {
        let started = device.opened;
        Self { started, last_ms: started.elapsed().as_secs_f64() * 1e3, stages: Vec::new() }
    }

    fn lap(&mut self, name: &str) {
        let now = self.started.elapsed().as_secs_f64() * 1e3;
        self.stages.push((name.into(), Span { begin_ms: self.last_ms, end_ms: now }));
        self.last_ms = now;
    }
}

//! A scene on the device, and views of it.
//!
//! [`Renderer::open`] plans, uploads and builds what follows from the scene, once; [`Renderer::render`] makes views of it, one
//! after the other. [`Plan::of`] says what a scene needs before anything is built: that is built and run, and nothing else.
//! [`render`] does both for a single frame.

mod camera;
mod fallback;
mod memory;
mod origin;
mod output;
mod plan;
mod settings;
mod surface;
mod view;

pub use memory::{TooLarge, check as check_memory, largest_of, memory_needs};
pub use plan::{LeftOut, Part, Plan};
pub use settings::{Settings, SettingsError, ViewSettings};

use crate::image::Picture;
use crate::methods::captures::NoSlices;
use crate::methods::irradiance_cache::{CacheSettings, CacheStats};
use crate::methods::light_samples::TooManyLights;
use crate::methods::records::{Records, Stored};
use crate::methods::surface_cache::Bounced;
use crate::scene::{Camera, Scene};
use crate::vk::pass::{PassTime, Recorder};
use crate::vk::{Device, Error as VulkanError, MemoryUse, Span};
use fallback::Fallback;
use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;
use surface::Surface;
use view::View;

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
    /// Records that are not of this scene and these settings.
    #[error("the records are none of this scene and these settings")]
    OtherRecords,
}

/// A finished frame and what it cost.
pub struct Rendered {
    /// The layers that were asked for.
    pub picture: Picture,
    /// What ran and what did not.
    pub plan: Plan,
    /// What went otherwise than planned, since the scene was opened, a line each, for the user.
    pub warnings: Vec<String>,
    /// What was done for light beyond the first bounce; none where none was asked for.
    pub bounced: Option<Bounced>,
    /// What the cache did.
    pub cache: CacheStats,
    /// Every pass that ran, in order.
    pub passes: Vec<PassTime>,
    /// Every submission.
    pub submissions: Vec<Span>,
    /// Stages on the CPU since the frame before, on the same clock as the passes ([`Device::opened`]).
    pub stages: Vec<(String, Span)>,
    /// Device memory.
    pub memory: MemoryUse,
}

/// Hears how far a long stage is: its name, done and all.
pub type OnProgress<'a> = &'a mut dyn FnMut(&'static str, u64, u64);

/// Renders one frame of `scene` from `camera`: for more of them, keep a [`Renderer`].
pub fn render(
    device: &Arc<Device>,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    on_progress: OnProgress<'_>,
) -> Result<Rendered, RenderError> {
    Renderer::open(device, scene, settings, on_progress)?.render(camera, &settings.view(), on_progress)
}

/// A scene on the device, ready to be looked at from anywhere.
///
/// What it holds follows from the scene and from the settings that it was opened with, not from any camera: geometry, the tree
/// that captures walk, textures, the sky, light samples, the lit surface, and records. The first view lights the surface; later views
/// take it as it is. They start from the records that there are, unless other settings of the cache ask for other records, and keep
/// those that they add.
///
/// ```
/// use hemicube::{renderer::{Renderer, Settings}, scene, vk};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = scene::cornell();
/// let device = vk::Device::new(vk::Instance::new(false)?, &vk::DeviceChoice::Best)?;
/// let settings = Settings { width: 32, height: 32, ..Settings::default() };
/// let mut renderer = Renderer::open(&device, &scene, &settings, &mut |_stage, _done, _all| {})?;
/// let mut camera = scene.cameras[0].clone();
/// for _ in 0..2 {
///     let rendered = renderer.render(&camera, &settings.view(), &mut |_stage, _done, _all| {})?;
///     println!("{} passes", rendered.passes.len());
///     camera.camera_to_world.w_axis.x += 0.05;
/// }
/// # Ok(())
/// # }
/// ```
pub struct Renderer<'a> {
    device: Arc<Device>,
    scene: Cow<'a, Scene>,
    settings: Settings,
    plan: Plan,
    warnings: Vec<String>,
    surface: Surface,
    records: Option<Records>,
    /// How the records were made.
    records_by: CacheSettings,
    view: Option<View>,
    stop: Box<dyn Fn() -> bool + 'a>,
    clock: Clock,
}

impl<'a> Renderer<'a> {
    /// Plans frames of `scene` by `settings`, uploads it and builds the passes that light its surface.
    ///
    /// Where its surface turns out too large for captures in compute once it is arranged, with levels of detail and without, and
    /// nobody asked for compute, render passes capture: a warning says so, and the plan.
    pub fn open(
        device: &Arc<Device>,
        scene: &'a Scene,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<Self, RenderError> {
        settings.check(device)?;
        let (mut clock, mut settings) = (Clock::new(device), settings.clone());
        let prepared = match Prepared::new(device, scene, &settings, &mut clock) {
            Err(RenderError::Memory(error)) => {
                let fallback = Fallback::of_memory(error, &settings)?;
                clock.lap("captures in compute, given up");
                fallback.apply(&mut settings);
                let mut prepared = Prepared::new(device, scene, &settings, &mut clock)?;
                prepared.plan = fallback.plan(prepared.plan);
                prepared.warnings.push(fallback.warning());
                prepared
            }
            prepared => prepared?,
        };
        let Prepared { scene, arrangement, mut plan, mut warnings } = prepared;
        let surface = Surface::new(device, &scene, arrangement, &mut plan, &settings, &mut clock)?;
        warnings.extend(surface.note());
        let records = new_records(device, &plan, &surface, &settings)?;
        clock.lap("build lights");
        on_progress("build lights", 1, 1);
        Ok(Self {
            device: device.clone(),
            scene,
            records_by: settings.cache,
            settings,
            plan,
            warnings,
            surface,
            records,
            view: None,
            stop: Box::new(|| false),
            clock,
        })
    }

    /// Forgets the records of all views so far: the next one is what a view on its own would be.
    pub fn forget_records(&mut self) {
        if let Some(records) = &mut self.records {
            records.truncate(0);
        }
    }

    /// Views make no more records once `stop` says so. Their pictures are complete, of what records there are, a batch at least, and
    /// [`CacheStats::unfinished`] says so. Later views use these records; where they cover a pixel, none are added for contrast.
    pub fn stop_when(&mut self, stop: impl Fn() -> bool + 'a) {
        self.stop = Box::new(stop);
    }

    /// All records, to be used again by another renderer of the scene ([`Self::use_records`],
    /// [`crate::methods::records::file`]). None where its views need none.
    ///
    /// # Errors
    /// The device fails or has no memory left.
    pub fn records(&self) -> Result<Option<Stored>, RenderError> {
        Ok(self.records.as_ref().map(Records::stored).transpose()?)
    }

    /// Number of records.
    pub fn record_count(&self) -> u32 {
        self.records.as_ref().map_or(0, Records::count)
    }

    /// Views start from `stored` now, in place of the records of earlier ones. They are to be of this scene and these settings
    /// ([`crate::methods::records::file::Origin`]): what is kept of each is checked, the light is not.
    ///
    /// # Errors
    /// What is kept of each record differs; the device fails or has no memory left.
    pub fn use_records(&mut self, stored: &Stored) -> Result<(), RenderError> {
        match &mut self.records {
            Some(records) if records.shape() == stored.shape => Ok(records.replace_by(stored)?),
            None if stored.count() == 0 => Ok(()),
            _ => Err(RenderError::OtherRecords),
        }
    }

    /// What runs for a view, and what does not.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Renders a view from `camera`.
    ///
    /// Its passes and targets are kept: the next view by the same settings builds and uploads nothing. The way to capture is the one
    /// that the scene was opened with.
    ///
    /// Where the device ends the loops of captures in compute, whole workgroups share each view; where that is not enough, and
    /// nobody asked for compute, render passes capture. A warning says so, and the plan. The records are made anew then, and nothing
    /// else.
    pub fn render(
        &mut self,
        camera: &Camera,
        settings: &ViewSettings,
        on_progress: OnProgress<'_>,
    ) -> Result<Rendered, RenderError> {
        let mut settings = self.settings.with_view(settings);
        settings.check(&self.device)?;
        self.clock.skip();
        let mut view = self.view_of(&settings)?;
        on_progress("build passes", 1, 1);
        let mut recorder = Recorder::new(&self.device);
        let ground = self.surface.ground(&self.scene);
        let eyes = camera::View::new(&self.scene, camera, [settings.width, settings.height]);
        view.draw(&mut recorder, &ground, &eyes)?;
        self.surface.light(&mut recorder, &self.scene, &view.pixel_lights, on_progress)?;
        let on = (&self.device, &mut recorder);
        if let Some(warning) = self.surface.bounce(on, &self.scene, &self.plan, &settings, on_progress)? {
            self.warnings.push(warning);
        }
        let cache = loop {
            let ground = self.surface.ground(&self.scene);
            let before = self.records.as_ref().map_or(0, Records::count);
            let stats = view.run_cache(&mut recorder, &ground, &eyes, self.records.as_mut(), (&self.stop, on_progress));
            if let (Err(_), Some(records)) = (&stats, &mut self.records) {
                records.truncate(before);
            }
            match stats {
                Err(VulkanError::LoopsEnded { shared }) => {
                    self.give_way(Fallback::of_loops(shared, &settings)?, &mut settings);
                    let records = self.records.as_ref();
                    view.build_cache(&self.device, &self.surface, &self.scene, &self.plan, &settings, records)?;
                }
                stats => break stats?,
            }
        };
        let picture = view.resolve(&mut recorder, &eyes, &mut self.clock, self.scene.origin)?;
        self.view = Some(view);
        Ok(Rendered {
            picture,
            plan: self.plan.clone(),
            warnings: self.warnings.clone(),
            bounced: self.surface.bounced.clone(),
            cache,
            passes: recorder.passes,
            submissions: recorder.submissions,
            stages: std::mem::take(&mut self.clock.stages),
            memory: self.device.memory(),
        })
    }

    /// The view that was rendered last, if its settings were these; or a new one.
    fn view_of(&mut self, settings: &Settings) -> Result<View, RenderError> {
        if let Some(view) = self.view.take()
            && view.settings == *settings
        {
            return Ok(view);
        }
        self.plan = self.plan.clone().of_view(settings);
        check_memory(&self.device, &self.scene, &self.surface.size, &self.plan, settings)?;
        if self.records_by != settings.cache {
            self.records = new_records(&self.device, &self.plan, &self.surface, settings)?;
            self.records_by = settings.cache;
        }
        let view = View::new(&self.device, &self.surface, &self.scene, &self.plan, settings, self.records.as_ref())?;
        self.clock.lap("build passes");
        Ok(view)
    }

    /// Captures otherwise from now on.
    fn give_way(&mut self, fallback: Fallback, settings: &mut Settings) {
        fallback.apply(settings);
        fallback.apply(&mut self.settings);
        self.records_by = settings.cache;
        self.plan = fallback.plan(self.plan.clone());
        self.warnings.push(fallback.warning());
        self.clock.lap("captures in compute, given up");
    }
}

/// An empty store for the records of such views, if they have any.
fn new_records(
    device: &Arc<Device>,
    plan: &Plan,
    surface: &Surface,
    settings: &Settings,
) -> Result<Option<Records>, VulkanError> {
    let new = || Records::new(device, settings.cache.kept(surface.sky.is_some()));
    plan.captures.then(new).transpose()
}

/// A scene that is cut and arranged as its plan says, before any of it is on the device.
struct Prepared<'a> {
    scene: Cow<'a, Scene>,
    arrangement: crate::passes::geometry::Arrangement,
    plan: Plan,
    warnings: Vec<String>,
}

impl<'a> Prepared<'a> {
    fn new(
        device: &Arc<Device>,
        scene: &'a Scene,
        settings: &Settings,
        clock: &mut Clock,
    ) -> Result<Self, RenderError> {
        let mut plan = Plan::of(scene, settings, Some(device));
        let cut = plan.cut.as_ref().map(|limit| scene.tessellated(limit));
        if let Some(cut) = &cut {
            // What is finer where follows from the scene as it is, not from its pieces.
            let foci = plan.surface_cells.foci;
            plan = Plan::of(cut, settings, Some(device)).of_cut();
            plan.surface_cells.foci = foci;
            clock.lap("tessellate");
        }
        let scene = cut.map_or(Cow::Borrowed(scene), Cow::Owned);
        if plan.captures {
            settings.cache.capture.check(device, &scene, settings.cache.capture_size)?;
        }
        let (arrangement, plan, warning) = memory::arrange(device, &scene, plan, settings)?;
        clock.lap("arrange scene");
        Ok(Self { scene, arrangement, plan, warnings: warning.into_iter().collect() })
    }
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

    /// The time since the last stage belongs to none.
    fn skip(&mut self) {
        self.last_ms = self.started.elapsed().as_secs_f64() * 1e3;
    }

    fn lap(&mut self, name: &str) {
        let now = self.started.elapsed().as_secs_f64() * 1e3;
        self.stages.push((name.into(), Span { begin_ms: self.last_ms, end_ms: now }));
        self.last_ms = now;
    }
}

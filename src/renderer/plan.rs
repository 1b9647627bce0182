//! The plan: what a scene needs, and why the rest is left out.

use super::Settings;
use crate::methods::captures::CaptureMode;
use crate::methods::casters::FEWEST_TO_SIMPLIFY;
use crate::methods::emitter_samples::MOST_FACES;
use crate::methods::has_suns;
use crate::methods::irradiance_cache::CacheSettings;
use crate::passes::capture::WHOLE_SCENE;
use crate::passes::cluster_tree::Detail;
use crate::passes::geometry::{CellBudget, cell_count};
use crate::passes::resolve::Plane;
use crate::scene::{Background, Light, Scene, SideLimit};
use crate::vk::Device;
use glam::Vec3;

/// Opaque triangles from which levels of detail are made. Fewer are drawn sooner than coarser ones made.
const FEWEST_FOR_LEVELS: u32 = 1 << 17;

const NO_ERROR: &str = "no error is allowed for them (--lod-error 0)";
const NO_BOUNCES: &str = "no bounces are asked for";
const NO_LIGHT: &str = "nothing shines";
const NO_SKY: &str = "the background is black";

/// What a frame may consist of: passes, and parts of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Triangles are cut smaller.
    Tessellate,
    /// What pixels show.
    GBuffer,
    /// The G-buffer holds emission.
    Emission,
    /// Materials have textures.
    Textures,
    /// Materials have alpha masks.
    AlphaMask,
    /// Directional lights.
    DirectionalShadows,
    /// Point lights.
    PointShadows,
    /// Spot lights.
    SpotShadows,
    /// Emissive triangles.
    AreaShadows,
    /// Small bright regions of the background.
    SunShadows,
    /// Shadow maps.
    Shadow,
    /// Direct light of pixels.
    PixelLight,
    /// The background shines.
    Sky,
    /// The sky's shadows on surface cells are cast by a coarser surface, if one with far fewer triangles is close enough.
    CoarseCasters,
    /// Direct light of surface cells.
    SurfaceLight,
    /// Light goes on from cell to cell.
    SurfaceCache,
    /// Pixels without records are found.
    FindUncovered,
    /// Records are placed.
    PlaceRecords,
    /// Render passes capture.
    Capture,
    /// Compute captures.
    CaptureCompute,
    /// With levels of detail.
    Levels,
    /// What is far is captured as slices of voxels.
    Slices,
    /// Captures are integrated.
    Integrate,
    /// Records are kept for later views.
    KeepRecords,
    /// Kept records are sorted by place, so that neighbours are found.
    IndexRecords,
    /// Zones get their radii: by neighbours, if those are indexed, and by the view's limits.
    ClampRecords,
    /// Records are splatted.
    Splat,
    /// Records are added where others disagree.
    Contrast,
    /// Records do not light what they do not see.
    HiddenPoints,
    /// Triangles are culled.
    Cull,
    /// The records of each pixel are counted.
    RecordCounts,
    /// The layers of the image are made.
    Resolve,
}

impl Part {
    /// Its name in reports; that of its pass, if it is one.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tessellate => "tessellate",
            Self::GBuffer => "gbuffer",
            Self::Emission => "emission",
            Self::Textures => "textures",
            Self::AlphaMask => "alpha mask",
            Self::DirectionalShadows => "directional shadows",
            Self::PointShadows => "point shadows",
            Self::SpotShadows => "spot shadows",
            Self::AreaShadows => "area shadows",
            Self::SunShadows => "sun shadows",
            Self::Shadow => "shadow",
            Self::PixelLight => "pixel_light",
            Self::Sky => "sky",
            Self::CoarseCasters => "coarse casters",
            Self::SurfaceLight => "surface_light",
            Self::SurfaceCache => "surface cache",
            Self::FindUncovered => "find_uncovered",
            Self::PlaceRecords => "place_records",
            Self::Capture => "capture",
            Self::CaptureCompute => "capture_compute",
            Self::Levels => "levels of detail",
            Self::Slices => "slices",
            Self::Integrate => "integrate",
            Self::KeepRecords => "keep_records",
            Self::IndexRecords => "index_records",
            Self::ClampRecords => "clamp_records",
            Self::Splat => "splat",
            Self::Contrast => "contrast",
            Self::HiddenPoints => "hidden points",
            Self::Cull => "cull",
            Self::RecordCounts => "record counts",
            Self::Resolve => "resolve",
        }
    }
}

/// A part that does not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Name of the pass or part.
    pub pass: &'static str,
    /// Why it is not needed.
    pub why: String,
}

/// What is built and run for a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Every part in order, and why it does not run if so.
    steps: Vec<(Part, Option<String>)>,
    /// How triangles are to be cut first.
    pub cut: Option<SideLimit>,
    /// Records are captured.
    pub captures: bool,
    /// Cells that the surface is cut into; one a triangle where no capture reads them.
    pub surface_cells: CellBudget,
}

impl Plan {
    /// Plans a frame of `scene`.
    ///
    /// Without a device, captures are taken to be render passes.
    pub fn of(scene: &Scene, settings: &Settings, device: Option<&Device>) -> Self {
        let facts = Facts::of(scene);
        let full = settings.full_plan;
        let mut plan = Self::default();
        let shines = facts.is_lit() || facts.sky;
        let indirect = settings.bounces > 0 && (shines || full);
        // Dark cells are no finer anywhere: nothing is cut for them.
        plan.surface_cells = if indirect { cells(scene, shines, settings) } else { CellBudget::even(1) };
        let limit = settings.side_limit(scene, plan.surface_cells.foci.clone(), device);
        plan.cut = limit.cuts(scene).then_some(limit);
        let why =
            "no side is too long for captures, settings, or cells that are finer near details and cameras of the file";
        plan.part(Part::Tessellate, plan.cut.is_some(), why);
        plan.part(Part::GBuffer, true, "");
        plan.part(Part::Emission, facts.emits || full, "no material emits");
        plan.part(Part::Textures, facts.textured, "no material has a texture");
        plan.part(Part::AlphaMask, facts.masked, "no material has an alpha mask");
        for (part, present, why) in facts.light_kinds() {
            plan.part(part, present, why);
        }
        let lights = facts.is_lit() || full;
        plan.part(Part::Shadow, lights, "no lights");
        plan.part(Part::PixelLight, lights, "no lights");
        let sky = plan.part(Part::Sky, facts.sky || full, NO_SKY);
        plan.coarse_casters_part(settings, &facts);
        plan.captures = indirect || sky;
        let why = if settings.bounces == 0 { NO_BOUNCES } else { NO_LIGHT };
        plan.part(Part::SurfaceLight, indirect, why);
        let again = if indirect { "no second bounce is asked for" } else { why };
        plan.part(Part::SurfaceCache, indirect && settings.cell_bounces() > 0, again);
        let cache = &settings.cache;
        let against_compute = settings.against_compute(scene, device);
        let compute = plan.captures && against_compute.is_none();
        for pass in [Part::FindUncovered, Part::PlaceRecords] {
            plan.part(pass, plan.captures, why);
        }
        if plan.captures {
            plan.capture_parts(against_compute, facts.opaque, cache);
        } else {
            plan.part(Part::Capture, false, why);
        }
        plan.part(Part::Integrate, plan.captures, why);
        plan.cache_parts(settings);
        let triangles = scene.triangles.len();
        let drawn = lights || (plan.captures && !compute);
        let whole = if drawn { format!("{triangles} triangles are drawn whole") } else { "nothing to cull for".into() };
        plan.part(Part::Cull, drawn && triangles > WHOLE_SCENE as usize, whole);
        plan.part(Part::Resolve, true, "");
        plan
    }

    /// The plan for a scene that was cut, as one that says so.
    pub(super) fn of_cut(mut self) -> Self {
        self.part(Part::Tessellate, true, "");
        self
    }

    /// The plan of views by other settings of the cache and of the image than those of the scene's plan.
    pub(super) fn of_view(mut self, settings: &Settings) -> Self {
        self.cache_parts(settings);
        self
    }

    /// The plan of a frame by render passes that captures in compute were to draw, as one that says why they did not.
    pub(super) fn of_render_passes(mut self, why: &str) -> Self {
        self.part(Part::Capture, true, "");
        for part in [Part::CaptureCompute, Part::Levels] {
            self.part(part, false, why);
        }
        self
    }

    /// The plan of a frame whose surface could not be simplified far, as one that says so.
    pub(super) fn of_own_casters(mut self) -> Self {
        self.part(
            Part::CoarseCasters,
            false,
            "simplified, the surface keeps more than half of its triangles, or it lies in a far larger scene",
        );
        self
    }

    /// The plan of a frame whose levels of detail did not fit, as one that says so.
    pub(super) fn without_levels(mut self, why: &str) -> Self {
        self.part(Part::Levels, false, why);
        self
    }

    /// What settings of the cache and of the image ask for or not; `why` nothing is captured, if so.
    fn cache_parts(&mut self, settings: &Settings) {
        let (captures, cache) = (self.captures, &settings.cache);
        let why = if settings.bounces == 0 { NO_BOUNCES } else { NO_LIGHT };
        let or = |asked: bool, otherwise: &'static str| if captures && !asked { otherwise } else { why };
        let clamped = or(cache.clamped, "neighbours are not asked to clamp each other");
        self.part(Part::KeepRecords, captures, why);
        self.part(Part::IndexRecords, captures && cache.clamped, clamped);
        self.part(Part::ClampRecords, captures, why);
        self.part(Part::Splat, captures, why);
        let disputed = or(cache.contrast > 0.0, "records may disagree by anything (--contrast 0)");
        self.part(Part::Contrast, captures && cache.contrast > 0.0, disputed);
        let hidden =
            if cache.hidden { "the captures do not see the horizon" } else { "records may light what they do not see" };
        self.part(Part::HiddenPoints, captures && cache.rejects_hidden(), or(false, hidden));
        let counted = settings.planes.contains(&Plane::Records);
        let uncounted = or(counted, "the layer \"records\" is not asked for");
        self.part(Part::RecordCounts, captures && counted, uncounted);
    }

    /// Whether the sky's shadows are cast by a coarser surface.
    fn coarse_casters_part(&mut self, settings: &Settings, facts: &Facts) {
        let runs = facts.opaque >= FEWEST_TO_SIMPLIFY && settings.cache.lod_error > 0.0;
        let why = match (facts.sky, settings.bounces) {
            (false, _) => NO_SKY.into(),
            (true, 0) => NO_BOUNCES.into(),
            _ if settings.cache.lod_error <= 0.0 => NO_ERROR.into(),
            _ => format!("{} opaque triangles are drawn as soon as simplified", facts.opaque),
        };
        self.part(Part::CoarseCasters, runs && facts.sky && settings.bounces > 0, why);
    }

    /// How records look at the scene, and what that leaves out.
    fn capture_parts(&mut self, against_compute: Option<String>, opaque: u32, cache: &CacheSettings) {
        let CacheSettings { capture, lod_error, .. } = *cache;
        self.part(Part::Capture, against_compute.is_some(), "captures are rasterised in compute");
        let why = against_compute.unwrap_or_default();
        self.part(Part::CaptureCompute, why.is_empty(), why.clone());
        let why = if !why.is_empty() {
            why
        } else if lod_error <= 0.0 {
            NO_ERROR.into()
        } else {
            format!("{opaque} opaque triangles are drawn as soon as chosen from")
        };
        let many = opaque >= FEWEST_FOR_LEVELS && lod_error > 0.0;
        let compute = self.compute();
        self.part(Part::Levels, compute && many, why);
        let asked = matches!(capture, CaptureMode::Slices { .. });
        self.part(Part::Slices, compute && asked, "what is far is not asked for as slices (--capture slices)");
    }

    /// Whether a part runs.
    pub fn runs(&self, part: Part) -> bool {
        self.steps.iter().any(|(step, why)| *step == part && why.is_none())
    }

    /// Why a part does not run, if so.
    pub fn why_not(&self, part: Part) -> Option<&str> {
        self.steps.iter().find(|(step, _)| *step == part)?.1.as_deref()
    }

    /// Names of the passes and parts that run, in order.
    pub fn run(&self) -> Vec<&'static str> {
        self.steps.iter().filter(|(_, why)| why.is_none()).map(|(part, _)| part.name()).collect()
    }

    /// What is left out.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let left = |(part, why): &(Part, Option<String>)| why.clone().map(|why| LeftOut { pass: part.name(), why });
        self.steps.iter().filter_map(left).collect()
    }

    /// Some light is sampled with shadows.
    pub fn lights(&self) -> bool {
        self.runs(Part::Shadow)
    }

    /// Records are captured in compute.
    pub fn compute(&self) -> bool {
        self.runs(Part::CaptureCompute)
    }

    /// What captures in compute draw at a distance; none where captures are not in compute.
    pub fn detail(&self) -> Option<Detail> {
        self.compute().then_some(if self.runs(Part::Levels) { Detail::Levels } else { Detail::Exact })
    }

    /// Notes `part` as run or left out, in the place of what was noted of it before; returns whether it runs.
    fn part(&mut self, part: Part, runs: bool, why: impl Into<String>) -> bool {
        let why = (!runs).then(|| why.into());
        match self.steps.iter_mut().find(|(step, _)| *step == part) {
            Some(step) => step.1 = why,
            None => self.steps.push((part, why)),
        }
        runs
    }
}

/// Radiance of so many cells fits into a buffer on every device (maxStorageBufferRange is 2²⁷ bytes).
const MOST_CELLS: u64 = (1 << 27) / 24;

/// Cells for a scene: more for more detail, fewer where there are many light samples, so that lighting them stays within
/// about 2²⁶ pairs of the two, and what holds them within 2²⁷ bytes, as long as that leaves each triangle one.
fn cells(scene: &Scene, shines: bool, settings: &Settings) -> CellBudget {
    let new = |count| if shines { CellBudget::focused(scene, count) } else { CellBudget::even(count) };
    if let Some(count) = settings.surface_cells {
        return new(count);
    }
    let faces: u32 = scene.parts.iter().filter(|part| scene.emits(part)).map(|part| part.triangle_count).sum();
    let area = if faces > 0 { settings.lights.area_samples.max(faces.min(MOST_FACES as u32)) } else { 0 };
    let sky = if scene.background.is_black() { 0 } else { settings.lights.sky_samples };
    let suns = if has_suns(&scene.background) { settings.lights.area_samples } else { 0 };
    let samples = scene.lights.len() as u64 + u64::from(area + sky + suns);
    let affordable = (1_u64 << 26) / samples.max(1);
    let count = (40 * scene.triangles.len() as u64).clamp(1 << 17, 1 << 22).min(affordable.max(1 << 16)) as u32;
    let mut budget = new(count);
    while budget.count > 1 && cell_count(scene, &budget) > MOST_CELLS {
        budget.count /= 2;
    }
    budget
}

struct Facts {
    emits: bool,
    textured: bool,
    masked: bool,
    opaque: u32,
    sky: bool,
    suns: bool,
    directional: bool,
    point: bool,
    spot: bool,
}

impl Facts {
    fn of(scene: &Scene) -> Self {
        let used = || scene.parts.iter().map(|part| &scene.materials[part.material as usize]);
        let light = |is: fn(&Light) -> bool| scene.lights.iter().any(is);
        Self {
            emits: used().any(|m| m.emission != Vec3::ZERO),
            textured: used()
                .any(|m| m.base_texture.is_some() || m.normal_texture.is_some() || m.emission_texture.is_some()),
            masked: scene.parts.iter().any(|part| scene.is_masked(part)),
            opaque: scene.opaque_count(),
            sky: match &scene.background {
                Background::Black => false,
                Background::Constant(radiance) => *radiance != Vec3::ZERO,
                Background::Map(_) => !scene.background.is_black(),
            },
            suns: has_suns(&scene.background),
            directional: light(|l| matches!(l, Light::Directional { .. })),
            point: light(|l| matches!(l, Light::Point { .. })),
            spot: light(|l| matches!(l, Light::Spot { .. })),
        }
    }

    fn is_lit(&self) -> bool {
        self.emits || self.directional || self.point || self.spot || self.suns
    }

    fn light_kinds(&self) -> [(Part, bool, &'static str); 5] {
        [
            (Part::DirectionalShadows, self.directional, "no directional lights"),
            (Part::PointShadows, self.point, "no point lights"),
            (Part::SpotShadows, self.spot, "no spot lights"),
            (Part::AreaShadows, self.emits, "no emissive triangles"),
            (Part::SunShadows, self.suns, "no small bright regions of a map shine"),
        ]
    }
}

//! The plan: what a scene needs, and why the rest is left out.

use super::Settings;
use super::camera::eye;
use crate::math::density::Eye;
use crate::methods::captures::CaptureMode;
use crate::methods::casters::FEWEST_TO_SIMPLIFY;
use crate::methods::emitter_samples::MOST_FACES;
use crate::methods::has_suns;
use crate::methods::irradiance_cache::CacheSettings;
use crate::passes::capture::WHOLE_SCENE;
use crate::passes::cluster_tree::Detail;
use crate::passes::geometry::{CellBudget, cell_count};
use crate::passes::resolve::Plane;
use crate::scene::{Background, Camera, Light, Scene, SideLimit};
use crate::vk::Device;
use glam::Vec3;

/// Opaque triangles from which levels of detail are made. Fewer are drawn sooner than coarser ones made.
const FEWEST_FOR_LEVELS: u32 = 1 << 17;

const CASTERS: &str = "coarse casters";
const NO_ERROR: &str = "no error is allowed for them (--lod-error 0)";
const NO_SKY: &str = "the background is black";
const TESSELLATE: &str = "tessellate";
const CAPTURE_COMPUTE: &str = "capture_compute";
const LEVELS: &str = "levels of detail";

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
    /// Names of the passes and parts that run, in order.
    pub run: Vec<&'static str>,
    /// What is left out.
    pub left_out: Vec<LeftOut>,
    /// How triangles are to be cut first.
    pub cut: Option<SideLimit>,
    /// The G-buffer holds emission.
    pub emission: bool,
    /// Some light is sampled with shadows.
    pub lights: bool,
    /// The background shines.
    pub sky: bool,
    /// The sky's shadows on surface cells are cast by a coarser surface, if one with far fewer triangles is close enough.
    pub coarse_casters: bool,
    /// Records are captured.
    pub captures: bool,
    /// They are captured in compute.
    pub compute: bool,
    /// With levels of detail.
    pub levels: bool,
    /// Cells that the surface is cut into; one a triangle where no capture reads them.
    pub surface_cells: CellBudget,
}

impl Plan {
    /// Plans a frame of `scene`.
    ///
    /// Without a device, captures are taken to be render passes.
    pub fn of(scene: &Scene, camera: &Camera, settings: &Settings, device: Option<&Device>) -> Self {
        let facts = Facts::of(scene);
        let full = settings.full_plan;
        let mut plan = Self::default();
        let shines = facts.is_lit() || facts.sky;
        let indirect = settings.bounces > 0 && (shines || full);
        // Dark cells are no finer anywhere: nothing is cut for them.
        let eye = if shines { eye(scene, camera) } else { None };
        plan.surface_cells = if indirect { cells(scene, eye, settings) } else { CellBudget::even(1) };
        let limit = settings.side_limit(scene, plan.surface_cells.eye, device);
        plan.cut = limit.cuts(scene).then_some(limit);
        let why = "no side is longer than its distance from the eye, or than captures and settings allow";
        plan.part(TESSELLATE, plan.cut.is_some(), why);
        plan.run.push("gbuffer");
        plan.emission = plan.part("emission", facts.emits || full, "no material emits");
        plan.part("textures", facts.textured, "no material has a texture");
        plan.part("alpha mask", facts.masked, "no material has an alpha mask");
        for (part, present, why) in facts.light_kinds() {
            plan.part(part, present, why);
        }
        plan.lights = facts.is_lit() || full;
        plan.part("shadow", plan.lights, "no lights");
        plan.part("pixel_light", plan.lights, "no lights");
        plan.sky = plan.part("sky", facts.sky || full, NO_SKY);
        plan.coarse_casters = plan.coarse_casters_part(settings, &facts);
        plan.captures = indirect || plan.sky;
        let why = if settings.bounces == 0 { "no bounces are asked for" } else { "nothing shines" };
        plan.part("surface_light", indirect, why);
        let cache = &settings.cache;
        let against_compute = settings.against_compute(scene, device);
        plan.compute = plan.captures && against_compute.is_none();
        for pass in ["find_uncovered", "place_records"] {
            plan.part(pass, plan.captures, why);
        }
        if plan.captures {
            plan.capture_parts(against_compute, facts.opaque, cache);
        } else {
            plan.part("capture", false, why);
        }
        plan.part("integrate", plan.captures, why);
        let clamped = if cache.clamped { why } else { "neighbours are not asked to clamp each other" };
        plan.part("keep_records", plan.captures, why);
        plan.part("index_records", plan.captures && cache.clamped, clamped);
        plan.part("clamp_records", plan.captures, why);
        plan.part("splat", plan.captures, why);
        let disputed = if cache.contrast > 0.0 { why } else { "records may disagree by anything (--contrast 0)" };
        plan.part("contrast", plan.captures && cache.contrast > 0.0, disputed);
        let hidden =
            if cache.hidden { "the captures do not see the horizon" } else { "records may light what they do not see" };
        let hidden = if plan.captures { hidden } else { why };
        plan.part("hidden points", plan.captures && cache.rejects_hidden(), hidden);
        let triangles = scene.triangles.len();
        let drawn = plan.lights || (plan.captures && !plan.compute);
        let whole = if drawn { format!("{triangles} triangles are drawn whole") } else { "nothing to cull for".into() };
        plan.part("cull", drawn && triangles > WHOLE_SCENE as usize, whole);
        if plan.captures {
            let counted = settings.planes.contains(&Plane::Records);
            plan.part("record counts", counted, "the layer \"records\" is not asked for");
        }
        plan.run.push("resolve");
        plan
    }

    /// The plan for a scene that was cut, as one that says so.
    pub(super) fn of_cut(mut self) -> Self {
        self.left_out.retain(|left| left.pass != TESSELLATE);
        self.run.retain(|part| *part != TESSELLATE);
        self.run.insert(0, TESSELLATE);
        self
    }

    /// The plan of a frame by render passes that captures in compute were to draw, as one that says why they did not.
    pub(super) fn of_render_passes(mut self, why: &str) -> Self {
        for left in self.left_out.iter_mut().filter(|left| [CAPTURE_COMPUTE, LEVELS].contains(&left.pass)) {
            left.why = why.into();
        }
        self
    }

    /// The plan of a frame whose surface could not be simplified far, as one that says so.
    pub(super) fn of_own_casters(mut self) -> Self {
        self.run.retain(|part| *part != CASTERS);
        self.coarse_casters =
            self.part(CASTERS, false, "simplified, the surface keeps more than half of its triangles");
        self
    }

    /// The plan of a frame whose levels of detail did not fit, as one that says so.
    pub(super) fn without_levels(mut self, why: &str) -> Self {
        self.run.retain(|part| *part != LEVELS);
        self.levels = self.part(LEVELS, false, why);
        self
    }

    /// Whether the sky's shadows are cast by a coarser surface.
    fn coarse_casters_part(&mut self, settings: &Settings, facts: &Facts) -> bool {
        let runs = facts.opaque >= FEWEST_TO_SIMPLIFY && settings.cache.lod_error > 0.0;
        let why = match (facts.sky, settings.bounces) {
            (false, _) => NO_SKY.into(),
            (true, 0) => "no bounces are asked for".into(),
            _ if settings.cache.lod_error <= 0.0 => NO_ERROR.into(),
            _ => format!("{} opaque triangles are drawn as soon as simplified", facts.opaque),
        };
        self.part(CASTERS, runs && facts.sky && settings.bounces > 0, why)
    }

    /// How records look at the scene, and what that leaves out.
    fn capture_parts(&mut self, against_compute: Option<String>, opaque: u32, cache: &CacheSettings) {
        let CacheSettings { capture, lod_error, .. } = *cache;
        self.part("capture", against_compute.is_some(), "captures are rasterised in compute");
        let why = against_compute.unwrap_or_default();
        self.part(CAPTURE_COMPUTE, why.is_empty(), why.clone());
        let why = if !why.is_empty() {
            why
        } else if lod_error <= 0.0 {
            NO_ERROR.into()
        } else {
            format!("{opaque} opaque triangles are drawn as soon as chosen from")
        };
        let many = opaque >= FEWEST_FOR_LEVELS && lod_error > 0.0;
        self.levels = self.part(LEVELS, self.compute && many, why);
        let asked = matches!(capture, CaptureMode::Slices { .. });
        self.part("slices", self.compute && asked, "what is far is not asked for as slices (--capture slices)");
    }

    /// What captures in compute draw at a distance; none where captures are not in compute.
    pub fn detail(&self) -> Option<Detail> {
        self.compute.then_some(if self.levels { Detail::Levels } else { Detail::Exact })
    }

    /// Notes `part` as run or left out; returns whether it runs.
    fn part(&mut self, part: &'static str, runs: bool, why: impl Into<String>) -> bool {
        if runs {
            self.run.push(part);
        } else {
            self.left_out.push(LeftOut { pass: part, why: why.into() });
        }
        runs
    }
}

/// Radiance of so many cells fits into a buffer on every device (maxStorageBufferRange is 2²⁷ bytes).
const MOST_CELLS: u64 = (1 << 27) / 24;

/// Cells for a scene: more for more detail, fewer where there are many light samples, so that lighting them stays within
/// about 2²⁶ pairs of the two, and what holds them within 2²⁷ bytes, as long as that leaves each triangle one.
fn cells(scene: &Scene, eye: Option<Eye>, settings: &Settings) -> CellBudget {
    if let Some(count) = settings.surface_cells {
        return CellBudget { count, eye };
    }
    let faces: u32 = scene.parts.iter().filter(|part| scene.emits(part)).map(|part| part.triangle_count).sum();
    let area = if faces > 0 { settings.lights.area_samples.max(faces.min(MOST_FACES as u32)) } else { 0 };
    let sky = if scene.background.is_black() { 0 } else { settings.lights.sky_samples };
    let suns = if has_suns(&scene.background) { settings.lights.area_samples } else { 0 };
    let samples = scene.lights.len() as u64 + u64::from(area + sky + suns);
    let affordable = (1_u64 << 26) / samples.max(1);
    let count = (40 * scene.triangles.len() as u64).clamp(1 << 17, 1 << 22).min(affordable.max(1 << 16)) as u32;
    let mut budget = CellBudget { count, eye };
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

    fn light_kinds(&self) -> [(&'static str, bool, &'static str); 5] {
        [
            ("directional shadows", self.directional, "no directional lights"),
            ("point shadows", self.point, "no point lights"),
            ("spot shadows", self.spot, "no spot lights"),
            ("area shadows", self.emits, "no emissive triangles"),
            ("sun shadows", self.suns, "no small bright regions of a map shine"),
        ]
    }
}

//! The plan: what a scene needs, and why the rest is left out.

use super::Settings;
use crate::passes::capture::WHOLE_SCENE;
use crate::passes::resolve::Plane;
use crate::scene::{Background, Light, Scene};
use glam::Vec3;

/// A part that does not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Name of the pass or part.
    pub pass: &'static str,
    /// Why it is not needed.
    pub why: String,
}

/// What is built and run for a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// Names of the passes and parts that run, in order.
    pub run: Vec<&'static str>,
    /// What is left out.
    pub left_out: Vec<LeftOut>,
    /// The G-buffer holds emission.
    pub emission: bool,
    /// Some light is sampled with shadows.
    pub lights: bool,
    /// The background shines.
    pub sky: bool,
    /// Records are captured.
    pub captures: bool,
    /// Cells that the surface is cut into; one a triangle where no capture reads them.
    pub surface_cells: u32,
}

impl Plan {
    /// Plans a frame of `scene`.
    pub fn of(scene: &Scene, settings: &Settings) -> Self {
        let facts = Facts::of(scene);
        let full = settings.full_plan;
        let mut plan = Self::default();
        plan.run.push("gbuffer");
        plan.emission = plan.part("emission", facts.emits || full, "no material emits");
        plan.part("textures", facts.textured, "no material has a texture");
        plan.part("alpha mask", facts.masked, "no material has an alpha mask");
        for (part, present, why) in facts.light_kinds() {
            plan.part(part, present, why);
        }
        plan.lights = facts.is_lit() || full;
        plan.part("pixel_light", plan.lights, "no lights");
        plan.sky = plan.part("sky", facts.sky || full, "the background is black");
        let indirect = settings.bounces > 0 && (plan.lights || plan.sky);
        plan.captures = indirect || plan.sky;
        let why = if settings.bounces == 0 { "no bounces are asked for" } else { "nothing shines" };
        plan.part("surface_light", indirect, why);
        for pass in ["place_records", "capture", "integrate", "splat", "find_uncovered"] {
            plan.part(pass, plan.captures, why);
        }
        plan.surface_cells = if indirect { settings.surface_cells } else { 1 };
        if plan.captures {
            let few = format!("{} triangles are drawn whole", scene.triangles.len());
            plan.part("cull", scene.triangles.len() > WHOLE_SCENE as usize, few);
            let counted = settings.planes.contains(&Plane::Records);
            plan.part("record counts", counted, "the layer \"records\" is not asked for");
        }
        plan.run.push("resolve");
        plan
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

struct Facts {
    emits: bool,
    textured: bool,
    masked: bool,
    sky: bool,
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
            masked: used().any(|m| m.alpha_cutoff.is_some()),
            sky: match &scene.background {
                Background::Black => false,
                Background::Constant(radiance) => *radiance != Vec3::ZERO,
                Background::Map(_) => !scene.background.is_black(),
            },
            directional: light(|l| matches!(l, Light::Directional { .. })),
            point: light(|l| matches!(l, Light::Point { .. })),
            spot: light(|l| matches!(l, Light::Spot { .. })),
        }
    }

    fn is_lit(&self) -> bool {
        self.emits || self.directional || self.point || self.spot
    }

    fn light_kinds(&self) -> [(&'static str, bool, &'static str); 4] {
        [
            ("directional shadows", self.directional, "no directional lights"),
            ("point shadows", self.point, "no point lights"),
            ("spot shadows", self.spot, "no spot lights"),
            ("area shadows", self.emits, "no emissive triangles"),
        ]
    }
}

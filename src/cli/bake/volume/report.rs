//! What `hemicube bake volume` says of a run, and writes by `--stats`.

use crate::cli::say::{remark, say};
use glam::DVec3;
use hemicube::methods::volume::Places;
use hemicube::report::profile::Profile;
use hemicube::report::stats::{Memory, SceneStats, Stats};
use hemicube::report::table::Table;
use hemicube::scene::Scene;
use hemicube::vk::Device;
use hemicube::vk::pass::Recorder;
use hemicube::volume::Volume;
use hemicube::volume::export::{Grid, bevy};
use hemicube::volume::memory::{MOMENTS, plain_bytes, table};
use hemicube::volume::place::{Adaptive, Placement};
use serde_json::json;

/// A bake that has ended.
pub struct Run<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The result.
    pub volume: &'a Volume,
    /// The counts of its samples.
    pub placement: &'a Placement,
    /// Where samples were asked for.
    pub places: &'a Places,
    /// Duration of the whole run.
    pub seconds: f64,
}

/// How a Bevy app places the texture. Bevy applies the view's exposure to lamps and to volumes, but not to emissive surfaces.
pub fn bevy_note(grid: &Grid, has_lamps: bool) -> String {
    let [translation, scale] = bevy::transform(grid).map(|v| {
        let DVec3 { x, y, z } = v;
        format!("Vec3::new({x:.6}, {y:.6}, {z:.6})")
    });
    let intensity = if has_lamps {
        "intensity: 1.0 (the scene has lamps; Bevy's default is 0)"
    } else {
        "intensity: 1.0 / exposure (no lamps: light of emissive surfaces, which Bevy does not expose; its default is 0)"
    };
    format!(
        "in Bevy: LightProbe, Transform {{ translation: {translation}, scale: {scale}, ..default() }}, and\n         \
         IrradianceVolume {{ voxels, {intensity}"
    ) + " }"
}

/// Samples of a uniform grid with the octree's finest cells.
fn as_uniform(octree: &Adaptive) -> usize {
    ((1_usize << octree.max_level) + 1).pow(3)
}

impl Run<'_> {
    /// Statistics of the run.
    pub fn stats(&self, device: &Device, recorder: &Recorder) -> Stats {
        let mut stats = Stats::new();
        stats.device = device.physical.name.clone();
        stats.driver = device.physical.driver.trim().to_owned();
        stats.scene = SceneStats {
            triangles: self.scene.triangles.len() as u64,
            vertices: self.scene.positions.len() as u64,
            lights: self.scene.lights.len() as u64,
            materials: self.scene.parts.len() as u64,
        };
        let profile = self.profile(recorder);
        stats.set_times(&profile);
        stats.plan.run = profile.passes.iter().map(|pass| pass.name.clone()).collect();
        let memory = device.memory();
        stats.memory = Memory {
            gpu_bytes: memory.peak,
            by_use: memory.by_use.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect(),
        };
        stats.validation_messages = u64::from(device.instance.validation_messages());
        self.add_extras(&mut stats);
        stats
    }

    fn profile(&self, recorder: &Recorder) -> Profile {
        let mut profile = Profile { wall_ms: self.seconds * 1e3, ..Profile::default() };
        profile.gpu_ms = recorder.submissions.iter().map(|span| span.end_ms - span.begin_ms).sum();
        for run in &recorder.passes {
            let pass = profile.pass(run.name);
            pass.gpu_ms.extend(run.gpu.as_ref().map(|span| span.end_ms - span.begin_ms));
            pass.cpu_ms += run.cpu.end_ms - run.cpu.begin_ms;
        }
        profile
    }

    fn add_extras(&self, stats: &mut Stats) {
        let samples = self.volume.samples.len();
        stats.extra.insert("order".into(), json!(self.volume.order));
        stats.extra.insert("placement".into(), json!(self.placement));
        let sample_memory = json!({"samples": samples, "by_order": table(samples),
            "floats_of_moments_per_sample": if self.volume.has_moments() { MOMENTS } else { 0 }});
        stats.extra.insert("sample_memory".into(), sample_memory);
        if let Places::Adaptive(octree) = self.places {
            let uniform = as_uniform(octree);
            let beside = json!({"settings": octree, "samples_of_a_uniform_grid": uniform,
                "memory_of_a_uniform_grid": table(uniform)});
            stats.extra.insert("adaptive".into(), beside);
        }
    }

    /// Prints the counts, and the memory by order.
    pub fn tell(&self) {
        let Placement { samples, cells, moved, inside, measured, .. } = self.placement;
        let (name, order, seconds) = (&self.scene.name, self.volume.order, self.seconds);
        say!(
            "{name}: {samples} samples of order {order} in {cells} cells ({moved} moved out of geometry, {inside} inside), {measured} \
             captures in {seconds:.1} s"
        );
        if 2 * inside > *samples {
            remark!(
                "warning: most samples are inside of geometry: if its triangles do not face outwards, use --inside 1"
            );
        }
        if let Places::Adaptive(octree) = self.places {
            self.tell_levels(octree);
        }
        let heads = ["order", "floats a sample", "with gradients", "all samples", "with gradients"];
        let mut memory = Table::new(&heads);
        for row in table(self.volume.samples.len()) {
            let floats = [row.floats_per_sample, row.floats_per_sample_with_gradients].map(|floats| floats.to_string());
            let bytes = [row.bytes, row.bytes_with_gradients].map(plain_bytes);
            memory.row(std::iter::once(row.order.to_string()).chain(floats).chain(bytes));
        }
        say!("\n{}", memory.to_string().trim_end());
        if self.volume.has_moments() {
            say!("moments of the distances: {MOMENTS} floats a sample more");
        }
    }

    fn tell_levels(&self, octree: &Adaptive) {
        let heads = ["level", "cells", "by gradient", "by geometry", "by harmonic mean", "measured", "cut"];
        let mut levels = Table::new(&heads);
        for level in &self.placement.levels {
            let counts =
                [level.cells, level.by_gradient, level.by_geometry, level.by_harmonic_mean, level.measured, level.cut];
            levels.row(std::iter::once(level.level.to_string()).chain(counts.map(|count| count.to_string())));
        }
        say!("\n{}", levels.to_string().trim_end());
        say!("merged again: {} cells, {} samples", self.placement.culled_cells, self.placement.culled_samples);
        let uniform = as_uniform(octree);
        let share = 100.0 * self.placement.samples as f64 / uniform as f64;
        say!("{share:.0} % of the {uniform} samples of a uniform grid of level {}", octree.max_level);
    }
}

//! Lights the surface cells by a batch of shadow-mapped light samples.

use super::geometry::Geometry;
use super::groups;
use super::material::{Textures, Variant};
use super::shadow::{Lift, Shadow};
use crate::scene::Scene;
use crate::vk::{Binding, Commands, ComputePipeline, DescriptorSet, Device, PipelineLayout, Result, SetLayout, spirv};
use bytemuck::{Pod, Zeroable};
use std::collections::HashMap;
use std::sync::Arc;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    material: u32,
    first: u32,
    count: u32,
    first_light: u32,
    light_count: u32,
    points: u32,
    lift: f32,
    stride: u32,
    ball: [f32; 4],
}

/// The pass for one kind of light.
pub struct SurfaceLight {
    pipelines: HashMap<Variant, ComputePipeline>,
    set: DescriptorSet,
    _layout: SetLayout,
}

/// One batch of light samples.
#[derive(Clone, Copy)]
pub struct Batch {
    /// Index of its first sample among its kind.
    pub first: u32,
    /// Number of samples, each with its tile of the shadow capture.
    pub count: u32,
    /// Points in a cell for each sample.
    pub points: u32,
    /// How far a point stands off its surface when looked up.
    pub lift: Lift,
    /// Of pairs of a sample and a point a cell takes one in so many, others than its neighbours do.
    pub stride: u32,
}

impl SurfaceLight {
    /// Builds a pipeline for each variant of material in use.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        geometry: &Geometry,
        textures: Option<&Textures>,
        shadow: &Shadow<'_>,
    ) -> Result<Self> {
        let own = [
            Binding::Storage(&geometry.first_cell),
            Binding::Storage(&geometry.cell_triangle),
            Binding::Storage(&geometry.cell_radiance),
        ];
        let bindings: Vec<_> = shadow.bindings().into_iter().chain(own).collect();
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let push = size_of::<Push>() as u32;
        let mut pipelines = HashMap::new();
        for part in &geometry.parts {
            let variant = Variant::of(&scene.materials[part.material as usize]);
            if pipelines.contains_key(&variant) {
                continue;
            }
            let (sets, code) = match textures.filter(|_| variant.is_textured()) {
                Some(t) => (vec![&geometry.set_layout, &t.layout, &layout], spirv!("surface_light", "textured.comp")),
                None => (vec![&geometry.set_layout, &layout], spirv!("surface_light", "plain.comp")),
            };
            let pipeline_layout = PipelineLayout::new(device, &sets, push)?;
            let shadows: Vec<u32> = shadow.constants().into_iter().chain([u32::from(shadow.own)]).collect();
            let constants = variant.constants(geometry.streams, &shadows);
            pipelines.insert(variant, ComputePipeline::new("surface_light", &pipeline_layout, code, &constants)?);
        }
        Ok(Self { pipelines, set, _layout: layout })
    }

    /// Adds the batch's light to every cell, a dispatch a material.
    pub fn record(
        &self,
        commands: &Commands,
        scene: &Scene,
        geometry: &Geometry,
        textures: Option<&Textures>,
        batch: Batch,
    ) {
        for (part, cells) in geometry.parts.iter().zip(geometry.part_cells.windows(2)) {
            let variant = Variant::of(&scene.materials[part.material as usize]);
            let pipeline = &self.pipelines[&variant];
            match textures.filter(|_| variant.is_textured()) {
                Some(textures) => pipeline.bind(commands, &[&geometry.set, textures.set(part.material), &self.set]),
                None => pipeline.bind(commands, &[&geometry.set, &self.set]),
            }
            let count = cells[1] - cells[0];
            let push = Push {
                material: part.material,
                first: cells[0],
                count,
                first_light: batch.first,
                light_count: batch.count,
                points: batch.points,
                lift: batch.lift.share,
                stride: batch.stride,
                ball: batch.lift.ball,
            };
            pipeline.layout.push(commands, &push);
            pipeline.dispatch(commands, groups(count, 64));
        }
    }
}

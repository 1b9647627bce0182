//! The image: sums divided by weights, times albedo/π, plus direct light and emission, in the layers that are asked for.

use super::gbuffer::Targets;
use super::groups;
use super::splat::Sums;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, spirv,
};
use bytemuck::{Pod, Zeroable};
use glam::Mat4;
use std::sync::Arc;

/// A layer of the result and where its planes lie in the output buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// direct + indirect + emission.
    Final,
    /// Radiance leaving by direct light.
    Direct,
    /// Radiance leaving by indirect light.
    Indirect,
    /// Indirect irradiance.
    Irradiance,
    /// Direct irradiance.
    DirectIrradiance,
    /// Albedo.
    Albedo,
    /// Emitted radiance.
    Emission,
    /// Shading normal on the viewer's side.
    Normal,
    /// Position relative to the scene's origin.
    Position,
    /// Distance along the view axis.
    Depth,
    /// Number of records.
    Records,
    /// 1 where a surface reflects.
    Mask,
}

impl Plane {
    /// All planes in the order of the shader's constants.
    pub const ALL: [Self; 12] = [
        Self::Final,
        Self::Direct,
        Self::Indirect,
        Self::Irradiance,
        Self::DirectIrradiance,
        Self::Albedo,
        Self::Emission,
        Self::Normal,
        Self::Position,
        Self::Depth,
        Self::Records,
        Self::Mask,
    ];

    /// Number of values a pixel.
    pub fn channels(self) -> u32 {
        if matches!(self, Self::Depth | Self::Records | Self::Mask) { 1 } else { 3 }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    clip_to_world_direction: [f32; 16],
    forward: [f32; 4],
    size: [u32; 2],
    planes: [i32; 6],
}

/// What the image is made of; what is `None` is black and built no pass.
pub struct Inputs<'a> {
    /// G-buffer.
    pub gbuffer: &'a Targets,
    /// Splats.
    pub sums: Option<&'a Sums>,
    /// Direct irradiance, four floats a pixel.
    pub direct: Option<&'a Buffer>,
    /// Sky: size, then texels.
    pub sky: Option<&'a Buffer>,
}

/// The pass.
pub struct Resolve {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    size: [u32; 2],
    planes: Vec<Plane>,
    output: Buffer,
    readback: Buffer,
    _layout: SetLayout,
}

impl Resolve {
    /// Writes `planes`.
    pub fn new(device: &Arc<Device>, inputs: &Inputs<'_>, planes: &[Plane]) -> Result<Self> {
        let size = inputs.gbuffer.position.desc.size;
        let values: u32 = planes.iter().map(|p| p.channels()).sum();
        let bytes = u64::from(values) * u64::from(size[0]) * u64::from(size[1]) * 4;
        let output = Buffer::new(device, "result", bytes, Memory::Device)?;
        let position = &inputs.gbuffer.position;
        let sums = inputs.sums;
        // What is left out is bound to something of the right kind and never read.
        let bindings = [
            Binding::Texels(position),
            Binding::Texels(&inputs.gbuffer.normals),
            Binding::Texels(&inputs.gbuffer.albedo),
            Binding::Texels(inputs.gbuffer.emission.as_ref().unwrap_or(position)),
            Binding::Texels(sums.map_or(position, |s| &s.indirect)),
            Binding::Texels(sums.and_then(|s| s.sky.as_ref()).unwrap_or(position)),
            Binding::Texels(sums.and_then(|s| s.tally.as_ref()).unwrap_or(position)),
            Binding::Storage(inputs.direct.unwrap_or(&output)),
            Binding::Storage(inputs.sky.unwrap_or(&output)),
            Binding::Storage(&output),
        ];
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let features = [
            sums.is_some(),
            inputs.sky.is_some(),
            inputs.direct.is_some(),
            inputs.gbuffer.emission.is_some(),
            sums.is_some_and(|s| s.tally.is_some()),
        ];
        let constants =
            features.iter().map(|f| u32::from(*f)).chain(Plane::ALL[6..].iter().map(|p| first(planes, *p) as u32));
        let constants = Specialisation(constants.collect());
        let pipeline =
            ComputePipeline::new("resolve", &pipeline_layout, spirv!("resolve", "resolve.comp"), &constants)?;
        Ok(Self {
            pipeline,
            set,
            size,
            planes: planes.to_vec(),
            output,
            readback: Buffer::new(device, "read-back", bytes, Memory::Readback)?,
            _layout: layout,
        })
    }

    /// Writes the planes. `axis`: camera axis and −(axis · eye).
    pub fn record(&self, commands: &Commands, clip_to_world_direction: Mat4, axis: [f32; 4]) {
        let push = Push {
            clip_to_world_direction: clip_to_world_direction.to_cols_array(),
            forward: axis,
            size: self.size,
            planes: std::array::from_fn(|i| first(&self.planes, Plane::ALL[i])),
        };
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &push);
        self.pipeline.dispatch(commands, groups(self.size[0] * self.size[1], 64));
    }

    /// Copies the planes to the CPU.
    pub fn record_readback(&self, commands: &Commands) {
        commands.copy_buffer(&self.output, &self.readback, self.output.size);
    }

    /// The planes of `plane`, once the read-back has been waited for.
    pub fn read(&self, plane: Plane) -> Vec<Vec<f32>> {
        let pixels = (self.size[0] * self.size[1]) as usize;
        let begin = first(&self.planes, plane);
        debug_assert!(begin >= 0, "only planes that were asked for are read");
        (begin as usize..begin as usize + plane.channels() as usize)
            .map(|index| self.readback.read_from(index * pixels, pixels))
            .collect()
    }
}

/// First value of `plane` in a pixel's list, −1 if it is not among `planes`.
fn first(planes: &[Plane], plane: Plane) -> i32 {
    let Some(at) = planes.iter().position(|p| *p == plane) else { return -1 };
    planes[..at].iter().map(|p| p.channels() as i32).sum()
}

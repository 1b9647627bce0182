//! The image: sums divided by weights, times albedo/π, plus direct light and emission, in the layers that are asked for.

use super::gbuffer::Targets;
use super::groups;
use super::splat::Sums;
use crate::vk::pass::Recorder;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Image, Memory, PipelineLayout, Result,
    SetLayout, barrier, variants,
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
    band: [u32; 2],
    planes: [i32; 6],
}

/// What the image is made of; what is `None` is black and built no pass.
pub struct Inputs<'a> {
    /// G-buffer.
    pub gbuffer: &'a Targets,
    /// Splats.
    pub sums: Option<&'a Sums>,
    /// Direct irradiance.
    pub direct: Option<&'a Image>,
    /// Sky: size, then texels.
    pub sky: Option<&'a Buffer>,
}

/// Most bytes of a band: what the CPU keeps of it twice for a moment.
pub const BAND: u64 = 256 << 20;

/// The pass, and the read-back of what it writes. Both go band by band, so that no limit of buffers holds for the image.
pub struct Resolve {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    size: [u32; 2],
    planes: Vec<Plane>,
    /// Most pixels of a band.
    band: u32,
    output: Buffer,
    readback: Buffer,
    _layout: SetLayout,
}

impl Resolve {
    /// Writes `planes`.
    pub fn new(device: &Arc<Device>, inputs: &Inputs<'_>, planes: &[Plane]) -> Result<Self> {
        let size = inputs.gbuffer.position.desc.size;
        let pixel_bytes = u64::from(channels(planes).max(1)) * 4;
        let most = BAND.min(u64::from(device.capabilities.limits.max_storage_buffer_range)) / pixel_bytes;
        let band = most.clamp(1, u64::from(size[0]) * u64::from(size[1])) as u32;
        let bytes = u64::from(band) * pixel_bytes;
        let output = Buffer::new(device, "result", bytes, Memory::Device)?;
        let Targets { position, normals, albedo, emission, .. } = inputs.gbuffer;
        let sums = inputs.sums;
        let tally = sums.and_then(|sums| sums.tally.as_ref());
        let shader = variants!("resolve", "resolve.comp").choose(&[
            ("INDIRECT", sums.is_some()),
            ("SKY", inputs.sky.is_some()),
            ("LIGHTS", inputs.direct.is_some()),
            ("EMISSION", emission.is_some()),
            ("RECORDS", tally.is_some()),
        ]);
        let optional = [
            ("gbuffer_emission", emission.as_ref().map(Binding::Texels)),
            ("indirect_sum", sums.map(|sums| Binding::Texels(&sums.indirect))),
            ("sky_sum", sums.and_then(|sums| sums.sky.as_ref()).map(Binding::Texels)),
            ("record_count", tally.map(Binding::Texels)),
            ("direct", inputs.direct.map(Binding::Stored)),
            ("Sky", inputs.sky.map(Binding::Storage)),
        ];
        let always = [
            ("gbuffer_position", Binding::Texels(position)),
            ("gbuffer_normals", Binding::Texels(normals)),
            ("gbuffer_albedo", Binding::Texels(albedo)),
            ("Planes", Binding::Storage(&output)),
        ];
        let resources: Vec<_> = always
            .into_iter()
            .chain(optional.into_iter().filter_map(|(name, resource)| Some((name, resource?))))
            .collect();
        let (layout, set) = DescriptorSet::named(device, &[shader], 0, &resources)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let constants = [
            ("EMISSION_PLANE", Plane::Emission),
            ("NORMAL_PLANE", Plane::Normal),
            ("POSITION_PLANE", Plane::Position),
            ("DEPTH_PLANE", Plane::Depth),
            ("RECORDS_PLANE", Plane::Records),
            ("MASK_PLANE", Plane::Mask),
        ];
        let constants = constants.map(|(name, plane)| (name, first(planes, plane) as u32));
        let pipeline = ComputePipeline::new("resolve", &pipeline_layout, shader, constants)?;
        Ok(Self {
            pipeline,
            set,
            size,
            planes: planes.to_vec(),
            band,
            output,
            readback: Buffer::new(device, "read-back", bytes, Memory::Readback)?,
            _layout: layout,
        })
    }

    /// Computes the image and reads it: a list of values for each channel of the planes in order, row by row. `axis`: camera
    /// axis and −(axis · eye).
    ///
    /// # Errors
    /// Those of the device ([`Recorder::submit`]).
    pub fn run(&self, recorder: &mut Recorder, clip_to_world_direction: Mat4, axis: [f32; 4]) -> Result<Vec<Vec<f32>>> {
        let pixels = self.size[0] * self.size[1];
        let mut values = vec![Vec::with_capacity(pixels as usize); channels(&self.planes) as usize];
        for first in (0..pixels).step_by(self.band as usize) {
            let count = self.band.min(pixels - first);
            recorder.submit(|recording| {
                recording.pass("resolve", |c| {
                    self.record(c, clip_to_world_direction, axis, [first, count]);
                    Ok(())
                })?;
                recording.pass("readback", |c| {
                    barrier::full(c);
                    c.copy_buffer(&self.output, &self.readback, values.len() as u64 * u64::from(count) * 4);
                    Ok(())
                })
            })?;
            for (index, values) in values.iter_mut().enumerate() {
                values.extend(self.readback.read_from::<f32>(index * count as usize, count as usize));
            }
        }
        Ok(values)
    }

    fn record(&self, commands: &Commands, clip_to_world_direction: Mat4, axis: [f32; 4], band: [u32; 2]) {
        let push = Push {
            clip_to_world_direction: clip_to_world_direction.to_cols_array(),
            forward: axis,
            size: self.size,
            band,
            planes: std::array::from_fn(|i| first(&self.planes, Plane::ALL[i])),
        };
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &push);
        self.pipeline.dispatch(commands, groups(band[1], 64));
    }
}

/// Values of a pixel in all `planes`.
fn channels(planes: &[Plane]) -> u32 {
    planes.iter().map(|p| p.channels()).sum()
}

/// First value of `plane` in a pixel's list, −1 if it is not among `planes`.
fn first(planes: &[Plane], plane: Plane) -> i32 {
    let Some(at) = planes.iter().position(|p| *p == plane) else { return -1 };
    planes[..at].iter().map(|p| p.channels() as i32).sum()
}

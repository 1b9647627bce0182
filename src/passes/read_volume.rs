//! Reads an irradiance volume on the device: `glsl/inc/volume.glsl`, whose twin is [`Reader`].

use super::groups;
use crate::math::sh;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout, spirv,
};
use crate::volume::reader::ReadSettings;
use crate::volume::{Interpolation, Reader, Sample, State, Volume};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, Vec4};
use std::sync::Arc;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    low: [f32; 3],
    high: [f32; 3],
    divisions: [u32; 3],
    count: u32,
}

/// The pass.
pub struct ReadVolume {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    coefficients: usize,
    /// Where the volume's own zero is on the device: its box's middle, so that single precision is enough.
    origin: DVec3,
    places: Buffer,
    results: Buffer,
    readback: Buffer,
    _volume: [Buffer; 4],
    _layout: SetLayout,
}

impl ReadVolume {
    /// Puts a volume on the device, to be read at up to `capacity` places. [`Interpolation::Hermite`] is read as
    /// [`Interpolation::Gradients`]: shaders have no cubic.
    pub fn new(device: &Arc<Device>, volume: &Volume, settings: ReadSettings, capacity: u32) -> Result<Self> {
        let lattice = &volume.lattice;
        let origin = (lattice.low + lattice.high) / 2.0;
        let on_device = upload(device, volume, origin)?;
        let coefficients = sh::count(volume.order);
        let bytes = u64::from(capacity) * (coefficients * 12) as u64;
        let places = Buffer::new(device, "places", u64::from(capacity) * 16, Memory::Device)?;
        let [results, readback] =
            [Memory::Device, Memory::Readback].map(|memory| Buffer::new(device, "light", bytes, memory));
        let (results, readback) = (results?, readback?);
        let bindings: Vec<_> = on_device.iter().chain([&places, &results]).map(Binding::Storage).collect();
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let way = match settings.interpolation {
            Interpolation::Trilinear => 0,
            Interpolation::InverseDistance => 1,
            Interpolation::Gradients | Interpolation::Hermite => 2,
        };
        let constants = [
            ("ORDER", volume.order),
            ("HAS_GRADIENTS", u32::from(volume.has_gradients())),
            ("HAS_MOMENTS", u32::from(volume.has_moments())),
            ("WAY", way),
            ("GUARDED", u32::from(settings.guard)),
        ];
        let code = spirv!("read_volume", "read_volume.comp");
        let pipeline = ComputePipeline::new("read_volume", &pipeline_layout, code, constants)?;
        let corner = |corner: DVec3| (corner - origin).as_vec3().to_array();
        let (low, high) = (corner(lattice.low), corner(lattice.high));
        let push = Push { low, high, divisions: lattice.divisions.to_array(), count: 0 };
        let rest = Self {
            pipeline,
            set,
            push,
            coefficients,
            origin,
            places,
            results,
            readback,
            _volume: on_device,
            _layout: layout,
        };
        Ok(rest)
    }

    /// Says where to read, in the scene's coordinates.
    pub fn set_places(&mut self, places: &[DVec3]) -> Result<()> {
        let relative: Vec<Vec4> = places.iter().map(|place| (*place - self.origin).as_vec3().extend(0.0)).collect();
        self.push.count = places.len() as u32;
        self.places.upload(&relative)
    }

    /// Reads.
    pub fn record(&self, commands: &Commands) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, groups(self.push.count, 64));
    }

    /// Copies the results to where [`Self::read`] finds them.
    pub fn record_readback(&self, commands: &Commands) {
        commands.copy_buffer(&self.results, &self.readback, self.results.size);
    }

    /// The coefficients at each place.
    pub fn read(&self) -> Vec<Vec<Vec3>> {
        let all: Vec<[f32; 3]> = self.readback.read(self.push.count as usize * self.coefficients);
        all.chunks(self.coefficients).map(|light| light.iter().map(|rgb| Vec3::from(*rgb)).collect()).collect()
    }
}

/// Cells, points, shares and samples, as the shader reads them.
fn upload(device: &Arc<Device>, volume: &Volume, origin: DVec3) -> Result<[Buffer; 4]> {
    let tree = &Reader::new(volume).tree;
    let node = |node: &crate::volume::tree::Node| std::iter::once(node.first_child).chain(node.corners);
    let nodes: Vec<u32> = tree.nodes.iter().flat_map(node).collect();
    let mut shares: Vec<[u32; 2]> = Vec::new();
    let mut points: Vec<[u32; 2]> = Vec::new();
    for point in &tree.points {
        points.push([shares.len() as u32, point.mix.len() as u32]);
        shares.extend(point.mix.iter().map(|(sample, weight)| [*sample, (*weight as f32).to_bits()]));
    }
    let samples: Vec<f32> = volume.samples.iter().flat_map(|sample| floats(sample, origin)).collect();
    let name = "volume";
    Ok([
        Buffer::with_data(device, name, &nodes)?,
        Buffer::with_data(device, name, &points)?,
        Buffer::with_data(device, name, &shares)?,
        Buffer::with_data(device, name, &samples)?,
    ])
}

fn floats(sample: &Sample, origin: DVec3) -> Vec<f32> {
    let position = (sample.position - origin).as_vec3().to_array();
    let inside = f32::from(u8::from(sample.state == State::Inside));
    let slopes = sample.gradients.iter().flatten().flat_map(Vec3::to_array);
    position
        .into_iter()
        .chain([inside])
        .chain(sample.moments.iter().flatten().copied())
        .chain(sample.coefficients.iter().flat_map(Vec3::to_array))
        .chain(slopes)
        .collect()
}

//! Pipelines: a layout of one or two descriptor sets and push constants, and what is fixed when drawing.

use super::buffer::Buffer;
use super::commands::Commands;
use super::descriptors::{DescriptorSet, SetLayout};
use super::device::Device;
use super::error::{Context, Error, Result};
use super::render_pass::RenderPass;
use super::shader::{Entries, Shader, ShaderModule, Values};
use ash::vk;
use bytemuck::Pod;
use std::sync::Arc;

const ALL_STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw()
        | vk::ShaderStageFlags::FRAGMENT.as_raw()
        | vk::ShaderStageFlags::COMPUTE.as_raw(),
);

/// Sets and push constants of a pipeline.
pub struct PipelineLayout {
    raw: vk::PipelineLayout,
    /// Binding and kind of each resource, by set.
    sets: Vec<Vec<(u32, vk::DescriptorType)>>,
    push_bytes: u32,
    device: Arc<Device>,
}

impl PipelineLayout {
    /// A layout with these sets in order and `push_bytes` of push constants (at most 128).
    pub fn new(device: &Arc<Device>, sets: &[&SetLayout], push_bytes: u32) -> Result<Arc<Self>> {
        check_storage_buffers(device, sets)?;
        let slots = sets.iter().map(|set| set.slots.clone()).collect();
        let sets: Vec<_> = sets.iter().map(|set| set.raw).collect();
        let ranges = [vk::PushConstantRange { stage_flags: ALL_STAGES, offset: 0, size: push_bytes }];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(if push_bytes > 0 {
            &ranges
        } else {
            &[]
        });
        // SAFETY: the set layouts are alive.
        let raw = unsafe { device.raw.create_pipeline_layout(&info, None) }.during("creating a pipeline layout")?;
        Ok(Arc::new(Self { raw, sets: slots, push_bytes, device: device.clone() }))
    }

    /// Sets the push constants.
    pub fn push<T: Pod>(&self, commands: &Commands, constants: &T) {
        let bytes = bytemuck::bytes_of(constants);
        // SAFETY: the layout declares the range for these stages.
        unsafe { self.device.raw.cmd_push_constants(commands.raw, self.raw, ALL_STAGES, 0, bytes) };
    }

    /// Panics where `shaders` declare other resources or push constants than the layout has: a fault of the program.
    fn check(&self, shaders: &[&Shader]) {
        for shader in shaders {
            for slot in shader.bindings {
                let has = self.sets.get(slot.set as usize).is_some_and(|set| set.contains(&(slot.binding, slot.kind)));
                assert!(has, "{}: {} is not in the layout as {:?}", shader.name, slot.name, slot);
            }
        }
        let declared = shaders.iter().map(|shader| shader.push_bytes).max().unwrap_or(0);
        assert!(
            declared <= self.push_bytes && self.push_bytes < declared + 16,
            "{}: push constants of {declared} bytes, given {}",
            shaders[0].name,
            self.push_bytes
        );
    }

    fn bind_sets(&self, commands: &Commands, point: vk::PipelineBindPoint, sets: &[&DescriptorSet]) {
        let sets: Vec<_> = sets.iter().map(|set| set.raw).collect();
        // SAFETY: the sets fit the layout and outlive the submission.
        unsafe { self.device.raw.cmd_bind_descriptor_sets(commands.raw, point, self.raw, 0, &sets, &[]) };
    }
}

/// All sets together are visible to every stage, so that their storage buffers count for each.
fn check_storage_buffers(device: &Device, sets: &[&SetLayout]) -> Result<()> {
    let count = sets.iter().map(|set| set.storage_buffers()).sum::<u32>();
    let most = device.capabilities.limits.max_per_stage_descriptor_storage_buffers;
    if count > most {
        return Err(Error::Limit {
            object: "a shader".into(),
            needed: format!("{count} storage buffers"),
            limit: format!("{most} (maxPerStageDescriptorStorageBuffers)"),
        });
    }
    Ok(())
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        // SAFETY: every submission that used the layout has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_pipeline_layout(self.raw, None) });
    }
}

/// A compute pipeline.
pub struct ComputePipeline {
    raw: vk::Pipeline,
    /// Its layout.
    pub layout: Arc<PipelineLayout>,
    device: Arc<Device>,
}

impl ComputePipeline {
    /// Makes a pipeline of one shader.
    pub fn new(
        name: &str,
        layout: &Arc<PipelineLayout>,
        shader: &Shader,
        constants: impl Into<Values>,
    ) -> Result<Self> {
        let device = &layout.device;
        layout.check(&[shader]);
        let module = ShaderModule::new(device, shader)?;
        let entries = Entries::new(&constants.into().of(shader, &[shader]));
        let specialisation = entries.info();
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(c"main")
            .specialization_info(&specialisation);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw)];
        // SAFETY: module, layout and constants live through the call.
        let made = unsafe { device.raw.create_compute_pipelines(device.pipeline_cache.raw, &info, None) };
        let raw = made.map_err(|(_, result)| result).during("creating a compute pipeline")?[0];
        device.name(raw, name);
        Ok(Self { raw, layout: layout.clone(), device: device.clone() })
    }

    /// Binds the pipeline and its sets.
    pub fn bind(&self, commands: &Commands, sets: &[&DescriptorSet]) {
        // SAFETY: the pipeline outlives the submission.
        unsafe { self.device.raw.cmd_bind_pipeline(commands.raw, vk::PipelineBindPoint::COMPUTE, self.raw) };
        self.layout.bind_sets(commands, vk::PipelineBindPoint::COMPUTE, sets);
    }

    /// Runs `groups` workgroups.
    pub fn dispatch(&self, commands: &Commands, groups: [u32; 3]) {
        // SAFETY: bound before, with all its sets.
        unsafe { self.device.raw.cmd_dispatch(commands.raw, groups[0], groups[1], groups[2]) };
    }
}

impl Drop for ComputePipeline {
    fn drop(&mut self) {
        // SAFETY: every submission that used the pipeline has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_pipeline(self.raw, None) });
    }
}

/// What the vertex stage reads from vertex buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexInput {
    /// Nothing: vertices come from storage buffers or from their index.
    None,
    /// Location 0: three floats.
    Positions,
}

/// What is fixed when drawing with a pipeline. No face culling: surfaces are two-sided.
pub struct GraphicsDesc<'a> {
    /// Debug name.
    pub name: &'a str,
    /// Vertex shader.
    pub vertex: &'a Shader,
    /// Fragment shader; `None` writes depth alone.
    pub fragment: Option<&'a Shader>,
    /// Values for both shaders.
    pub constants: Values,
    /// Vertex buffers.
    pub input: VertexInput,
    /// Triangle list or strip.
    pub topology: vk::PrimitiveTopology,
    /// Sums colours instead of replacing them.
    pub additive: bool,
}

/// A graphics pipeline. Depth, where the render pass has it, is reversed: greater is nearer.
pub struct GraphicsPipeline {
    raw: vk::Pipeline,
    /// Its layout.
    pub layout: Arc<PipelineLayout>,
    device: Arc<Device>,
}

impl GraphicsPipeline {
    /// Makes a pipeline for one subpass of `pass`.
    pub fn new(layout: &Arc<PipelineLayout>, pass: &RenderPass, subpass: u32, desc: &GraphicsDesc<'_>) -> Result<Self> {
        let device = &layout.device;
        let vertex = ShaderModule::new(device, desc.vertex)?;
        let fragment = desc.fragment.map(|shader| ShaderModule::new(device, shader)).transpose()?;
        let shaders: Vec<_> = std::iter::once(desc.vertex).chain(desc.fragment).collect();
        layout.check(&shaders);
        let entries: Vec<_> = shaders.iter().map(|shader| Entries::new(&desc.constants.of(shader, &shaders))).collect();
        let specialisations: Vec<_> = entries.iter().map(Entries::info).collect();
        let stage = |flag, module: &ShaderModule, specialisation| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(flag)
                .module(module.raw)
                .name(c"main")
                .specialization_info(specialisation)
        };
        let stages: Vec<_> = std::iter::once(stage(vk::ShaderStageFlags::VERTEX, &vertex, &specialisations[0]))
            .chain(fragment.iter().map(|module| stage(vk::ShaderStageFlags::FRAGMENT, module, &specialisations[1])))
            .collect();
        let stride =
            [vk::VertexInputBindingDescription { binding: 0, stride: 12, input_rate: vk::VertexInputRate::VERTEX }];
        let position = [vk::VertexInputAttributeDescription {
            location: 0,
            binding: 0,
            format: vk::Format::R32G32B32_SFLOAT,
            offset: 0,
        }];
        let input = match desc.input {
            VertexInput::None => vk::PipelineVertexInputStateCreateInfo::default(),
            VertexInput::Positions => vk::PipelineVertexInputStateCreateInfo::default()
                .vertex_binding_descriptions(&stride)
                .vertex_attribute_descriptions(&position),
        };
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(desc.topology);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(pass.has_depth)
            .depth_write_enable(pass.has_depth)
            .depth_compare_op(vk::CompareOp::GREATER);
        let attachments = vec![blend(desc.additive); pass.color_count as usize];
        let blending = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blending)
            .dynamic_state(&dynamic)
            .layout(layout.raw)
            .render_pass(pass.raw)
            .subpass(subpass)];
        // SAFETY: all that `info` points to lives through the call.
        let made = unsafe { device.raw.create_graphics_pipelines(device.pipeline_cache.raw, &info, None) };
        let raw = made.map_err(|(_, result)| result).during("creating a graphics pipeline")?[0];
        device.name(raw, desc.name);
        Ok(Self { raw, layout: layout.clone(), device: device.clone() })
    }

    /// Binds the pipeline and its sets.
    pub fn bind(&self, commands: &Commands, sets: &[&DescriptorSet]) {
        // SAFETY: the pipeline outlives the submission.
        unsafe { self.device.raw.cmd_bind_pipeline(commands.raw, vk::PipelineBindPoint::GRAPHICS, self.raw) };
        self.layout.bind_sets(commands, vk::PipelineBindPoint::GRAPHICS, sets);
    }

    /// Binds the vertex positions and the 32-bit indices of triangles.
    pub fn bind_mesh(&self, commands: &Commands, positions: &Buffer, indices: &Buffer) {
        // SAFETY: both buffers outlive the submission.
        unsafe {
            self.device.raw.cmd_bind_vertex_buffers(commands.raw, 0, &[positions.raw], &[0]);
            self.device.raw.cmd_bind_index_buffer(commands.raw, indices.raw, 0, vk::IndexType::UINT32);
        }
    }

    /// Draws triangles of the bound indices once for each of `instances`, whose numbers become `gl_InstanceIndex`.
    pub fn draw_triangles(&self, commands: &Commands, first: u32, count: u32, instances: std::ops::Range<u32>) {
        let (of, number) = (instances.start, instances.len() as u32);
        // SAFETY: the index range lies in the bound index buffer.
        unsafe { self.device.raw.cmd_draw_indexed(commands.raw, count * 3, number, first * 3, 0, of) };
    }

    /// Draws `vertices` vertices once per instance, the first instance having the index `first_instance`.
    pub fn draw(&self, commands: &Commands, vertices: u32, first_instance: u32, instances: u32) {
        // SAFETY: bound before, without vertex buffers.
        unsafe { self.device.raw.cmd_draw(commands.raw, vertices, instances, 0, first_instance) };
    }

    /// Draws `count` vertices from `first` on, without vertex buffers.
    pub fn draw_from(&self, commands: &Commands, first: u32, count: u32) {
        // SAFETY: bound before, without vertex buffers.
        unsafe { self.device.raw.cmd_draw(commands.raw, count, 1, first, 0) };
    }

    /// Draws the indexed indirect commands from `offset` on: as many as the word at `count_offset` of `counts` says, or,
    /// on devices without drawIndirectCount, all `max_draws`, where unused commands must have zero instances.
    pub fn draw_indirect(
        &self,
        commands: &Commands,
        (draws, offset): (&Buffer, u64),
        (counts, count_offset): (&Buffer, u64),
        max_draws: u32,
    ) {
        let stride = size_of::<vk::DrawIndexedIndirectCommand>() as u32;
        let has_count = self.device.capabilities.draw_indirect_count;
        let device = &self.device.raw;
        // SAFETY: the buffers hold `max_draws` commands and the count, and outlive the submission.
        unsafe {
            if has_count {
                device.cmd_draw_indexed_indirect_count(
                    commands.raw,
                    draws.raw,
                    offset,
                    counts.raw,
                    count_offset,
                    max_draws,
                    stride,
                );
            } else {
                device.cmd_draw_indexed_indirect(commands.raw, draws.raw, offset, max_draws, stride);
            }
        }
    }
}

fn blend(additive: bool) -> vk::PipelineColorBlendAttachmentState {
    let state = vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(additive);
    let one = vk::BlendFactor::ONE;
    state
        .src_color_blend_factor(one)
        .dst_color_blend_factor(one)
        .src_alpha_blend_factor(one)
        .dst_alpha_blend_factor(one)
}

impl Drop for GraphicsPipeline {
    fn drop(&mut self) {
        // SAFETY: every submission that used the pipeline has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_pipeline(self.raw, None) });
    }
}

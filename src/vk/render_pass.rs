//! Render passes with stated loads, stores and views, and the framebuffers that go with them.

use super::commands::Commands;
use super::descriptors::read_layout;
use super::device::Device;
use super::error::{Context, Result};
use super::image::Image;
use ash::vk;
use std::sync::Arc;

/// What a render pass finds in an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// Nothing: cleared to zero.
    Clear,
    /// What was there, in the layout in which shaders read it.
    Keep,
}

/// An attachment: written, then left in the layout in which shaders read it.
#[derive(Clone, Copy, Debug)]
pub struct Attachment {
    /// Texel format; D32_SFLOAT makes it the depth attachment.
    pub format: vk::Format,
    /// Its content at the start.
    pub load: Load,
    /// Whether its content is kept at the end.
    pub store: bool,
}

/// Attachments, and one view mask a subpass. Every subpass uses all attachments.
pub struct RenderPassDesc<'a> {
    /// Debug name.
    pub name: &'static str,
    /// Colour attachments in order of their locations, and at most one depth attachment, last.
    pub attachments: &'a [Attachment],
    /// View masks of the subpasses (VK_KHR_multiview); a single 0 is a plain render pass.
    pub view_masks: &'a [u32],
}

/// A render pass.
pub struct RenderPass {
    pub(super) raw: vk::RenderPass,
    pub(super) color_count: u32,
    pub(super) has_depth: bool,
    device: Arc<Device>,
}

const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

impl RenderPass {
    /// Creates it.
    pub fn new(device: &Arc<Device>, desc: &RenderPassDesc<'_>) -> Result<Self> {
        let attachments: Vec<_> = desc.attachments.iter().map(attachment_description).collect();
        let color_count = desc.attachments.iter().filter(|a| a.format != DEPTH).count() as u32;
        let has_depth = color_count < desc.attachments.len() as u32;
        let colors: Vec<_> = (0..color_count)
            .map(|index| vk::AttachmentReference {
                attachment: index,
                layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
            })
            .collect();
        let depth = vk::AttachmentReference {
            attachment: color_count,
            layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
        };
        let subpasses: Vec<_> = desc
            .view_masks
            .iter()
            .map(|_| {
                let subpass = vk::SubpassDescription::default()
                    .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
                    .color_attachments(&colors);
                if has_depth { subpass.depth_stencil_attachment(&depth) } else { subpass }
            })
            .collect();
        let dependencies = dependencies(desc.view_masks.len() as u32);
        let mut multiview = vk::RenderPassMultiviewCreateInfo::default().view_masks(desc.view_masks);
        let mut info = vk::RenderPassCreateInfo::default()
            .attachments(&attachments)
            .subpasses(&subpasses)
            .dependencies(&dependencies);
        if desc.view_masks != [0] {
            info = info.push_next(&mut multiview);
        }
        // SAFETY: the device is alive and all that `info` points to lives through the call.
        let raw = unsafe { device.raw.create_render_pass(&info, None) }.during("creating a render pass")?;
        device.name(raw, desc.name);
        Ok(Self { raw, color_count, has_depth, device: device.clone() })
    }

    /// Begins the render pass over all of `target`; clear values are zero.
    pub fn begin(&self, commands: &Commands, target: &Framebuffer) {
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: target.extent };
        let clears = vec![vk::ClearValue::default(); (self.color_count + u32::from(self.has_depth)) as usize];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.raw)
            .framebuffer(target.raw)
            .render_area(area)
            .clear_values(&clears);
        // SAFETY: the framebuffer was made for a compatible render pass; both outlive the submission.
        unsafe { commands.device.raw.cmd_begin_render_pass(commands.raw, &info, vk::SubpassContents::INLINE) };
        self.set_area(commands, [0, 0], [target.extent.width, target.extent.height]);
    }

    /// Draws from here on go to this rectangle alone.
    pub fn set_area(&self, commands: &Commands, offset: [u32; 2], size: [u32; 2]) {
        let viewport = vk::Viewport {
            x: offset[0] as f32,
            y: offset[1] as f32,
            width: size[0] as f32,
            height: size[1] as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let scissor = vk::Rect2D {
            offset: vk::Offset2D { x: offset[0] as i32, y: offset[1] as i32 },
            extent: vk::Extent2D { width: size[0], height: size[1] },
        };
        // SAFETY: viewport and scissor are dynamic in every pipeline and lie within the framebuffer.
        unsafe {
            commands.device.raw.cmd_set_viewport(commands.raw, 0, &[viewport]);
            commands.device.raw.cmd_set_scissor(commands.raw, 0, &[scissor]);
        }
    }

    /// Goes on to the next subpass.
    pub fn next(&self, commands: &Commands) {
        // SAFETY: inside this render pass, which has a further subpass.
        unsafe { commands.device.raw.cmd_next_subpass(commands.raw, vk::SubpassContents::INLINE) };
    }

    /// Ends the render pass.
    pub fn end(&self, commands: &Commands) {
        // SAFETY: inside this render pass, in its last subpass.
        unsafe { commands.device.raw.cmd_end_render_pass(commands.raw) };
    }
}

fn attachment_description(attachment: &Attachment) -> vk::AttachmentDescription {
    let readable = match attachment.format {
        DEPTH => vk::ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
        _ => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
    };
    let (load, initial) = match attachment.load {
        Load::Clear => (vk::AttachmentLoadOp::CLEAR, vk::ImageLayout::UNDEFINED),
        Load::Keep => (vk::AttachmentLoadOp::LOAD, readable),
    };
    let store = if attachment.store { vk::AttachmentStoreOp::STORE } else { vk::AttachmentStoreOp::DONT_CARE };
    vk::AttachmentDescription::default()
        .format(attachment.format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(load)
        .store_op(store)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(initial)
        .final_layout(readable)
}

/// Attachment access after all that went before and before all that follows; subpasses view by view.
fn dependencies(subpasses: u32) -> Vec<vk::SubpassDependency> {
    let attachments = vk::AccessFlags::COLOR_ATTACHMENT_READ
        | vk::AccessFlags::COLOR_ATTACHMENT_WRITE
        | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ
        | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let stages = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT
        | vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
    let any = vk::PipelineStageFlags::ALL_COMMANDS;
    let before = vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .dst_subpass(0)
        .src_stage_mask(any)
        .dst_stage_mask(stages)
        .src_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(attachments);
    let after = vk::SubpassDependency::default()
        .src_subpass(subpasses - 1)
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(stages)
        .dst_stage_mask(any)
        .src_access_mask(attachments)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE);
    let between = (1..subpasses).map(|next| {
        vk::SubpassDependency::default()
            .src_subpass(next - 1)
            .dst_subpass(next)
            .src_stage_mask(stages)
            .dst_stage_mask(stages)
            .src_access_mask(attachments)
            .dst_access_mask(attachments)
            .dependency_flags(vk::DependencyFlags::BY_REGION)
    });
    std::iter::once(before).chain(between).chain(std::iter::once(after)).collect()
}

impl Drop for RenderPass {
    fn drop(&mut self) {
        // SAFETY: every submission that used the render pass has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_render_pass(self.raw, None) });
    }
}

/// Images bound to the attachments of a render pass.
pub struct Framebuffer {
    raw: vk::Framebuffer,
    extent: vk::Extent2D,
    /// Views of its own.
    layer_views: Vec<vk::ImageView>,
    device: Arc<Device>,
}

impl Framebuffer {
    /// A framebuffer of `images`, all of one size, in the order of the attachments. They must outlive it.
    pub fn new(pass: &RenderPass, images: &[&Image]) -> Result<Self> {
        Self::of_views(pass, images, &images.iter().map(|image| image.view).collect::<Vec<_>>())
    }

    /// One of a layer of `images` alone, for a render pass without views.
    pub fn of_layer(pass: &RenderPass, images: &[&Image], layer: u32) -> Result<Self> {
        let views = images.iter().map(|image| image.view_of(layer..layer + 1)).collect::<Result<Vec<_>>>()?;
        let mut made = Self::of_views(pass, images, &views)?;
        made.layer_views = views;
        Ok(made)
    }

    fn of_views(pass: &RenderPass, images: &[&Image], views: &[vk::ImageView]) -> Result<Self> {
        let [width, height] = images.first().expect("a render pass has attachments").desc.size;
        debug_assert!(images.iter().all(|image| read_layout(image) != vk::ImageLayout::UNDEFINED));
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(pass.raw)
            .attachments(views)
            .width(width)
            .height(height)
            .layers(1);
        // SAFETY: the render pass and the views are alive.
        let raw = unsafe { pass.device.raw.create_framebuffer(&info, None) }.during("creating a framebuffer")?;
        let extent = vk::Extent2D { width, height };
        Ok(Self { raw, extent, layer_views: Vec::new(), device: pass.device.clone() })
    }
}

impl Drop for Framebuffer {
    fn drop(&mut self) {
        // SAFETY: every submission that used the framebuffer has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_framebuffer(self.raw, None) });
        for view in &self.layer_views {
            // SAFETY: made for this framebuffer, which is gone.
            self.device.destroy(|raw| unsafe { raw.destroy_image_view(*view, None) });
        }
    }
}

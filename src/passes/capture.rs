//! Captures: multi-view render passes over a batch of frames, their tiles side by side in one layered target.
//!
//! A small scene is drawn whole, all views of a frame by one multi-view draw where the driver gets that right. A larger one
//! is culled first, per frame and per view, and each view is a subpass of its own (a one-bit view mask) with its own
//! indirect draws.

mod pipelines;
#[cfg(test)]
mod tests;

use super::counter::Counter;
use super::cull::Cull;
use super::fan_on;
use super::geometry::{DrawRange, Geometry};
use super::material::Textures;
use super::views::Views;
use crate::scene::Scene;
use crate::vk::gpu_types::Frame;
use crate::vk::{
    Attachment, Binding, Buffer, Commands, DescriptorSet, Device, Error, Framebuffer, GraphicsPipeline, Image,
    ImageDesc, Load, Memory, RenderPass, RenderPassDesc, Result, SetLayout,
};
use ash::vk;
use pipelines::PipelineBuilder;
use std::sync::Arc;

/// Scenes up to this many triangles are drawn whole: culling would cost more than it saves.
pub const WHOLE_SCENE: u32 = 256;

/// Shape of a capture target.
#[derive(Clone, Copy, Debug)]
pub struct CaptureDesc {
    /// Debug name.
    pub name: &'static str,
    /// Views of each frame.
    pub views: Views,
    /// Texels a side of a face.
    pub size: u32,
    /// Frames of a batch, at most; the device may allow fewer.
    pub capacity: u32,
    /// Whether to keep which triangle is seen, not depth alone.
    pub identity: bool,
    /// Whether to cull clusters per view; without it, all views are drawn whole by multi-view draws.
    pub culled: bool,
}

/// Triangles that one is drawn as: only perspective views see what goes on behind the eye.
fn fan(device: &Device, views: Views) -> u32 {
    if matches!(views, Views::Hemicube | Views::Cube | Views::Plane) { fan_on(device) } else { 1 }
}

/// Whether culling pays for a scene on this device.
pub fn pays_to_cull(device: &Device, triangles: u32) -> bool {
    triangles > WHOLE_SCENE && device.capabilities.multi_draw_indirect
}

/// Subpasses' pipelines for one draw range.
struct RangePipelines {
    range: DrawRange,
    by_subpass: Vec<GraphicsPipeline>,
    textured: bool,
}

/// The pass.
pub struct Capture {
    /// Its shape, the capacity cut to what the device allows.
    pub desc: CaptureDesc,
    /// Tiles in a row of the target.
    pub columns: u32,
    /// Which triangle each texel sees, if kept.
    pub identity: Option<Image>,
    /// Reversed depth.
    pub depth: Image,
    /// Frames to look from.
    pub frames: Buffer,
    cull: Option<Cull>,
    /// Triangles that one of the scene's is drawn as.
    fan: u32,
    ranges: Vec<RangePipelines>,
    pass: RenderPass,
    framebuffer: Framebuffer,
    frames_set: DescriptorSet,
    corner_indices: Option<Buffer>,
    view_masks: Vec<u32>,
    _frames_layout: SetLayout,
}

impl Capture {
    /// Builds target and pipelines.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        geometry: &Geometry,
        textures: Option<&Textures>,
        desc: CaptureDesc,
    ) -> Result<Self> {
        Self::counted(device, scene, geometry, textures, desc, None)
    }

    /// The same; what culling leaves, triangles times views, adds to `drawn`.
    pub fn counted(
        device: &Arc<Device>,
        scene: &Scene,
        geometry: &Geometry,
        textures: Option<&Textures>,
        desc: CaptureDesc,
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let (culled, fan) = (desc.culled, fan(device, desc.views));
        let (desc, columns, size) = layout_tiles(device, geometry, desc)?;
        let (identity, depth) = targets(device, &desc, size)?;
        let view_masks = view_masks(device, &desc);
        let pass = render_pass(device, &desc, &view_masks)?;
        let images: Vec<&Image> = identity.iter().chain([&depth]).collect();
        let framebuffer = Framebuffer::new(&pass, &images)?;
        let frame_bytes = u64::from(desc.capacity) * size_of::<Frame>() as u64;
        let frames = Buffer::new(device, "capture frames", frame_bytes, Memory::Device)?;
        let frames_layout = SetLayout::of(device, &[Binding::Storage(&frames)])?;
        let frames_set = DescriptorSet::new(&frames_layout, &[Binding::Storage(&frames)])?;
        let cull = culled
            .then(|| Cull::new(device, geometry, &frames, (desc.views, fan), desc.capacity, drawn))
            .transpose()?;
        let counts_corners = fan > 1 || geometry.ranges.iter().any(|r| r.masked.is_some());
        let corners = || (0..geometry.triangle_count * 3 * fan).collect::<Vec<_>>();
        let corners = || Buffer::with_data(device, "corner indices", &corners());
        let (pass_, frames_) = (&pass, &frames_layout);
        let build =
            PipelineBuilder { device, scene, geometry, textures, desc: &desc, fan, pass: pass_, frames: frames_ };
        let ranges =
            geometry.ranges.iter().map(|range| build.range(range, view_masks.len() as u32)).collect::<Result<_>>()?;
        Ok(Self {
            desc,
            columns,
            identity,
            depth,
            frames,
            cull,
            fan,
            ranges,
            pass,
            framebuffer,
            frames_set,
            corner_indices: counts_corners.then(corners).transpose()?,
            view_masks,
            _frames_layout: frames_layout,
        })
    }

    /// Whether clusters are culled before the capture.
    pub fn is_culled(&self) -> bool {
        self.cull.is_some()
    }

    /// Culls for the first `count` frames; nothing in a small scene.
    pub fn record_cull(&self, commands: &Commands, count: u32) {
        if let Some(cull) = &self.cull {
            cull.record(commands, count);
        }
    }

    /// Draws the first `count` frames.
    pub fn record(&self, commands: &Commands, geometry: &Geometry, textures: Option<&Textures>, count: u32) {
        self.pass.begin(commands, &self.framebuffer);
        for subpass in 0..self.view_masks.len() {
            if subpass > 0 {
                self.pass.next(commands);
            }
            for (index, range) in self.ranges.iter().enumerate() {
                self.bind(commands, geometry, textures, range, subpass);
                for frame in 0..count {
                    self.draw(commands, range, index as u32, subpass, frame);
                }
            }
        }
        self.pass.end(commands);
    }

    fn bind(
        &self,
        commands: &Commands,
        geometry: &Geometry,
        textures: Option<&Textures>,
        range: &RangePipelines,
        subpass: usize,
    ) {
        let pipeline = &range.by_subpass[subpass];
        match (range.range.masked, textures.filter(|_| range.textured)) {
            (None, _) if self.fan == 1 => pipeline.bind(commands, &[&self.frames_set]),
            (None, _) | (Some(_), None) => pipeline.bind(commands, &[&geometry.set, &self.frames_set]),
            (Some(material), Some(textures)) => {
                pipeline.bind(commands, &[&geometry.set, textures.set(material), &self.frames_set]);
            }
        }
        let (positions, indices) = geometry.capture_buffers();
        let corners = self.corner_indices.as_ref().filter(|_| range.range.masked.is_some() || self.fan > 1);
        pipeline.bind_mesh(commands, positions, corners.unwrap_or(indices));
    }

    fn draw(&self, commands: &Commands, range: &RangePipelines, index: u32, subpass: usize, frame: u32) {
        let pipeline = &range.by_subpass[subpass];
        let tile = [frame % self.columns * self.desc.size, frame / self.columns * self.desc.size];
        self.pass.set_area(commands, tile, [self.desc.size; 2]);
        pipeline.layout.push(commands, &[frame, range.range.masked.unwrap_or(0)]);
        let DrawRange { triangles, clusters, .. } = &range.range;
        match &self.cull {
            None => {
                let (first, count) = (triangles.start * self.fan, triangles.len() as u32 * self.fan);
                pipeline.draw_triangles(commands, first, count, triangles.start);
            }
            Some(cull) => {
                let (draw, count) = cull.offsets(frame, subpass as u32, index, clusters.start);
                pipeline.draw_indirect(commands, (&cull.draws, draw), (&cull.counts, count), clusters.len() as u32);
            }
        }
    }
}

/// One subpass for all views where one draw may go to all of them, else a subpass a view.
fn view_masks(device: &Device, desc: &CaptureDesc) -> Vec<u32> {
    let views = desc.views.count();
    if desc.culled || !device.capabilities.multiview_draws {
        (0..views).map(|view| 1 << view).collect()
    } else {
        vec![(1 << views) - 1]
    }
}

/// Cuts the capacity to the device's image size, then makes rows of tiles.
fn layout_tiles(device: &Device, geometry: &Geometry, mut desc: CaptureDesc) -> Result<(CaptureDesc, u32, [u32; 2])> {
    const DRAW_BUDGET: u64 = 64 << 20;
    let limits = &device.capabilities.limits;
    let widest = limits.max_image_dimension2_d.min(limits.max_framebuffer_width).min(limits.max_framebuffer_height);
    let per_row = widest / desc.size;
    if per_row == 0 {
        return Err(Error::Limit {
            object: desc.name.into(),
            needed: format!("{0}×{0} texels", desc.size),
            limit: format!("{widest}×{widest}"),
        });
    }
    if desc.culled {
        let fit = DRAW_BUDGET / Cull::bytes_per_frame(geometry, desc.views).max(1);
        desc.capacity = desc.capacity.min(fit.max(1) as u32);
    }
    desc.capacity = desc.capacity.clamp(1, per_row * per_row);
    let columns = (f64::from(desc.capacity).sqrt().ceil() as u32).min(per_row);
    let rows = desc.capacity.div_ceil(columns);
    Ok((desc, columns, [columns * desc.size, rows * desc.size]))
}

fn targets(device: &Arc<Device>, desc: &CaptureDesc, size: [u32; 2]) -> Result<(Option<Image>, Image)> {
    let image = |format, usage| {
        let layers = Some(desc.views.count());
        Image::new(
            device,
            ImageDesc { used_for: desc.name, format, size, layers, usage: usage | vk::ImageUsageFlags::SAMPLED },
        )
    };
    let identity =
        desc.identity.then(|| image(vk::Format::R32_UINT, vk::ImageUsageFlags::COLOR_ATTACHMENT)).transpose()?;
    Ok((identity, image(vk::Format::D32_SFLOAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)?))
}

fn render_pass(device: &Arc<Device>, desc: &CaptureDesc, view_masks: &[u32]) -> Result<RenderPass> {
    let attachment = |format| Attachment { format, load: Load::Clear, store: true };
    let attachments: Vec<_> = desc
        .identity
        .then(|| attachment(vk::Format::R32_UINT))
        .into_iter()
        .chain([attachment(vk::Format::D32_SFLOAT)])
        .collect();
    RenderPass::new(device, &RenderPassDesc { name: desc.name, attachments: &attachments, view_masks })
}

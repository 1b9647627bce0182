//! Captures: render passes over a batch of frames, their tiles side by side in one layered target.
//!
//! On a GPU one draw goes to all frames of a batch: the vertex stage puts each instance into its frame's tile, whose sides are clip
//! planes. On a CPU, where calls cost little and clip planes 1.4 times the time (llvmpipe, Sponza), a viewport is set for each frame. A
//! small scene is drawn whole, all views by one multi-view draw where the driver gets that right. A larger one is culled first, per
//! frame and per view, and each view is a pass of its own with one indirect draw a draw range; so are the views of a small
//! scene where no draw may go to several. Pipelines do not depend on the view: all masked materials share two.
//!
//! A batch of n frames in v views of a scene with r draw ranges takes by instances v·r calls where it is culled, and r calls, or v·r
//! without multi-view draws, where it is drawn whole; by viewports n times as many. There are at most three pipelines, whatever the
//! number of views and masked materials. Sponza at 256×256, 9,461 records in four ranges: 20 calls a batch of some hundred records
//! instead of 20 a record, 189,220 in all; 2 pipelines instead of 20.

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
use bytemuck::{Pod, Zeroable};
use pipelines::{Kind, PipelineBuilder};
use std::sync::Arc;

/// Scenes up to this many triangles are drawn whole: culling would cost more than it saves.
pub const WHOLE_SCENE: u32 = 256;

/// Frames of a batch, at most: a culled draw names its frame by 16 bits of its instance.
const MOST_FRAMES: u32 = 1 << 16;

/// Push constants: `glsl/capture/frames.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Push {
    view: u32,
    material: u32,
    first_triangle: u32,
    columns: u32,
    scale: [f32; 2],
}

const _: () = assert!(size_of::<Push>() == 24);

/// How frames find their tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FramesBy {
    /// A draw and a viewport for each frame.
    Viewports,
    /// One draw for all frames, an instance each, cut to its tile by clip planes.
    Instances,
}

impl FramesBy {
    /// What costs less on `device`.
    pub fn on(device: &Device) -> Self {
        if device.is_cpu() { Self::Viewports } else { Self::Instances }
    }

    /// Frames of one draw.
    fn at_once(self) -> u32 {
        if self == Self::Viewports { 1 } else { MOST_FRAMES }
    }
}

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
    /// Whether depth is kept for shaders, not only which triangle is seen.
    pub keeps_depth: bool,
    /// Whether to cull clusters per view; without it, all views are drawn whole by multi-view draws.
    pub culled: bool,
    /// How frames find their tiles.
    pub frames: FramesBy,
}

/// Triangles that one is drawn as: only perspective views see what goes on behind the eye.
fn fan(device: &Device, views: Views) -> u32 {
    if matches!(views, Views::Hemicube | Views::Cube | Views::Plane) { fan_on(device) } else { 1 }
}

/// Whether culling pays for a scene on this device.
pub fn pays_to_cull(device: &Device, triangles: u32) -> bool {
    triangles > WHOLE_SCENE && device.capabilities.multi_draw_indirect
}

/// The pass.
pub struct Capture {
    /// Its shape, the capacity cut to what the device allows.
    pub desc: CaptureDesc,
    /// Tiles in a row of the target.
    pub columns: u32,
    /// Number plus 1 of the triangle that each texel sees; 0: none.
    pub identity: Image,
    /// Reversed depth, undefined where it is not kept.
    pub depth: Image,
    /// Frames to look from.
    pub frames: Buffer,
    cull: Option<Cull>,
    /// Triangles that one of the scene's is drawn as.
    fan: u32,
    /// Draw ranges, each with its pipeline.
    ranges: Vec<(DrawRange, usize)>,
    pipelines: Vec<(Kind, GraphicsPipeline)>,
    pass: RenderPass,
    /// The target of all views, or one a view.
    framebuffers: Vec<Framebuffer>,
    frames_set: DescriptorSet,
    corner_indices: Option<Buffer>,
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
        let fan = fan(device, desc.views);
        let (desc, columns, size) = layout_tiles(device, geometry, desc)?;
        let [identity, depth] = targets(device, &desc, size)?;
        let at_once = draws_to_all_views(device, &desc);
        let pass = render_pass(device, &desc, at_once)?;
        let framebuffers = if at_once {
            vec![Framebuffer::new(&pass, &[&identity, &depth])?]
        } else {
            let layers = 0..desc.views.count();
            layers.map(|layer| Framebuffer::of_layer(&pass, &[&identity, &depth], layer)).collect::<Result<_>>()?
        };
        let frame_bytes = u64::from(desc.capacity) * size_of::<Frame>() as u64;
        let frames = Buffer::new(device, "capture frames", frame_bytes, Memory::Device)?;
        let frames_layout = SetLayout::of(device, &[Binding::Storage(&frames)])?;
        let frames_set = DescriptorSet::new(&frames_layout, &[Binding::Storage(&frames)])?;
        let cull = desc
            .culled
            .then(|| {
                Cull::new(device, geometry, &frames, (desc.views, fan), (desc.capacity, desc.frames.at_once()), drawn)
            })
            .transpose()?;
        let counts_corners = fan > 1 || geometry.ranges.iter().any(|r| r.masked.is_some());
        let corners = || (0..geometry.triangle_count * 3 * fan).collect::<Vec<_>>();
        let corners = || Buffer::with_data(device, "corner indices", &corners());
        let builder =
            PipelineBuilder { device, geometry, textures, desc: &desc, fan, pass: &pass, frames: &frames_layout };
        let (ranges, pipelines) = pipelines_of(&builder, scene)?;
        Ok(Self {
            desc,
            columns,
            identity,
            depth,
            frames,
            cull,
            fan,
            ranges,
            pipelines,
            pass,
            framebuffers,
            frames_set,
            corner_indices: counts_corners.then(corners).transpose()?,
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
        for (view, target) in self.framebuffers.iter().enumerate() {
            self.pass.begin(commands, target);
            for (index, (range, pipeline)) in self.ranges.iter().enumerate() {
                let (kind, pipeline) = &self.pipelines[*pipeline];
                self.bind(commands, (geometry, textures), (range, *kind), pipeline);
                self.draw(commands, (range, index as u32), pipeline, (view as u32, count));
            }
            self.pass.end(commands);
        }
    }

    fn bind(
        &self,
        commands: &Commands,
        (geometry, textures): (&Geometry, Option<&Textures>),
        (range, kind): (&DrawRange, Kind),
        pipeline: &GraphicsPipeline,
    ) {
        match (kind, range.masked, textures) {
            (Kind::Opaque, ..) if self.fan == 1 => pipeline.bind(commands, &[&self.frames_set]),
            (Kind::Textured, Some(material), Some(textures)) => {
                pipeline.bind(commands, &[&geometry.set, textures.set(material), &self.frames_set]);
            }
            _ => pipeline.bind(commands, &[&geometry.set, &self.frames_set]),
        }
        let (positions, indices) = geometry.capture_buffers();
        let corners = self.corner_indices.as_ref().filter(|_| range.masked.is_some() || self.fan > 1);
        pipeline.bind_mesh(commands, positions, corners.unwrap_or(indices));
    }

    fn draw(
        &self,
        commands: &Commands,
        (range, index): (&DrawRange, u32),
        pipeline: &GraphicsPipeline,
        (view, count): (u32, u32),
    ) {
        let DrawRange { masked, triangles, .. } = range;
        let [width, height] = self.depth.desc.size;
        let scale = [width, height].map(|texels| self.desc.size as f32 / texels as f32);
        let (first_triangle, columns) = (triangles.start, self.columns);
        let push = Push { view, material: masked.unwrap_or(0), first_triangle, columns, scale };
        pipeline.layout.push(commands, &push);
        let (first, drawn) = (triangles.start * self.fan, triangles.len() as u32 * self.fan);
        match (&self.cull, self.desc.frames) {
            (None, FramesBy::Instances) => pipeline.draw_triangles(commands, first, drawn, 0..count),
            (None, FramesBy::Viewports) => (0..count).for_each(|frame| {
                self.set_tile(commands, frame);
                pipeline.draw_triangles(commands, first, drawn, frame..frame + 1);
            }),
            (Some(cull), by) => cull.lists(view, index, count).zip(0..).for_each(|(list, number)| {
                if by == FramesBy::Viewports {
                    self.set_tile(commands, number);
                }
                pipeline.draw_indirect(commands, (&cull.draws, list.draws), (&cull.counts, list.count), list.most);
            }),
        }
    }

    fn set_tile(&self, commands: &Commands, frame: u32) {
        let tile = [frame % self.columns * self.desc.size, frame / self.columns * self.desc.size];
        self.pass.set_area(commands, tile, [self.desc.size; 2]);
    }
}

/// Each draw range with the number of its pipeline, and the pipelines.
type Drawn = (Vec<(DrawRange, usize)>, Vec<(Kind, GraphicsPipeline)>);

fn pipelines_of(builder: &PipelineBuilder<'_>, scene: &Scene) -> Result<Drawn> {
    let mut pipelines: Vec<(Kind, GraphicsPipeline)> = Vec::new();
    let mut ranges = Vec::new();
    for range in &builder.geometry.ranges {
        let kind = Kind::of(scene, builder.textures, range);
        let made = pipelines.iter().position(|(of, _)| *of == kind);
        if made.is_none() {
            pipelines.push((kind, builder.pipeline(kind)?));
        }
        ranges.push((range.clone(), made.unwrap_or(pipelines.len() - 1)));
    }
    Ok((ranges, pipelines))
}

/// Whether one pass draws all views, by multi-view draws; else each view is a pass of its own.
fn draws_to_all_views(device: &Device, desc: &CaptureDesc) -> bool {
    let (views, capabilities) = (desc.views.count(), &device.capabilities);
    !desc.culled && capabilities.multiview_draws && (2..=capabilities.max_views).contains(&views)
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
    desc.capacity = desc.capacity.clamp(1, per_row.saturating_mul(per_row).min(MOST_FRAMES));
    let columns = (f64::from(desc.capacity).sqrt().ceil() as u32).min(per_row);
    let rows = desc.capacity.div_ceil(columns);
    Ok((desc, columns, [columns * desc.size, rows * desc.size]))
}

fn targets(device: &Arc<Device>, desc: &CaptureDesc, size: [u32; 2]) -> Result<[Image; 2]> {
    let image = |format, usage| {
        let layers = Some(desc.views.count());
        Image::new(
            device,
            ImageDesc { used_for: desc.name, format, size, layers, usage: usage | vk::ImageUsageFlags::SAMPLED },
        )
    };
    Ok([
        image(vk::Format::R32_UINT, vk::ImageUsageFlags::COLOR_ATTACHMENT)?,
        image(vk::Format::D32_SFLOAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)?,
    ])
}

fn render_pass(device: &Arc<Device>, desc: &CaptureDesc, at_once: bool) -> Result<RenderPass> {
    let attachment = |format, store| Attachment { format, load: Load::Clear, store };
    let attachments = [attachment(vk::Format::R32_UINT, true), attachment(vk::Format::D32_SFLOAT, desc.keeps_depth)];
    let mask = if at_once { (1 << desc.views.count()) - 1 } else { 0 };
    RenderPass::new(device, &RenderPassDesc { name: desc.name, attachments: &attachments, view_masks: &[mask] })
}

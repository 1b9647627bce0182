//! Splats kept records over the G-buffer with additive float blending.

use super::gbuffer::Targets;
use super::keep_records::Horizon;
use crate::vk::{
    Attachment, Binding, Buffer, Commands, DescriptorSet, Device, Framebuffer, GraphicsDesc, GraphicsPipeline, Image,
    ImageDesc, Load, Memory, PipelineLayout, RenderPass, RenderPassDesc, Result, SetLayout, Specialisation,
    VertexInput, spirv,
};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;
use std::sync::Arc;

const SUM: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The camera and the weights' limits.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct View {
    /// Rigid transform to view space, looking along −z.
    pub world_to_view: [f32; 16],
    /// `ndc = scale.xy · (x, y)/depth`; w: 0 for parallel views, where nothing is divided.
    pub scale: [f32; 4],
    /// Ward's a.
    pub accuracy: f32,
    /// √(1 − n·n_k) at which the weight has fallen to zero; 0: records light any surface, as if it had their normal.
    pub normal_limit: f32,
    /// Share of the weight that counts: 1, or next to nothing for what stands in where nothing else is.
    pub share: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Push {
    view: View,
    first_zone: u32,
}

/// Weight of a record at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Bounded (Tabellion and Lamorlette 2004).
    Bounded,
    /// Ward, Rubinstein and Clear 1988.
    Ward,
}

/// What the pass sums besides weighted irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// The sky's own irradiance, in an attachment of its own.
    pub sky: bool,
    /// [`Sums::tally`], in an attachment of its own.
    pub tally: bool,
    /// Every fragment in the tally, not only those that add something; wants `tally`.
    pub fragments: bool,
}

/// Kept records to splat: a piece of the store, and the radii of all zones.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Places of the piece.
    pub records: &'a Buffer,
    /// Payloads of the piece.
    pub payloads: &'a Buffer,
    /// Horizons of the piece; anything where none are kept.
    pub horizons: &'a Buffer,
    /// Radius of the zone of each record of the whole store in this view.
    pub zones: &'a Buffer,
}

/// How records contribute.
#[derive(Clone, Copy, Debug)]
pub struct Contribution {
    /// Irradiance is extrapolated by gradients.
    pub gradients: bool,
    /// Weight of a record at a point.
    pub weight: Weight,
    /// Points are rejected that are hidden by a record's horizon; none: all are lit.
    pub horizon: Option<Horizon>,
}

/// Sums of the splats: Σ w·E and Σ w.
pub struct Sums {
    /// Of irradiance by one reflection.
    pub indirect: Image,
    /// Of the sky's irradiance.
    pub sky: Option<Image>,
    /// Number of records of a pixel, the weighted sums of the luminance and squared luminance of what they say, and, where
    /// they are counted, the number of fragments.
    pub tally: Option<Image>,
}

/// The pass.
pub struct Splat {
    /// What it sums.
    pub sums: Sums,
    clear: RenderPass,
    keep: RenderPass,
    framebuffer: Framebuffer,
    pipeline: GraphicsPipeline,
    layout: SetLayout,
}

impl Splat {
    /// Builds the pass; it needs a `source` to know what it binds.
    pub fn new(
        device: &Arc<Device>,
        gbuffer: &Targets,
        source: &Source<'_>,
        outputs: Outputs,
        contribution: Contribution,
    ) -> Result<Self> {
        let sums = Sums::new(device, gbuffer.position.desc.size, outputs)?;
        let images = sums.in_order();
        let pass = |load| {
            let attachments = vec![Attachment { format: SUM, load, store: true }; images.len()];
            RenderPass::new(device, &RenderPassDesc { name: "splat", attachments: &attachments, view_masks: &[0] })
        };
        let (clear, keep) = (pass(Load::Clear)?, pass(Load::Keep)?);
        let framebuffer = Framebuffer::new(&clear, &images)?;
        let layout = SetLayout::of(device, &bindings(gbuffer, source))?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let Contribution { gradients, weight, horizon } = contribution;
        let [sky, gradients, ward, fragments] =
            [outputs.sky, gradients, weight == Weight::Ward, outputs.fragments].map(u32::from);
        let [size, columns] = Horizon::constants(horizon);
        let constants = vec![sky, gradients, ward, size, columns, fragments];
        let fragment = match (outputs.sky, outputs.tally) {
            (false, false) => spirv!("splat", "plain.frag"),
            (true, false) => spirv!("splat", "sky.frag"),
            (false, true) => spirv!("splat", "counted.frag"),
            (true, true) => spirv!("splat", "sky_counted.frag"),
        };
        let desc = GraphicsDesc {
            name: "splat",
            vertex: spirv!("splat", "splat.vert"),
            fragment: Some(fragment),
            constants: Specialisation(constants).into(),
            input: VertexInput::None,
            topology: vk::PrimitiveTopology::TRIANGLE_STRIP,
            additive: true,
        };
        let pipeline = GraphicsPipeline::new(&pipeline_layout, &keep, 0, &desc)?;
        Ok(Self { clear, keep, framebuffer, pipeline, layout, sums })
    }

    /// The buffers of a `source` over the G-buffer that the pass was built for.
    pub fn set(&self, gbuffer: &Targets, source: &Source<'_>) -> Result<DescriptorSet> {
        DescriptorSet::new(&self.layout, &bindings(gbuffer, source))
    }

    /// Empties the sums.
    pub fn record_clear(&self, commands: &Commands) {
        self.clear.begin(commands, &self.framebuffer);
        self.clear.end(commands);
    }

    /// Adds a range of a piece's records, whose first record has the number `first_zone` in the store.
    pub fn record(&self, commands: &Commands, view: &View, set: &DescriptorSet, range: Range<u32>, first_zone: u32) {
        self.keep.begin(commands, &self.framebuffer);
        self.pipeline.bind(commands, &[set]);
        self.pipeline.layout.push(commands, &Push { view: *view, first_zone });
        self.pipeline.draw(commands, 4, range.start, range.len() as u32);
        self.keep.end(commands);
    }
}

fn bindings<'a>(gbuffer: &'a Targets, source: &Source<'a>) -> [Binding<'a>; 6] {
    let Source { records, payloads, horizons, zones } = *source;
    let [records, payloads, horizons, zones] = [records, payloads, horizons, zones].map(Binding::Storage);
    [records, payloads, horizons, zones, Binding::Texels(&gbuffer.position), Binding::Texels(&gbuffer.normals)]
}

/// The tally on the CPU.
pub struct Tally {
    readback: Buffer,
    pixels: usize,
}

impl Tally {
    /// Of an image of that size.
    pub fn new(device: &Arc<Device>, size: [u32; 2]) -> Result<Self> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        Ok(Self { readback: Buffer::new(device, "read-back", pixels * 16, Memory::Readback)?, pixels: pixels as usize })
    }

    /// Copies the tally of `splat`, if it has one.
    pub fn record_readback(&self, commands: &Commands, splat: &Splat) {
        if let Some(tally) = &splat.sums.tally {
            commands.copy_image(tally, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, &self.readback);
        }
    }

    /// Fragments, and those of them that have a weight; once the read-back has been waited for.
    pub fn read(&self) -> (u64, u64) {
        let pixels: Vec<[f32; 4]> = self.readback.read(self.pixels);
        pixels.iter().fold((0, 0), |(all, weighted), p| (all + p[3] as u64, weighted + p[0] as u64))
    }
}

impl Sums {
    fn new(device: &Arc<Device>, size: [u32; 2], outputs: Outputs) -> Result<Self> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let sum = || Image::new(device, ImageDesc { used_for: "splat sums", format: SUM, size, layers: None, usage });
        Ok(Self {
            indirect: sum()?,
            sky: outputs.sky.then(sum).transpose()?,
            tally: outputs.tally.then(sum).transpose()?,
        })
    }

    fn in_order(&self) -> Vec<&Image> {
        [Some(&self.indirect), self.sky.as_ref(), self.tally.as_ref()].into_iter().flatten().collect()
    }
}

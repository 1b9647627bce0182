//! Images with one view of all their layers.

use super::barrier;
use super::buffer::{Buffer, Memory};
use super::commands::Commands;
use super::device::Device;
use super::error::{Context, Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Shape and use of an image.
#[derive(Clone, Copy, Debug)]
pub struct ImageDesc {
    /// What the memory report calls it.
    pub used_for: &'static str,
    /// Texel format.
    pub format: vk::Format,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Number of layers; `None` is a plain 2D image, `Some` an array.
    pub layers: Option<u32>,
    /// Uses beyond transfers.
    pub usage: vk::ImageUsageFlags,
}

/// An image, its memory and a view of all its layers.
pub struct Image {
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Option<Allocation>,
    bytes: u64,
    /// Its shape and use.
    pub desc: ImageDesc,
    device: Arc<Device>,
}

impl Image {
    /// An image whose content is undefined.
    pub fn new(device: &Arc<Device>, desc: ImageDesc) -> Result<Self> {
        check_size(device, &desc)?;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.size[0], height: desc.size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(desc.layers.unwrap_or(1))
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(desc.usage | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST);
        // SAFETY: the device is alive and `info` is complete and within its limits.
        let raw = unsafe { device.raw.create_image(&info, None) }.during("creating an image")?;
        let view = vk::ImageView::null();
        let mut image = Self { raw, view, allocation: None, bytes: 0, desc, device: device.clone() };
        image.bind()?;
        image.view = image.create_view()?;
        device.name(raw, desc.used_for);
        Ok(image)
    }

    /// A sampled RGBA8 image that holds `texels`; `srgb` decodes on reading. Waits for the copy.
    pub fn with_texels(
        device: &Arc<Device>,
        used_for: &'static str,
        size: [u32; 2],
        texels: &[[u8; 4]],
        srgb: bool,
    ) -> Result<Self> {
        let format = if srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM };
        let usage = vk::ImageUsageFlags::SAMPLED;
        let image = Self::new(device, ImageDesc { used_for, format, size, layers: None, usage })?;
        image.upload(bytemuck::cast_slice(texels))?;
        Ok(image)
    }

    /// Fills the image with tightly packed texels, leaves it readable by shaders, and waits.
    pub fn upload(&self, bytes: &[u8]) -> Result<()> {
        let mut staging = Buffer::new(&self.device, "staging", bytes.len() as u64, Memory::Upload)?;
        staging.write(bytes);
        let commands = Commands::begin(&self.device)?;
        let (undefined, target) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        barrier::image_layout(&commands, self, undefined, target);
        // SAFETY: both outlive the submission, which is waited for; the buffer holds every texel of the image.
        unsafe {
            self.device.raw.cmd_copy_buffer_to_image(commands.raw, staging.raw, self.raw, target, &[self.whole()]);
        }
        barrier::image_layout(&commands, self, target, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        commands.run(&format!("the upload of {}", self.desc.used_for))
    }

    /// The region of a copy of all texels of all layers.
    pub(super) fn whole(&self) -> vk::BufferImageCopy {
        vk::BufferImageCopy::default().image_subresource(self.layers()).image_extent(vk::Extent3D {
            width: self.desc.size[0],
            height: self.desc.size[1],
            depth: 1,
        })
    }

    pub(super) fn aspect(&self) -> vk::ImageAspectFlags {
        match self.desc.format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        }
    }

    pub(super) fn all_layers(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange::default()
            .aspect_mask(self.aspect())
            .level_count(1)
            .layer_count(self.desc.layers.unwrap_or(1))
    }

    fn layers(&self) -> vk::ImageSubresourceLayers {
        let layers = self.desc.layers.unwrap_or(1);
        vk::ImageSubresourceLayers::default().aspect_mask(self.aspect()).layer_count(layers)
    }

    fn bind(&mut self) -> Result<()> {
        // SAFETY: the image is alive.
        let requirements = unsafe { self.device.raw.get_image_memory_requirements(self.raw) };
        let description = AllocationCreateDesc {
            name: self.desc.used_for,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = self.device.allocator().allocate(&description).map_err(|e| Error::Allocation {
            name: self.desc.used_for.into(),
            bytes: requirements.size,
            reason: e.to_string(),
        })?;
        // SAFETY: the memory meets the image's requirements and is not bound elsewhere.
        unsafe { self.device.raw.bind_image_memory(self.raw, allocation.memory(), allocation.offset()) }
            .during("binding image memory")?;
        self.bytes = requirements.size;
        self.device.count_allocation(self.desc.used_for, self.bytes);
        self.allocation = Some(allocation);
        Ok(())
    }

    fn create_view(&self) -> Result<vk::ImageView> {
        self.view_of(0..self.desc.layers.unwrap_or(1))
    }

    /// A view of some layers, to be destroyed by the caller.
    pub(super) fn view_of(&self, layers: std::ops::Range<u32>) -> Result<vk::ImageView> {
        let kind =
            if self.desc.layers.is_some() { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(self.aspect())
            .level_count(1)
            .base_array_layer(layers.start)
            .layer_count(layers.len() as u32);
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.desc.format)
            .subresource_range(range);
        // SAFETY: the image is alive and bound to memory.
        unsafe { self.device.raw.create_image_view(&info, None) }.during("creating an image view")
    }
}

fn check_size(device: &Device, desc: &ImageDesc) -> Result<()> {
    let limits = &device.capabilities.limits;
    let [width, height] = desc.size;
    let limit = limits.max_image_dimension2_d;
    let (layers, most_layers) = (desc.layers.unwrap_or(1), limits.max_image_array_layers);
    if layers > most_layers {
        return Err(Error::Limit {
            object: desc.used_for.into(),
            needed: format!("{layers} layers"),
            limit: format!("{most_layers} (maxImageArrayLayers)"),
        });
    }
    if width > limit || height > limit || width == 0 || height == 0 {
        return Err(Error::Limit {
            object: desc.used_for.into(),
            needed: format!("{width}×{height} texels"),
            limit: format!("{limit}×{limit}"),
        });
    }
    Ok(())
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: every submission that named the image has been waited for.
        self.device.destroy(|raw| unsafe {
            raw.destroy_image_view(self.view, None);
            raw.destroy_image(self.raw, None);
        });
        if let Some(allocation) = self.allocation.take() {
            self.device.free(self.desc.used_for, allocation, self.bytes);
        }
    }
}

/// How a texture is read.
pub struct Sampler {
    raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Reads level 0, bilinear or nearest.
    pub fn new(device: &Arc<Device>, wrap: [vk::SamplerAddressMode; 2], nearest: bool) -> Result<Self> {
        let filter = if nearest { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(filter)
            .min_filter(filter)
            .address_mode_u(wrap[0])
            .address_mode_v(wrap[1])
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE);
        // SAFETY: the device is alive.
        let raw = unsafe { device.raw.create_sampler(&info, None) }.during("creating a sampler")?;
        Ok(Self { raw, device: device.clone() })
    }

    /// Vulkan's handle, valid while this lives.
    pub fn raw(&self) -> vk::Sampler {
        self.raw
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: every submission that used the sampler has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_sampler(self.raw, None) });
    }
}

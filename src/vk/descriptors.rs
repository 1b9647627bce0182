//! Descriptor sets: a list of resources in binding order.

use super::buffer::Buffer;
use super::device::Device;
use super::error::{Context, Result};
use super::image::Image;
use super::shader::{Shader, Slot};
use super::texel_buffer::{BufferView, TexelBuffer};
use ash::vk;
use std::sync::Arc;

/// A resource for a shader, in the order of its bindings.
#[derive(Clone, Copy)]
pub enum Binding<'a> {
    /// A storage buffer, whole.
    Storage(&'a Buffer),
    /// A buffer read by `texelFetch`.
    TexelBuffer(&'a TexelBuffer),
    /// A view of a buffer read by `texelFetch`.
    View(&'a BufferView),
    /// An image read by `texelFetch`; depth images are expected in the depth read-only layout.
    Texels(&'a Image),
    /// An image that shaders load and store texel by texel, always in the general layout ([`Commands::clear_image`]).
    ///
    /// [`Commands::clear_image`]: super::Commands::clear_image
    Stored(&'a Image),
    /// An image read through a sampler.
    Sampled(&'a Image, vk::Sampler),
}

impl Binding<'_> {
    fn kind(&self) -> vk::DescriptorType {
        match self {
            Self::Storage(_) => vk::DescriptorType::STORAGE_BUFFER,
            Self::TexelBuffer(_) | Self::View(_) => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
            Self::Texels(_) => vk::DescriptorType::SAMPLED_IMAGE,
            Self::Stored(_) => vk::DescriptorType::STORAGE_IMAGE,
            Self::Sampled(..) => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        }
    }
}

/// The kinds of a set's bindings, visible to all stages.
pub struct SetLayout {
    pub(super) raw: vk::DescriptorSetLayout,
    /// Binding and kind of each.
    pub(super) slots: Vec<(u32, vk::DescriptorType)>,
    device: Arc<Device>,
}

impl SetLayout {
    /// A layout with one binding a kind, numbered in order.
    pub fn new(device: &Arc<Device>, kinds: &[vk::DescriptorType]) -> Result<Self> {
        Self::numbered(device, (0..).zip(kinds.iter().copied()).collect())
    }

    /// The layout of the set `set` that `shaders` declare.
    pub fn declared(device: &Arc<Device>, shaders: &[&Shader], set: u32) -> Result<Self> {
        let of_set = shaders.iter().flat_map(|shader| shader.bindings).filter(|slot| slot.set == set);
        let mut slots: Vec<_> = of_set.map(|slot| (slot.binding, slot.kind)).collect();
        slots.sort_by_key(|(binding, kind)| (*binding, kind.as_raw()));
        slots.dedup();
        Self::numbered(device, slots)
    }

    fn numbered(device: &Arc<Device>, slots: Vec<(u32, vk::DescriptorType)>) -> Result<Self> {
        let bindings: Vec<_> = slots
            .iter()
            .map(|(binding, kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(*binding)
                    .descriptor_type(*kind)
                    .descriptor_count(1)
                    .stage_flags(
                        vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT | vk::ShaderStageFlags::COMPUTE,
                    )
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the device is alive and `info` is complete.
        let raw = unsafe { device.raw.create_descriptor_set_layout(&info, None) }.during("creating a set layout")?;
        Ok(Self { raw, slots, device: device.clone() })
    }

    /// The layout that `bindings` have.
    pub fn of(device: &Arc<Device>, bindings: &[Binding<'_>]) -> Result<Self> {
        Self::new(device, &bindings.iter().map(Binding::kind).collect::<Vec<_>>())
    }
}

impl SetLayout {
    pub(super) fn storage_buffers(&self) -> u32 {
        self.slots.iter().filter(|(_, kind)| *kind == vk::DescriptorType::STORAGE_BUFFER).count() as u32
    }
}

impl Drop for SetLayout {
    fn drop(&mut self) {
        // SAFETY: pipelines and sets made from the layout do not need it any more.
        self.device.destroy(|raw| unsafe { raw.destroy_descriptor_set_layout(self.raw, None) });
    }
}

/// A descriptor set with a pool of its own.
pub struct DescriptorSet {
    pub(super) raw: vk::DescriptorSet,
    pool: vk::DescriptorPool,
    device: Arc<Device>,
}

impl DescriptorSet {
    /// A set that holds `bindings`, in the order of the layout's.
    pub fn new(layout: &SetLayout, bindings: &[Binding<'_>]) -> Result<Self> {
        debug_assert_eq!(
            layout.slots,
            bindings.iter().map(|b| b.kind()).zip(0..).map(|(k, i)| (i, k)).collect::<Vec<_>>()
        );
        Self::holding(layout, (0..).zip(bindings))
    }

    /// The set `set` that `shaders` declare, with each of its resources by the name that it has there. A resource that is
    /// missing, of another kind or not declared is a fault of the program and panics.
    pub fn named(
        device: &Arc<Device>,
        shaders: &[&Shader],
        set: u32,
        resources: &[(&str, Binding<'_>)],
    ) -> Result<(SetLayout, Self)> {
        let slots = || shaders.iter().flat_map(|shader| shader.bindings).filter(|slot| slot.set == set);
        for (name, _) in resources {
            assert!(slots().any(|slot| slot.name == *name), "{} declares no {name}", shaders[0].name);
        }
        let layout = SetLayout::declared(device, shaders, set)?;
        let resource = |slot: &Slot| {
            let found = resources.iter().find(|(name, _)| *name == slot.name);
            let (_, binding) = found.unwrap_or_else(|| panic!("{} of {} is not bound", slot.name, shaders[0].name));
            assert_eq!(binding.kind(), slot.kind, "kind of {} in {}", slot.name, shaders[0].name);
            (slot.binding, binding)
        };
        let set = Self::holding(&layout, slots().map(resource))?;
        Ok((layout, set))
    }

    fn holding<'a>(layout: &SetLayout, bindings: impl Iterator<Item = (u32, &'a Binding<'a>)>) -> Result<Self> {
        let device = &layout.device;
        let size = |kind| vk::DescriptorPoolSize::default().ty(kind).descriptor_count(1);
        let sizes: Vec<_> = layout.slots.iter().map(|(_, kind)| size(*kind)).collect();
        let pool_info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: the device is alive and `pool_info` is complete.
        let pool = unsafe { device.raw.create_descriptor_pool(&pool_info, None) }.during("creating a pool")?;
        let mut set = Self { raw: vk::DescriptorSet::null(), pool, device: device.clone() };
        let layouts = [layout.raw];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: the pool has room for exactly this set.
        set.raw = unsafe { device.raw.allocate_descriptor_sets(&info) }.during("allocating a descriptor set")?[0];
        bindings.for_each(|(binding, resource)| set.write(binding, resource));
        Ok(set)
    }

    fn write(&self, index: u32, binding: &Binding<'_>) {
        let mut buffers = [vk::DescriptorBufferInfo::default().range(vk::WHOLE_SIZE)];
        let mut images = [vk::DescriptorImageInfo::default()];
        let mut views = [vk::BufferView::null()];
        let write =
            vk::WriteDescriptorSet::default().dst_set(self.raw).dst_binding(index).descriptor_type(binding.kind());
        let write = match *binding {
            Binding::Storage(buffer) => {
                buffers[0].buffer = buffer.raw;
                write.buffer_info(&buffers)
            }
            Binding::TexelBuffer(TexelBuffer { view, .. }) | Binding::View(view) => {
                views[0] = view.raw;
                write.texel_buffer_view(&views)
            }
            Binding::Texels(image) | Binding::Sampled(image, _) | Binding::Stored(image) => {
                images[0].image_view = image.view;
                images[0].image_layout = match binding {
                    Binding::Stored(_) => vk::ImageLayout::GENERAL,
                    _ => read_layout(image),
                };
                if let Binding::Sampled(_, sampler) = binding {
                    images[0].sampler = *sampler;
                }
                write.image_info(&images)
            }
        };
        // SAFETY: the set is not in use; the resources are alive.
        unsafe { self.device.raw.update_descriptor_sets(&[write], &[]) };
    }
}

/// The layout in which an image is read by shaders.
pub(super) fn read_layout(image: &Image) -> vk::ImageLayout {
    match image.desc.format {
        vk::Format::D32_SFLOAT => vk::ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
        _ => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
    }
}

impl Drop for DescriptorSet {
    fn drop(&mut self) {
        // SAFETY: every submission that used the set has been waited for; the pool frees it.
        self.device.destroy(|raw| unsafe { raw.destroy_descriptor_pool(self.pool, None) });
    }
}

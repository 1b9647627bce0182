//! Buffers read through a format, four floats at a time: the path that drivers make fastest for what is only read.

use super::buffer::{Buffer, Memory};
use super::device::Device;
use super::error::{Context, Error, Result};
use ash::vk;
use bytemuck::Pod;
use std::sync::Arc;

/// A device buffer of `vec4`s with a view for `texelFetch`.
pub struct TexelBuffer {
    /// All of it.
    pub view: BufferView,
    /// The buffer itself, for what writes it.
    pub buffer: Buffer,
}

/// A view of a buffer for `texelFetch`; the buffer outlives what uses it.
pub struct BufferView {
    pub(super) raw: vk::BufferView,
    device: Arc<Device>,
}

impl BufferView {
    /// Of all that `buffer` holds, in values of two floats.
    pub fn of_pairs(device: &Arc<Device>, buffer: &Buffer, used_for: &'static str) -> Result<Self> {
        Self::new(device, buffer, used_for, vk::Format::R32G32_SFLOAT)
    }

    fn new(device: &Arc<Device>, buffer: &Buffer, used_for: &'static str, format: vk::Format) -> Result<Self> {
        let info = vk::BufferViewCreateInfo::default().buffer(buffer.raw).format(format).range(vk::WHOLE_SIZE);
        // SAFETY: the buffer is alive, made for this use, and of a format that every device reads so.
        let raw = unsafe { device.raw.create_buffer_view(&info, None) }.during("creating a buffer view")?;
        device.name(raw, used_for);
        Ok(Self { raw, device: device.clone() })
    }
}

impl TexelBuffer {
    /// A buffer that holds `data`, a whole number of `vec4`s; waits for the copy.
    pub fn with_data<T: Pod>(device: &Arc<Device>, used_for: &'static str, data: &[T]) -> Result<Self> {
        let texels = Self::new(device, used_for, size_of_val(data) as u64)?;
        texels.buffer.upload(data)?;
        Ok(texels)
    }

    /// A buffer of `size` bytes.
    pub fn new(device: &Arc<Device>, used_for: &'static str, size: u64) -> Result<Self> {
        const TEXEL: u64 = size_of::<[f32; 4]>() as u64;
        let size = size.max(TEXEL);
        let limit = device.capabilities.limits.max_texel_buffer_elements;
        if size / TEXEL > u64::from(limit) {
            return Err(Error::Limit {
                object: used_for.into(),
                needed: format!("a buffer of {} texels", size / TEXEL),
                limit: format!("{limit} texels (maxTexelBufferElements)"),
            });
        }
        let buffer = Buffer::unlimited(device, used_for, size, Memory::Device)?;
        let view = BufferView::new(device, &buffer, used_for, vk::Format::R32G32B32A32_SFLOAT)?;
        Ok(Self { view, buffer })
    }
}

impl Drop for BufferView {
    fn drop(&mut self) {
        // SAFETY: every submission that read the buffer has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_buffer_view(self.raw, None) });
    }
}

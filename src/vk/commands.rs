//! A command buffer that is recorded once, submitted once and waited for.

use super::buffer::Buffer;
use super::device::Device;
use super::error::{Context, Result};
use super::image::Image;
use ash::vk;
use std::sync::Arc;

/// A command buffer being recorded.
pub struct Commands {
    pub(super) raw: vk::CommandBuffer,
    /// The device it runs on.
    pub device: Arc<Device>,
}

impl Commands {
    /// Starts recording.
    pub fn begin(device: &Arc<Device>) -> Result<Self> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(device.command_pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool belongs to the device; all recording is on this thread, by `&self` that is not Sync-shared.
        let raw = unsafe { device.raw.allocate_command_buffers(&info) }.during("allocating a command buffer")?[0];
        let commands = Self { raw, device: device.clone() };
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is fresh.
        unsafe { device.raw.begin_command_buffer(raw, &begin) }.during("beginning a command buffer")?;
        Ok(commands)
    }

    /// Submits and waits until the GPU is done.
    pub fn finish(self) -> Result<()> {
        let device = &self.device.raw;
        // SAFETY: recording was begun; fence and command buffer outlive the wait.
        unsafe {
            device.end_command_buffer(self.raw).during("ending a command buffer")?;
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).during("creating a fence")?;
            let buffers = [self.raw];
            let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
            let done = device
                .queue_submit(self.device.queue, &submit, fence)
                .and_then(|()| device.wait_for_fences(&[fence], true, u64::MAX));
            device.destroy_fence(fence, None);
            done.during("running a command buffer")
        }
    }

    /// Copies the first `size` bytes of `from` to `to`.
    pub fn copy_buffer(&self, from: &Buffer, to: &Buffer, size: u64) {
        let region = vk::BufferCopy::default().size(size);
        // SAFETY: both buffers hold `size` bytes and outlive the submission.
        unsafe { self.device.raw.cmd_copy_buffer(self.raw, from.raw, to.raw, &[region]) };
    }

    /// Copies all texels of `from`, which is in `layout`, to the start of `to`.
    pub fn copy_image(&self, from: &Image, layout: vk::ImageLayout, to: &Buffer) {
        super::barrier::image_layout(self, from, layout, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        // SAFETY: the buffer holds all texels; both outlive the submission.
        unsafe { self.device.raw.cmd_copy_image_to_buffer(self.raw, from.raw, source, to.raw, &[from.whole()]) };
        super::barrier::image_layout(self, from, vk::ImageLayout::TRANSFER_SRC_OPTIMAL, layout);
    }

    /// Fills all of `buffer` with `word`.
    pub fn fill(&self, buffer: &Buffer, word: u32) {
        // SAFETY: the buffer outlives the submission.
        unsafe { self.device.raw.cmd_fill_buffer(self.raw, buffer.raw, 0, vk::WHOLE_SIZE, word) };
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // SAFETY: `finish` has waited, or the buffer was never submitted.
        unsafe { self.device.raw.free_command_buffers(self.device.command_pool, &[self.raw]) };
    }
}

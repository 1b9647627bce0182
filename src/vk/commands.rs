//! A command buffer that is recorded once, submitted once and waited for.

use super::barrier;
use super::buffer::Buffer;
use super::device::Device;
use super::error::{Context, Error, Result};
use super::image::Image;
use ash::vk;
use std::cell::Cell;
use std::marker::PhantomData;
use std::sync::Arc;

/// A command buffer being recorded. It may go to another thread, but two threads cannot record into it at once.
pub struct Commands {
    pub(super) raw: vk::CommandBuffer,
    /// The pool of this command buffer alone, lent by the device.
    pool: vk::CommandPool,
    /// The device it runs on.
    pub device: Arc<Device>,
    _not_sync: PhantomData<Cell<()>>,
}

impl Commands {
    /// Starts recording.
    ///
    /// # Errors
    /// [`Error::Call`] where the driver is out of memory.
    pub fn begin(device: &Arc<Device>) -> Result<Self> {
        let pool = device.borrow_command_pool()?;
        let mut commands =
            Self { raw: vk::CommandBuffer::null(), pool, device: device.clone(), _not_sync: PhantomData };
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool belongs to the device, and nothing else uses it until `drop` returns it.
        commands.raw = unsafe { device.raw.allocate_command_buffers(&info) }.during("allocating a command buffer")?[0];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is fresh.
        unsafe { device.raw.begin_command_buffer(commands.raw, &begin) }.during("beginning a command buffer")?;
        Ok(commands)
    }

    /// Submits and waits until the GPU is done, at most [`Device::time_limit`]. What it wrote is then visible to the CPU.
    ///
    /// # Errors
    /// [`Error::DeviceLost`] and [`Error::TimedOut`].
    pub fn finish(self) -> Result<()> {
        self.run("a submission")
    }

    /// The same; `content` names the submission in errors.
    pub(super) fn run(self, content: &str) -> Result<()> {
        barrier::to_host(&self);
        let device = &self.device.raw;
        // SAFETY: recording was begun, and nothing else uses the command buffer.
        unsafe { device.end_command_buffer(self.raw) }.during("ending a command buffer")?;
        // SAFETY: the device is alive.
        let fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }.during("creating a fence")?;
        let done = self.submit_and_wait(fence);
        if done == Err(vk::Result::TIMEOUT) {
            self.device.abandon();
        }
        // SAFETY: the fence has been waited for, or nothing was submitted.
        self.device.destroy(|raw| unsafe { raw.destroy_fence(fence, None) });
        done.map_err(|result| match result {
            vk::Result::TIMEOUT => {
                Error::TimedOut { content: content.into(), seconds: self.device.time_limit.as_secs_f64() }
            }
            vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost { content: content.into() },
            result => Error::Call { operation: "running a command buffer", result },
        })
    }

    fn submit_and_wait(&self, fence: vk::Fence) -> std::result::Result<(), vk::Result> {
        let buffers = [self.raw];
        let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
        let limit = u64::try_from(self.device.time_limit.as_nanos()).unwrap_or(u64::MAX);
        // SAFETY: the queue is locked during the call; fence and command buffer outlive the wait, or are abandoned.
        unsafe { self.device.raw.queue_submit(*self.device.queue(), &submit, fence) }?;
        // SAFETY: the fence was submitted.
        unsafe { self.device.raw.wait_for_fences(&[fence], true, limit) }
    }

    /// Copies the first `size` bytes of `from` to `to`.
    pub fn copy_buffer(&self, from: &Buffer, to: &Buffer, size: u64) {
        let region = vk::BufferCopy::default().size(size);
        // SAFETY: both buffers hold `size` bytes and outlive the submission.
        unsafe { self.device.raw.cmd_copy_buffer(self.raw, from.raw, to.raw, &[region]) };
    }

    /// Copies all texels of `from`, which is in `layout`, to the start of `to`.
    pub fn copy_image(&self, from: &Image, layout: vk::ImageLayout, to: &Buffer) {
        barrier::image_layout(self, from, layout, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        // SAFETY: the buffer holds all texels; both outlive the submission.
        unsafe { self.device.raw.cmd_copy_image_to_buffer(self.raw, from.raw, source, to.raw, &[from.whole()]) };
        barrier::image_layout(self, from, vk::ImageLayout::TRANSFER_SRC_OPTIMAL, layout);
    }

    /// Sets all texels of a colour image to zero, whatever it held, and puts it into the general layout.
    pub fn clear_image(&self, image: &Image) {
        let layout = vk::ImageLayout::GENERAL;
        barrier::image_layout(self, image, vk::ImageLayout::UNDEFINED, layout);
        let (zero, range) = (vk::ClearColorValue::default(), image.all_layers());
        // SAFETY: the image outlives the submission and is in this layout.
        unsafe { self.device.raw.cmd_clear_color_image(self.raw, image.raw, layout, &zero, &[range]) };
    }

    /// Fills all of `buffer` with `word`.
    pub fn fill(&self, buffer: &Buffer, word: u32) {
        // SAFETY: the buffer outlives the submission.
        unsafe { self.device.raw.cmd_fill_buffer(self.raw, buffer.raw, 0, vk::WHOLE_SIZE, word) };
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        self.device.return_command_pool(self.pool);
    }
}

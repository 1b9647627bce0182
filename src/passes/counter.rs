//! A count that shaders add to, for what a pass does and the CPU does not know (`glsl/inc/count.glsl`).

use crate::vk::{Buffer, Commands, Device, Memory, Result, barrier};
use std::sync::Arc;

/// A count of 64 bits.
pub struct Counter {
    buffer: Buffer,
    readback: Buffer,
}

impl Counter {
    const BYTES: u64 = 8;

    /// Undefined until [`Self::record_clear`].
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let buffer = |memory| Buffer::new(device, "work counts", Self::BYTES, memory);
        Ok(Self { buffer: buffer(Memory::Device)?, readback: buffer(Memory::Readback)? })
    }

    /// What shaders add to.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Starts from 0.
    pub fn record_clear(&self, commands: &Commands) {
        commands.fill(&self.buffer, 0);
    }

    /// One that starts from 0 already.
    pub fn cleared(device: &Arc<Device>) -> Result<Self> {
        let counter = Self::new(device)?;
        let commands = Commands::begin(device)?;
        counter.record_clear(&commands);
        commands.finish()?;
        Ok(counter)
    }

    /// Copies the count to the CPU.
    pub fn record_readback(&self, commands: &Commands) {
        barrier::full(commands);
        commands.copy_buffer(&self.buffer, &self.readback, Self::BYTES);
    }

    /// The count, once the submission with its read-back has been waited for.
    pub fn read(&self) -> u64 {
        let words: Vec<u32> = self.readback.read(2);
        u64::from(words[1]) << 32 | u64::from(words[0])
    }
}

//! Buffers: device-local ones for the passes, host-visible ones for what the CPU writes or reads.

use super::commands::Commands;
use super::device::Device;
use super::error::{Context, Error, Result};
use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Where a buffer lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// The GPU alone reads and writes it.
    Device,
    /// The CPU writes it.
    Upload,
    /// The CPU reads it.
    Readback,
}

/// A buffer and its memory.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    allocation: Option<Allocation>,
    /// Size in bytes; at least 4.
    pub size: u64,
    used_for: &'static str,
    device: Arc<Device>,
}

impl Buffer {
    /// A buffer of `size` bytes for storage, texel, transfer, vertex, index and indirect use.
    pub fn new(device: &Arc<Device>, used_for: &'static str, size: u64, memory: Memory) -> Result<Self> {
        let limit = u64::from(device.capabilities.limits.max_storage_buffer_range);
        if memory == Memory::Device && size > limit {
            return Err(Error::Limit {
                object: used_for.into(),
                needed: format!("a buffer of {size} bytes"),
                limit: format!("{limit} bytes (maxStorageBufferRange)"),
            });
        }
        Self::unlimited(device, used_for, size, memory)
    }

    /// The same beyond the limit of storage buffers, for other uses.
    pub(super) fn unlimited(device: &Arc<Device>, used_for: &'static str, size: u64, memory: Memory) -> Result<Self> {
        let size = size.max(16);
        let usage = match memory {
            Memory::Device => {
                vk::BufferUsageFlags::STORAGE_BUFFER
                    | vk::BufferUsageFlags::TRANSFER_DST
                    | vk::BufferUsageFlags::TRANSFER_SRC
                    | vk::BufferUsageFlags::VERTEX_BUFFER
                    | vk::BufferUsageFlags::INDEX_BUFFER
                    | vk::BufferUsageFlags::INDIRECT_BUFFER
                    | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
            }
            Memory::Upload => vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::STORAGE_BUFFER,
            Memory::Readback => vk::BufferUsageFlags::TRANSFER_DST,
        };
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is alive and `info` is complete.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.during("creating a buffer")?;
        let mut buffer = Self { raw, allocation: None, size, used_for, device: device.clone() };
        buffer.bind(memory)?;
        device.name(raw, used_for);
        Ok(buffer)
    }

    fn bind(&mut self, memory: Memory) -> Result<()> {
        // SAFETY: the buffer is alive.
        let requirements = unsafe { self.device.raw.get_buffer_memory_requirements(self.raw) };
        let description = AllocationCreateDesc {
            name: self.used_for,
            requirements,
            location: match memory {
                Memory::Device => MemoryLocation::GpuOnly,
                Memory::Upload => MemoryLocation::CpuToGpu,
                Memory::Readback => MemoryLocation::GpuToCpu,
            },
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = self.device.allocator().allocate(&description).map_err(|e| Error::Allocation {
            name: self.used_for.into(),
            bytes: self.size,
            reason: e.to_string(),
        })?;
        // SAFETY: the memory meets the buffer's requirements and is not bound elsewhere.
        unsafe { self.device.raw.bind_buffer_memory(self.raw, allocation.memory(), allocation.offset()) }
            .during("binding buffer memory")?;
        self.device.count_allocation(self.used_for, self.size);
        self.allocation = Some(allocation);
        Ok(())
    }

    /// A device buffer that holds `data`; waits for the copy.
    pub fn with_data<T: Pod>(device: &Arc<Device>, used_for: &'static str, data: &[T]) -> Result<Self> {
        let bytes = bytemuck::cast_slice::<T, u8>(data);
        let buffer = Self::new(device, used_for, bytes.len() as u64, Memory::Device)?;
        buffer.upload(data)?;
        Ok(buffer)
    }

    /// The same for vertices or indices that no pass reads as storage: only memory limits them.
    pub fn with_vertices<T: Pod>(device: &Arc<Device>, used_for: &'static str, data: &[T]) -> Result<Self> {
        let buffer = Self::unlimited(device, used_for, size_of_val(data) as u64, Memory::Device)?;
        buffer.upload(data)?;
        Ok(buffer)
    }

    /// Copies `data` to the start of this device buffer and waits; large data go in pieces, so that staging stays small.
    pub fn upload<T: Pod>(&self, data: &[T]) -> Result<()> {
        const PIECE: usize = 64 << 20;
        let bytes = bytemuck::cast_slice::<T, u8>(data);
        if bytes.is_empty() {
            return Ok(());
        }
        let mut staging = Self::new(&self.device, "staging", bytes.len().min(PIECE) as u64, Memory::Upload)?;
        for (index, piece) in bytes.chunks(PIECE).enumerate() {
            staging.write(piece);
            let commands = Commands::begin(&self.device)?;
            let region = vk::BufferCopy::default().dst_offset((index * PIECE) as u64).size(piece.len() as u64);
            // SAFETY: both buffers outlive the submission, which is waited for.
            unsafe { self.device.raw.cmd_copy_buffer(commands.raw, staging.raw, self.raw, &[region]) };
            commands.run(&format!("the upload of {}", self.used_for))?;
        }
        Ok(())
    }

    /// Writes `bytes` at the start of an upload buffer.
    pub fn write(&mut self, bytes: &[u8]) {
        let mapped = self.allocation.as_mut().and_then(|a| a.mapped_slice_mut()).expect("upload memory is mapped");
        mapped[..bytes.len()].copy_from_slice(bytes);
    }

    /// The first `count` values of a read-back buffer whose copy has been waited for.
    pub fn read<T: Pod>(&self, count: usize) -> Vec<T> {
        self.read_from(0, count)
    }

    /// `count` values from the `first`-th on.
    pub fn read_from<T: Pod>(&self, first: usize, count: usize) -> Vec<T> {
        let mapped = self.allocation.as_ref().and_then(|a| a.mapped_slice()).expect("read-back memory is mapped");
        bytemuck::pod_collect_to_vec(&mapped[first * size_of::<T>()..(first + count) * size_of::<T>()])
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: every submission that named the buffer has been waited for.
        self.device.destroy(|raw| unsafe { raw.destroy_buffer(self.raw, None) });
        if let Some(allocation) = self.allocation.take() {
            self.device.free(self.used_for, allocation, self.size);
        }
    }
}

//! What the texels of a batch of captures see: written by [`super::capture_compute`], or by [`super::integrate`] where render
//! passes capture; `glsl/inc/gathered.glsl`.

use crate::vk::{Buffer, Device, Memory, Result, TexelBuffer};
use std::sync::Arc;

/// What is kept of a texel besides the surfaces' radiance and 1/distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kinds {
    /// The sky's radiance.
    pub sky: bool,
    /// The plane of what is seen, for the translation gradient.
    pub planes: bool,
}

impl Kinds {
    /// Values of four floats a texel.
    pub fn stride(self) -> u32 {
        1 + u32::from(self.sky) + u32::from(self.planes)
    }
}

/// The buffer.
pub struct Gathered {
    memory: Kept,
    /// What is kept.
    pub kinds: Kinds,
}

enum Kept {
    Plain(Buffer),
    Viewed(TexelBuffer),
}

impl Gathered {
    const NAME: &str = "gathered radiance";

    /// Room for `texels` that passes read as storage.
    pub fn plain(device: &Arc<Device>, texels: u64, kinds: Kinds) -> Result<Self> {
        let memory = Kept::Plain(Buffer::new(device, Self::NAME, Self::bytes(texels, kinds), Memory::Device)?);
        Ok(Self { memory, kinds })
    }

    /// Room for `texels` that passes fetch through a view.
    pub fn viewed(device: &Arc<Device>, texels: u64, kinds: Kinds) -> Result<Self> {
        let memory = Kept::Viewed(TexelBuffer::new(device, Self::NAME, Self::bytes(texels, kinds))?);
        Ok(Self { memory, kinds })
    }

    /// Texels that a device lets passes fetch, at most.
    pub fn most_viewed(device: &Device, kinds: Kinds) -> u64 {
        let limits = &device.capabilities.limits;
        let values = u64::from(limits.max_texel_buffer_elements).min(u64::from(limits.max_storage_buffer_range) / 16);
        values / u64::from(kinds.stride())
    }

    /// The buffer as storage.
    pub fn buffer(&self) -> &Buffer {
        match &self.memory {
            Kept::Plain(buffer) => buffer,
            Kept::Viewed(texels) => &texels.buffer,
        }
    }

    /// The view of [`Self::viewed`].
    pub(super) fn view(&self) -> Option<&TexelBuffer> {
        match &self.memory {
            Kept::Plain(_) => None,
            Kept::Viewed(texels) => Some(texels),
        }
    }

    fn bytes(texels: u64, kinds: Kinds) -> u64 {
        texels * u64::from(kinds.stride()) * 16
    }
}

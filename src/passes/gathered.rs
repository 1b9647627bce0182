//! What the texels of a batch of captures see: written by [`super::capture_compute`], or by [`super::integrate`] where render
//! passes capture; `glsl/inc/gathered.glsl`. Of faces that are summed where they are rasterised, only what texels at their
//! borders see, and their sums.

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

    /// Sums over what a record sees (`glsl/inc/sums.glsl`).
    fn sums(self) -> u32 {
        let of_light = 19;
        of_light * (1 + u32::from(self.sky)) + 9 * u32::from(self.planes)
    }
}

/// The buffer.
pub struct Gathered {
    memory: Kept,
    /// What is kept.
    pub kinds: Kinds,
    /// Sums of faces, which make all else of the texels needless.
    pub sums: Option<FaceSums>,
}

/// Faces that were summed where they were rasterised.
pub struct FaceSums {
    /// 1/distance of each texel of the sides.
    pub distances: Buffer,
    /// Parts of each sum.
    pub parts: Buffer,
    /// How many parts a sum has.
    pub part_count: u32,
}

/// A hemicube that is summed face by face.
#[derive(Clone, Copy, Debug)]
pub struct FaceCounts {
    /// Texels of a record.
    pub texels: u32,
    /// Those at borders between faces.
    pub border: u32,
    /// Parts of each sum.
    pub parts: u32,
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
        Ok(Self { memory, kinds, sums: None })
    }

    /// Room for `records` that are summed.
    pub fn summed(device: &Arc<Device>, records: u32, of_each: FaceCounts, kinds: Kinds) -> Result<Self> {
        let room = |name, floats: u32| Buffer::new(device, name, u64::from(records * floats) * 4, Memory::Device);
        let sums = FaceSums {
            distances: room("capture distances", of_each.texels)?,
            parts: room("capture sums", of_each.parts * kinds.sums())?,
            part_count: of_each.parts,
        };
        let texels = if kinds.planes { u64::from(records * of_each.border) } else { 0 };
        Ok(Self { sums: Some(sums), ..Self::viewed(device, texels, kinds)? })
    }

    /// Room for `texels` that passes fetch through a view.
    pub fn viewed(device: &Arc<Device>, texels: u64, kinds: Kinds) -> Result<Self> {
        let memory = Kept::Viewed(TexelBuffer::new(device, Self::NAME, Self::bytes(texels, kinds))?);
        Ok(Self { memory, kinds, sums: None })
    }

    /// Texels that a device lets passes fetch, at most.
    pub fn most_viewed(device: &Device, kinds: Kinds) -> u64 {
        let limits = &device.capabilities.limits;
        let values = u64::from(limits.max_texel_buffer_elements).min(u64::from(limits.max_storage_buffer_range) / 16);
        values / u64::from(kinds.stride())
    }

    /// Records of so many `texels` that one buffer holds as storage, at most.
    pub fn most_plain(device: &Device, texels: u32, kinds: Kinds) -> u64 {
        u64::from(device.capabilities.limits.max_storage_buffer_range) / Self::bytes(texels.into(), kinds)
    }

    /// Records that are summed, at most: each of their buffers is within the device's limits.
    pub fn most_summed(device: &Device, of_each: FaceCounts, kinds: Kinds) -> u64 {
        let floats = of_each.texels.max(of_each.parts * kinds.sums());
        let stored = u64::from(device.capabilities.limits.max_storage_buffer_range) / 4 / u64::from(floats);
        stored.min(Self::most_viewed(device, kinds) / u64::from(of_each.border))
    }

    /// The buffer as storage.
    pub fn buffer(&self) -> &Buffer {
        match &self.memory {
            Kept::Plain(buffer) => buffer,
            Kept::Viewed(texels) => &texels.buffer,
        }
    }

    /// Where texels' 1/distance lies, and how many floats lie from one to the next (`SEEN_STRIDE` in `glsl/splat`).
    pub fn distances(&self) -> (&Buffer, u32) {
        self.sums.as_ref().map_or((self.buffer(), 4 * self.kinds.stride()), |sums| (&sums.distances, 1))
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

//! The background on the device, as `glsl/inc/sky.glsl` reads it.

use crate::scene::Background;
use crate::vk::{Buffer, Device, Result};
use std::sync::Arc;

/// Uploads the background's radiance: its size, then its texels.
pub fn upload_sky(device: &Arc<Device>, background: &Background) -> Result<Buffer> {
    let (width, height, texels): (u32, u32, Vec<[f32; 3]>) = match background {
        Background::Black => (1, 1, vec![[0.0; 3]]),
        Background::Constant(radiance) => (1, 1, vec![radiance.to_array()]),
        Background::Map(map) => (map.width, map.height, map.rgb.clone()),
    };
    let words = [width, height, 0, 0]
        .into_iter()
        .chain(texels.iter().flat_map(|[r, g, b]| [r.to_bits(), g.to_bits(), b.to_bits(), 0]));
    Buffer::with_data(device, "sky", &words.collect::<Vec<u32>>())
}

//! The background: on the device, as `glsl/inc/sky.glsl` reads it, and as parallel lights.
//!
//! Of a map, pixels show every texel; captures read the mean over what one of their texels sees; small bright regions light as
//! parallel lights of their own ([`split`]), pixels and surface cells alike; the rest of it lights the cells as a few more.

mod split;
mod warp;

use super::cascades::Cascades;
use super::light_set::LightSet;
use crate::math::sequence::fibonacci_sphere;
use crate::scene::{Background, EnvironmentMap};
use crate::vk::{Buffer, Device, Result};
use glam::Vec3;
use std::borrow::Cow;
use std::f32::consts::PI;
use std::sync::Arc;
use warp::{Region, SkySample, regions};

/// Texels a side of a shadow view of the sky.
pub const SKY_SHADOW_SIZE: u32 = 512;

/// Samples of the sky that a surface cell needs.
const SAMPLES_OF_CELL: u32 = 32;
/// Texels of the map that lights surface cells.
const OF_CELLS: [u32; 2] = [128, 64];

/// The background on the device.
pub struct Sky {
    seen: Buffer,
    captured: Option<Buffer>,
    /// What was done otherwise than the file says, for the user.
    pub note: Option<String>,
}

impl Sky {
    /// Uploads `background` for captures of `capture_size` texels a side; `lit` says whether its bright regions light as lights,
    /// so that captures leave them out.
    pub fn new(device: &Arc<Device>, background: &Background, capture_size: u32, lit: bool) -> Result<Self> {
        let Background::Map(map) = background else {
            let radiance = if let Background::Constant(radiance) = background { *radiance } else { Vec3::ZERO };
            let texel = EnvironmentMap { width: 1, height: 1, rgb: vec![radiance.to_array()] };
            return Ok(Self { seen: upload(device, &texel)?, captured: None, note: None });
        };
        let captured = captured(map, capture_size, lit).map(|map| upload(device, &map)).transpose()?;
        let (shown, note) = fitting(device, map);
        Ok(Self { seen: upload(device, &shown)?, captured, note })
    }

    /// What pixels show.
    pub fn seen(&self) -> &Buffer {
        &self.seen
    }

    /// What captures read.
    pub fn captured(&self) -> &Buffer {
        self.captured.as_ref().unwrap_or(&self.seen)
    }
}

/// Bytes of the device that a background takes.
pub fn sky_bytes(background: &Background) -> u64 {
    match background {
        Background::Black => 0,
        Background::Constant(_) => 32,
        Background::Map(map) => 16 * (1 + map.rgb.len() as u64),
    }
}

/// Whether some of the background's light is taken out as lights.
pub fn has_suns(background: &Background) -> bool {
    matches!(background, Background::Map(map) if split::threshold(&split::fine(map)).is_some())
}

/// The map for captures, where it is not the map itself: as many texels a quarter turn each way as a face of a hemicube has.
fn captured(map: &EnvironmentMap, capture_size: u32, lit: bool) -> Option<EnvironmentMap> {
    let size = [4 * capture_size, 2 * capture_size];
    let fine = split::fine(map);
    let limit = if lit { split::threshold(&fine) } else { None };
    let small = map.width <= size[0] && map.height <= size[1];
    (limit.is_some() || !small).then(|| split::reduced(&fine, size, limit.unwrap_or(f32::INFINITY)))
}

/// The map, or a smaller one where the device allows no such buffer.
fn fitting<'a>(device: &Device, map: &'a EnvironmentMap) -> (Cow<'a, EnvironmentMap>, Option<String>) {
    let capabilities = &device.capabilities;
    let most = u64::from(capabilities.limits.max_storage_buffer_range).min(capabilities.max_allocation) / 16 - 1;
    let halvings = (0..31).find(|by| u64::from(map.width >> by) * u64::from(map.height >> by) <= most).unwrap_or(31);
    if halvings == 0 {
        return (Cow::Borrowed(map), None);
    }
    let size @ [width, height] = [(map.width >> halvings).max(1), (map.height >> halvings).max(1)];
    let note = format!(
        "the background's {} × {} texels are above what this device allows one buffer: pixels show {width} × {height}",
        map.width, map.height
    );
    (Cow::Owned(split::reduced(map, size, f32::INFINITY)), Some(note))
}

/// Its size, then its texels.
fn upload(device: &Arc<Device>, map: &EnvironmentMap) -> Result<Buffer> {
    let texels = map.rgb.iter().flat_map(|[r, g, b]| [r.to_bits(), g.to_bits(), b.to_bits(), 0]);
    let words = [map.width, map.height, 0, 0].into_iter().chain(texels);
    Buffer::with_data(device, "sky", &words.collect::<Vec<u32>>())
}

/// Of how many samples of the sky a surface cell takes one, others than its neighbours do: captures see the mean of many.
pub(super) fn sky_stride(samples: usize) -> u32 {
    (samples as u32 / SAMPLES_OF_CELL).max(1)
}

/// Parallel lights for the surface cells: all of the sky but what [`add_suns`] takes.
pub(super) fn add_sky(background: &Background, cascades: &Cascades, count: u32, set: &mut LightSet) {
    match background {
        Background::Black => {}
        Background::Constant(radiance) => {
            for index in 0..count {
                let direction = fibonacci_sphere(index, count);
                let irradiance = *radiance * (4.0 * PI / count as f32);
                cascades.push(direction, irradiance, set);
            }
        }
        Background::Map(map) => {
            let fine = split::fine(map);
            let limit = split::threshold(&fine).unwrap_or(f32::INFINITY);
            let smooth = split::reduced(&fine, OF_CELLS, limit);
            let texels = texels(&smooth, |texel| texel);
            add(Region::new(texels).samples(&smooth, count), cascades, set);
        }
    }
}

/// The bright regions of a map as about `count` parallel lights. Each region has its share of them, and one at least; those
/// that are too weak for it are sampled together.
pub(super) fn add_suns(background: &Background, cascades: &Cascades, count: u32, set: &mut LightSet) {
    let Background::Map(map) = background else { return };
    let fine = split::fine(map);
    let Some(limit) = split::threshold(&fine) else { return };
    let bright = texels(&fine, |texel| split::split(texel, limit)[1]);
    let all: f32 = bright.iter().map(|(.., power)| power.max_element()).sum();
    let share = |region: &Region| count as f32 * region.power.max_element() / all;
    let (strong, weak): (Vec<_>, Vec<_>) = regions(&fine, bright).into_iter().partition(|r| share(r) >= 0.5);
    for region in strong.iter().chain(&Region::together(weak)) {
        add(region.samples(&fine, share(region).round().max(1.0) as u32), cascades, set);
    }
}

/// Rows, columns and radiance × solid angle of the texels that have light.
fn texels(map: &EnvironmentMap, light: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<(u32, u32, Vec3)> {
    let of = |(i, texel): (usize, &[f32; 3])| {
        let (row, column) = (i as u32 / map.width, i as u32 % map.width);
        let radiance = Vec3::from(light(*texel));
        (radiance != Vec3::ZERO).then(|| (row, column, (radiance.as_dvec3() * map.solid_angle(row)).as_vec3()))
    };
    map.rgb.iter().enumerate().filter_map(of).collect()
}

fn add(samples: Vec<SkySample>, cascades: &Cascades, set: &mut LightSet) {
    for SkySample { direction, irradiance } in samples {
        cascades.push(-direction, irradiance, set);
    }
}

//! The background: on the device, as `glsl/inc/sky.glsl` reads it, and as parallel lights for the surface cells.

use super::light_set::{Extent, LightSet, brightness, parallel_frame, parallel_sample};
use crate::math::sequence::fibonacci_sphere;
use crate::scene::{Background, EnvironmentMap};
use crate::vk::{Buffer, Device, Result};
use glam::Vec3;
use std::f32::consts::PI;
use std::sync::Arc;

/// Texels a side of a shadow view of the sky.
pub const SKY_SHADOW_SIZE: u32 = 512;

/// Samples of the sky that a surface cell needs.
const SAMPLES_OF_CELL: u32 = 32;

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

/// Of how many samples of the sky a surface cell takes one, others than its neighbours do: captures see the mean of many.
pub(super) fn sky_stride(samples: usize) -> u32 {
    (samples as u32 / SAMPLES_OF_CELL).max(1)
}

pub(super) fn add_sky(background: &Background, extent: Extent, count: u32, set: &mut LightSet) {
    match background {
        Background::Black => {}
        Background::Constant(radiance) => {
            for index in 0..count {
                let direction = fibonacci_sphere(index, count);
                let irradiance = *radiance * (4.0 * PI / count as f32);
                set.push(parallel_frame(direction, extent), parallel_sample(direction, irradiance));
            }
        }
        Background::Map(map) => add_sky_map(map, extent, count, set),
    }
}

/// Steps through the map's cumulated power: as many parallel lights, each of the same power.
fn add_sky_map(map: &EnvironmentMap, extent: Extent, count: u32, set: &mut LightSet) {
    let solid_angle = |row: u32| {
        let (top, bottom) = (f64::from(row) / f64::from(map.height), f64::from(row + 1) / f64::from(map.height));
        let pi = std::f64::consts::PI;
        ((top * pi).cos() - (bottom * pi).cos()) * 2.0 * pi / f64::from(map.width)
    };
    let power =
        |index: usize| f64::from(brightness(Vec3::from(map.rgb[index]))) * solid_angle(index as u32 / map.width);
    let total: f64 = (0..map.rgb.len()).map(power).sum();
    if total <= 0.0 {
        return;
    }
    let (mut texel, mut passed) = (0, 0.0);
    for index in 0..count {
        let target = (f64::from(index) + 0.5) / f64::from(count) * total;
        while texel + 1 < map.rgb.len() && passed + power(texel) <= target {
            passed += power(texel);
            texel += 1;
        }
        let (x, y) = (texel as u32 % map.width, texel as u32 / map.width);
        let uv = [(x as f32 + 0.5) / map.width as f32, (y as f32 + 0.5) / map.height as f32];
        let direction = -EnvironmentMap::uv_to_direction(uv);
        let weight = total / f64::from(count) / power(texel) * solid_angle(y);
        let irradiance = Vec3::from(map.rgb[texel]) * weight as f32;
        set.push(parallel_frame(direction, extent), parallel_sample(direction, irradiance));
    }
}

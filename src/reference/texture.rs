//! Texture lookups at level 0, as a magnification filter reads them.

use crate::scene::{Scene, Texture, TextureRef, Wrap};
use glam::{Vec2, Vec3, Vec4};
use std::sync::LazyLock;

/// How the stored bytes are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Colour by the sRGB curve, alpha linear.
    Srgb,
    /// All four channels linear.
    Linear,
}

/// IEC 61966-2-1: stored byte to linear value.
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let c = i as f64 / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

/// The texture's value at texture coordinates `uv` of the set it names, before its transform.
pub fn lookup(scene: &Scene, reference: TextureRef, uv: Vec2, encoding: Encoding) -> Vec4 {
    let texture = &scene.textures[reference.texture as usize];
    let uv = (reference.transform * Vec3::new(uv.x, uv.y, 1.0)).truncate();
    let size = Vec2::new(texture.width as f32, texture.height as f32);
    if texture.nearest {
        let texel = (uv * size).floor();
        return fetch(texture, texel.x as i64, texel.y as i64, encoding);
    }
    let place = uv * size - 0.5;
    let corner = place.floor();
    let f = place - corner;
    let (x, y) = (corner.x as i64, corner.y as i64);
    let row = |y| fetch(texture, x, y, encoding).lerp(fetch(texture, x + 1, y, encoding), f.x);
    row(y).lerp(row(y + 1), f.y)
}

fn fetch(texture: &Texture, x: i64, y: i64, encoding: Encoding) -> Vec4 {
    let x = wrap(x, texture.width, texture.wrap[0]);
    let y = wrap(y, texture.height, texture.wrap[1]);
    let rgba = texture.rgba[y * texture.width as usize + x];
    let linear = rgba.map(|c| f32::from(c) / 255.0);
    match encoding {
        Encoding::Linear => Vec4::from(linear),
        Encoding::Srgb => {
            let [r, g, b, _] = rgba.map(|c| SRGB[usize::from(c)]);
            Vec4::new(r, g, b, linear[3])
        }
    }
}

fn wrap(i: i64, size: u32, mode: Wrap) -> usize {
    let n = i64::from(size);
    let i = match mode {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::ClampToEdge => i.clamp(0, n - 1),
        Wrap::MirroredRepeat => {
            let j = i.rem_euclid(2 * n);
            if j < n { j } else { 2 * n - 1 - j }
        }
    };
    i as usize
}

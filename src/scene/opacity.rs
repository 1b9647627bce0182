//! Alpha masks as bits on the triangles, for what looks at triangles without their textures.
//!
//! A masked triangle is cut into n² equal ones, each with a bit: whether the surface is there (sub-triangle opacity masks,
//! Gruen, Benthin and Woop 2020). They are numbered as the cells of [`crate::math::cells`]. n follows the texture's texels, within a budget of 8 MiB.

use super::{Material, Part, Scene};
use crate::math::cells;
use glam::Vec2;
use rayon::prelude::*;
use std::collections::HashMap;

/// Bytes of all masks of a scene, at most.
const BUDGET: usize = 8 << 20;
/// Most pieces along a side. A capture has hardly more texels across a triangle, however fine the texture.
const FINEST: u32 = 64;
/// Fewest that a mask is made for; a triangle's own may be simpler.
const COARSEST: u32 = 8;
/// Pieces along a side where alpha comes from the vertices alone.
const BY_VERTICES: u32 = 32;
/// Words that a mask is a multiple of: a texel of a buffer.
pub const TEXEL_WORDS: usize = 4;

/// The mask of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mask {
    /// Pieces along a side, a power of two; 0 where the whole triangle is there.
    pub n: u32,
    /// First of its words, in units of [`TEXEL_WORDS`].
    pub first: u32,
}

/// Masks of a scene's triangles.
#[derive(Debug, Default)]
pub struct Opacity {
    /// By triangle.
    pub masks: Vec<Mask>,
    /// Bits of all masks, the lowest first.
    pub words: Vec<u32>,
}

/// What a triangle's mask follows from: those of one key share their bits.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    material: u32,
    uvs: [[u32; 2]; 3],
    alphas: [u32; 3],
}

/// Masked triangles before their bits are known.
#[derive(Default)]
struct Masked<'a> {
    distinct: Vec<Distinct<'a>>,
    /// Each masked triangle and its place in `distinct`.
    triangles: Vec<(usize, usize)>,
}

/// The first triangle of a key.
struct Distinct<'a> {
    material: &'a Material,
    vertices: [u32; 3],
    /// Longest side in texels, or what stands for it.
    detail: f32,
}

impl Scene {
    /// Why the masks of this scene cannot be held as bits, if so.
    pub fn too_many_masked(&self) -> Option<String> {
        let (count, most) = (self.masked(&self.triangles, &self.parts).distinct.len(), BUDGET / bytes(COARSEST));
        (count > most).then(|| format!("{count} triangles differ by their alpha masks, and {most} are held as bits"))
    }

    /// Masks of `triangles`, which `parts` give materials to.
    pub fn opacity(&self, triangles: &[[u32; 3]], parts: &[Part]) -> Opacity {
        let Masked { distinct, triangles: masked } = self.masked(triangles, parts);
        let finest = finest(&distinct);
        let mut words = vec![];
        let mut store = |(n, bits): (u32, Vec<u32>)| {
            let first = (words.len() / TEXEL_WORDS) as u32;
            words.extend(bits);
            Mask { n, first }
        };
        let baked: Vec<_> = distinct.par_iter().map(|d| self.bits(d, finest)).collect();
        let baked: Vec<_> = baked.into_iter().map(|bits| bits.map_or(Mask::default(), &mut store)).collect();
        let mut masks = vec![Mask::default(); triangles.len()];
        for (triangle, which) in masked {
            masks[triangle] = baked[which];
        }
        Opacity { masks, words }
    }

    fn masked(&self, triangles: &[[u32; 3]], parts: &[Part]) -> Masked<'_> {
        let mut masked = Masked::default();
        let mut places = HashMap::new();
        for part in parts.iter().filter(|part| self.is_masked(part)) {
            let material = &self.materials[part.material as usize];
            for triangle in part.triangles() {
                let vertices = triangles[triangle as usize];
                let place = *places.entry(self.key(part.material, vertices)).or_insert_with(|| {
                    masked.distinct.push(Distinct { material, vertices, detail: self.detail(material, vertices) });
                    masked.distinct.len() - 1
                });
                masked.triangles.push((triangle as usize, place));
            }
        }
        masked
    }

    fn key(&self, material: u32, vertices: [u32; 3]) -> Key {
        let reference = self.materials[material as usize].base_texture;
        let uv = |v: u32| reference.map_or(Vec2::ZERO, |r| self.uvs[r.set as usize][v as usize]);
        let bits = |v: u32| uv(v).to_array().map(f32::to_bits);
        Key { material, uvs: vertices.map(bits), alphas: vertices.map(|v| self.vertex_alpha(v).to_bits()) }
    }

    fn vertex_alpha(&self, vertex: u32) -> f32 {
        self.colors.get(vertex as usize).map_or(1.0, |c| c.w)
    }

    fn detail(&self, material: &Material, vertices: [u32; 3]) -> f32 {
        let [a, b, c] = vertices.map(|v| self.vertex_alpha(v));
        let by_vertices = if a == b && b == c { 0.0 } else { BY_VERTICES as f32 / 2.0 };
        let Some(reference) = material.base_texture else { return by_vertices };
        let texture = &self.textures[reference.texture as usize];
        let size = Vec2::new(texture.width as f32, texture.height as f32);
        let uvs = &self.uvs[reference.set as usize];
        let [a, b, c] = vertices.map(|v| reference.transform.transform_point2(uvs[v as usize]) * size);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        by_vertices.max(if longest.is_finite() { longest } else { 0.0 })
    }

    /// The bits of a triangle, cut into as many pieces as it needs; none where all of it is there.
    fn bits(&self, of: &Distinct<'_>, finest: u32) -> Option<(u32, Vec<u32>)> {
        let n = of.pieces(finest);
        let spread = of.detail > n as f32;
        let cutoff = of.material.alpha_cutoff.unwrap_or(0.0);
        let mut words = vec![0; bytes(n) / size_of::<u32>()];
        let mut present = 0;
        for piece in 0..n * n {
            let at = if spread {
                cells::point(n, piece, scattered(piece).as_dvec2()).as_vec2()
            } else {
                cells::centre(n, piece)
            };
            if self.alpha(of.material, of.vertices, at) >= cutoff {
                words[piece as usize / 32] |= 1 << (piece % 32);
                present += 1;
            }
        }
        (present < n * n).then_some((n, words))
    }
}

impl Distinct<'_> {
    /// Pieces along a side: two a texel, so that a texel's border is met well.
    fn pieces(&self, finest: u32) -> u32 {
        // The limit first: a power of two of anything finer may not exist.
        ((2.0 * self.detail).ceil().clamp(1.0, finest as f32) as u32).next_power_of_two()
    }
}

/// Most pieces along a side with which all masks stay within the budget.
fn finest(distinct: &[Distinct<'_>]) -> u32 {
    let fits = |finest: &u32| distinct.iter().map(|d| bytes(d.pieces(*finest))).sum::<usize>() <= BUDGET;
    (COARSEST.ilog2()..=FINEST.ilog2()).rev().map(|log| 1 << log).find(fits).unwrap_or(COARSEST)
}

/// Bytes of a mask of `n` pieces along a side.
fn bytes(n: u32) -> usize {
    ((n * n) as usize).div_ceil(32 * TEXEL_WORDS) * TEXEL_WORDS * size_of::<u32>()
}

/// A point of a triangle for each number, evenly spread over many (Roberts 2018): where pieces are wider than texels, a
/// regular grid of points would show a regular texture as something else, and these keep the share that is there.
fn scattered(number: u32) -> Vec2 {
    let p = (Vec2::splat(0.5) + number as f32 * Vec2::new(0.754_877_7, 0.569_840_3)).fract();
    if p.x + p.y > 1.0 { 1.0 - p } else { p }
}

#[cfg(test)]
#[path = "opacity_tests.rs"]
mod tests;

//! Emission that is not even over a triangle: by a texture, or where an alpha mask cuts the surface away.
//!
//! A triangle is cut in four again and again (Basu and Owen 2015, section 3), about as finely as its texels lie. Its pieces are
//! numbered so that pieces with near numbers lie near each other.

use super::{Material, Scene, TextureRef};
use glam::{DVec2, DVec3, Vec2, Vec3};

impl Scene {
    /// Whether a triangle's emission differs from place to place.
    pub fn emission_varies(&self, triangle: u32) -> bool {
        let material = &self.materials[self.material_of(triangle) as usize];
        material.emission_texture.is_some() || material.alpha_cutoff.is_some()
    }

    /// How often to cut a triangle in four, `most` times at the most, so that no side of a piece is longer than a texel.
    pub fn emission_level(&self, triangle: u32, most: u32) -> u32 {
        let material = &self.materials[self.material_of(triangle) as usize];
        let texels = self.emission_textures(material).map(|t| self.texels_along(triangle, t)).fold(0.0, f64::max);
        texels.max(1.0).log2().ceil().clamp(3.0, 16.0).min(f64::from(most)) as u32
    }

    /// Radiance that each of the 4^`level` pieces emits, W·sr⁻¹·m⁻²: at its centre; 0 where a mask cuts it away.
    pub fn emission_of_pieces(&self, triangle: u32, level: u32) -> Vec<Vec3> {
        use rayon::prelude::*;
        let radiance = |piece: u32| {
            let [a, b, c] = piece_corners(piece, level);
            let at = (a + b + c) / 3.0;
            let at = Vec2::new(at.y as f32, at.z as f32);
            if self.is_present(triangle, at) { self.surface_emission(triangle, at) } else { Vec3::ZERO }
        };
        (0..1u32 << (2 * level)).into_par_iter().map(radiance).collect()
    }

    fn emission_textures<'a>(&self, material: &'a Material) -> impl Iterator<Item = &'a TextureRef> {
        let mask = material.base_texture.as_ref().filter(|_| material.alpha_cutoff.is_some());
        material.emission_texture.iter().chain(mask)
    }

    /// Most texels along a side of the triangle, in rows or in columns.
    fn texels_along(&self, triangle: u32, texture: &TextureRef) -> f64 {
        let uvs = &self.uvs[texture.set as usize];
        let size = &self.textures[texture.texture as usize];
        let size = DVec2::new(f64::from(size.width), f64::from(size.height));
        let corner = |v: u32| texture.transform.transform_point2(uvs[v as usize]).as_dvec2() * size;
        let [a, b, c] = self.triangles[triangle as usize].map(corner);
        let texels = [b - a, c - b, a - c].map(|side| side.abs().max_element()).into_iter().fold(0.0, f64::max);
        if texels.is_finite() { texels } else { 0.0 }
    }
}

/// Corners of a piece, as weights of the triangle's three vertices.
pub fn piece_corners(piece: u32, level: u32) -> [DVec3; 3] {
    let [mut a, mut b, mut c] = [DVec3::X, DVec3::Y, DVec3::Z];
    for depth in (0..level).rev() {
        let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
        [a, b, c] = match piece >> (2 * depth) & 3 {
            0 => [bc, ca, ab],
            1 => [a, ab, ca],
            2 => [ab, b, bc],
            _ => [ca, bc, c],
        };
    }
    [a, b, c]
}

/// The piece that holds a point of the triangle, by the weights of its vertices.
pub fn piece_at(weights: DVec3, level: u32) -> u32 {
    let (mut w, mut piece) = (weights, 0);
    for _ in 0..level {
        let child = (0..3).find(|i| w[*i] > 0.5);
        piece = piece << 2 | child.map_or(0, |i| i as u32 + 1);
        // Weights of the child's corners: a corner's own counts twice, of the middle one each is what is left.
        w = match child {
            Some(i) => 2.0 * w - DVec3::AXES[i],
            None => 1.0 - 2.0 * w,
        };
    }
    piece
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::build::{Builder, emitter};

    /// One lit column of a texture of any shape gives its share of the light of a square.
    #[test]
    fn textures_of_any_shape_keep_their_energy() {
        for (width, height) in [(4, 4), (64, 4), (32, 2), (256, 1), (2, 128)] {
            let mut b = Builder::default();
            let lit = |i: u32| if i % width == width / 2 { [255; 4] } else { [0, 0, 0, 255] };
            let texture = b.texture(width, height, (0..width * height).map(lit).collect(), true);
            let map = TextureRef { texture, set: 0, transform: glam::Mat3::IDENTITY };
            let material = b.material(Material { emission_texture: Some(map), ..emitter(Vec3::ONE) });
            b.quad(material, Vec3::ZERO, Vec3::X, Vec3::Y);
            let scene = b.build();
            let mean = (0..2).map(|t| scene.emission_of_pieces(t, scene.emission_level(t, 16)));
            let mean: f32 = mean.map(|pieces| pieces.iter().map(|p| p.x).sum::<f32>() / pieces.len() as f32).sum();
            let share = 0.5 * mean * width as f32;
            assert!((share - 1.0).abs() < 0.02, "{width} × {height}: {share}");
        }
    }

    #[test]
    fn pieces_are_found_by_their_points() {
        for level in 0..5 {
            for piece in 0..1 << (2 * level) {
                let [a, b, c] = piece_corners(piece, level);
                for [u, v, w] in [[0.4, 0.3, 0.3], [0.9, 0.05, 0.05], [0.05, 0.05, 0.9]] {
                    assert_eq!(piece_at(a * u + b * v + c * w, level), piece);
                }
            }
        }
    }
}

//! A scene whose surfaces reflect everything, for irradiance in place of reflected light.

use super::{Material, Scene, Texture};

impl Scene {
    /// The same surface of albedo 1, which emits nothing; what masks leave out stays out.
    pub(crate) fn whitened(&self) -> Self {
        let mut white = self.clone();
        white.colors.iter_mut().for_each(|color| *color = color.with_x(1.0).with_y(1.0).with_z(1.0));
        for material in &mut white.materials {
            whiten(material, &mut white.textures);
        }
        white
    }
}

fn whiten(material: &mut Material, textures: &mut Vec<Texture>) {
    material.base_color = material.base_color.with_x(1.0).with_y(1.0).with_z(1.0);
    material.emission = glam::Vec3::ZERO;
    material.emission_texture = None;
    let mask = material.base_texture.take().filter(|_| material.alpha_cutoff.is_some());
    material.base_texture = mask.map(|mut used| {
        let mut texture = textures[used.texture as usize].clone();
        texture.rgba.iter_mut().for_each(|texel| *texel = [255, 255, 255, texel[3]]);
        used.texture = textures.len() as u32;
        textures.push(texture);
        used
    });
}

#[cfg(test)]
mod tests {
    use super::super::build::{Builder, diffuse};
    use super::super::{Material, TextureRef};
    use glam::{Mat3, Vec2, Vec3};

    #[test]
    fn white_surfaces_keep_their_masks() {
        let mut b = Builder::default();
        let texture = b.texture(2, 1, vec![[10, 20, 30, 0], [40, 50, 60, 255]], true);
        let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
        let masked = b.material(Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.3) });
        b.quad(masked, Vec3::ZERO, Vec3::X, Vec3::Y);
        let scene = b.build();
        let white = scene.whitened();
        let at = |u: f32| white.albedo_at(0, white.triangles[0], Vec2::new(u, 0.0));
        assert_eq!(at(0.25), None);
        assert_eq!(at(0.75), Some(Vec3::ONE));
        assert_eq!(scene.textures.len(), 1);
    }
}

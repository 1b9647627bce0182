//! A number that tells scenes apart, for files that say what they were made of.

use super::{Background, Lens, Scene};
use std::fmt::Write;

impl Scene {
    /// A hash of geometry, materials, textures, lights and parts as they were loaded: the same scene has the same one on every
    /// machine. FNV-1a (Fowler, Noll and Vo 1991) of 64 bits over words of 32 bits, which is not safe against forgery.
    pub fn fingerprint(&self) -> u64 {
        Fnv::of(|hash| self.hash_all(hash))
    }

    fn hash_all(&self, hash: &mut Fnv) {
        hash.words(bytemuck::cast_slice(&self.positions));
        hash.words(bytemuck::cast_slice(&self.normals));
        self.uvs.iter().for_each(|set| hash.words(bytemuck::cast_slice(set)));
        hash.words(bytemuck::cast_slice(&self.colors));
        hash.words(bytemuck::cast_slice(&self.triangles));
        for texture in &self.textures {
            texture.rgba.iter().for_each(|texel| hash.word(u32::from_le_bytes(*texel)));
        }
        let _ = write!(hash, "{:?} {:?} {:?} {:?}", self.origin, self.parts, self.materials, self.lights);
    }
}

impl Scene {
    /// Hashes of all that the light on its surfaces depends on, each with its name. Of cameras their places count, near which the
    /// surface is lit more finely.
    pub fn fingerprints(&self) -> [(&'static str, u64); 5] {
        [
            ("geometry", Fnv::of(|hash| self.hash_geometry(hash))),
            ("material", Fnv::of(|hash| self.hash_materials(hash))),
            (
                "light",
                Fnv::of(|hash| {
                    let _ = write!(hash, "{:?}", self.lights);
                }),
            ),
            ("background", Fnv::of(|hash| self.hash_background(hash))),
            ("place of a camera", Fnv::of(|hash| self.hash_cameras(hash))),
        ]
    }

    fn hash_geometry(&self, hash: &mut Fnv) {
        hash.words(bytemuck::cast_slice(&self.positions));
        hash.words(bytemuck::cast_slice(&self.normals));
        hash.words(bytemuck::cast_slice(&self.tangents));
        self.uvs.iter().for_each(|set| hash.words(bytemuck::cast_slice(set)));
        hash.words(bytemuck::cast_slice(&self.colors));
        hash.words(bytemuck::cast_slice(&self.triangles));
        let _ = write!(hash, "{:?} {:?}", self.origin, self.parts);
    }

    fn hash_materials(&self, hash: &mut Fnv) {
        for texture in &self.textures {
            texture.rgba.iter().for_each(|texel| hash.word(u32::from_le_bytes(*texel)));
            let _ = write!(hash, "{} {} {:?} {}", texture.width, texture.height, texture.wrap, texture.nearest);
        }
        let _ = write!(hash, "{:?}", self.materials);
    }

    fn hash_background(&self, hash: &mut Fnv) {
        if let Background::Map(map) = &self.background {
            hash.words(bytemuck::cast_slice(&map.rgb));
            let _ = write!(hash, "{} {}", map.width, map.height);
        } else {
            let _ = write!(hash, "{:?}", self.background);
        }
    }

    fn hash_cameras(&self, hash: &mut Fnv) {
        for camera in self.cameras.iter().filter(|camera| matches!(camera.lens, Lens::Perspective { .. })) {
            let _ = write!(hash, "{:?}", camera.camera_to_world.w_axis);
        }
    }
}

struct Fnv(u64);

impl Fnv {
    fn of(add: impl FnOnce(&mut Self)) -> u64 {
        let mut hash = Self(0xcbf2_9ce4_8422_2325);
        add(&mut hash);
        hash.0
    }

    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3);
    }

    /// The number of words counts, so that none moves unnoticed from one array to the next.
    fn words(&mut self, words: &[u32]) {
        words.iter().for_each(|word| self.word(*word));
        self.word(words.len() as u32);
    }
}

impl Write for Fnv {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        text.bytes().for_each(|byte| self.word(byte.into()));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::cornell;

    #[test]
    fn scenes_that_differ_anywhere_have_other_fingerprints() {
        let scene = cornell();
        let same = scene.fingerprint();
        assert_eq!(cornell().fingerprint(), same);
        let mut moved = cornell();
        moved.positions[3].y += 1e-6;
        let mut painted = cornell();
        painted.materials[0].base_color.x *= 0.5;
        let mut turned = cornell();
        turned.triangles[5].rotate_left(1);
        for other in [moved, painted, turned] {
            assert_ne!(other.fingerprint(), same);
        }
    }

    #[test]
    fn the_part_that_differs_has_another_fingerprint_and_no_other_part() {
        let scene = cornell();
        let changed = |change: &dyn Fn(&mut super::Scene)| {
            let mut other = cornell();
            change(&mut other);
            let pairs = scene.fingerprints().into_iter().zip(other.fingerprints());
            pairs.filter(|(a, b)| a != b).map(|((name, _), _)| name).collect::<Vec<_>>()
        };
        assert!(changed(&|_| ()).is_empty());
        assert_eq!(changed(&|scene| scene.positions[3].y += 1e-6), ["geometry"]);
        assert_eq!(changed(&|scene| scene.materials[0].base_color.x *= 0.5), ["material"]);
        assert_eq!(changed(&|scene| scene.materials[0].emission.x += 1.0), ["material"]);
        assert_eq!(changed(&|scene| scene.background = super::Background::Constant(glam::Vec3::ONE)), ["background"]);
        assert_eq!(changed(&|scene| scene.cameras[0].camera_to_world.w_axis.x += 0.1), ["place of a camera"]);
        let light = super::super::Light::Point { position: glam::Vec3::ZERO, intensity: glam::Vec3::ONE };
        assert_eq!(changed(&|scene| scene.lights.push(light)), ["light"]);
    }
}

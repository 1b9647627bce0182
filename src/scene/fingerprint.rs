//! A number that tells scenes apart, for files that say what they were made of.

use super::Scene;
use std::fmt::Write;

impl Scene {
    /// A hash of geometry, materials, textures, lights and parts as they were loaded: the same scene has the same one on every
    /// machine. FNV-1a (Fowler, Noll and Vo 1991) of 64 bits over words of 32 bits, which is not safe against forgery.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
        hash.words(bytemuck::cast_slice(&self.positions));
        hash.words(bytemuck::cast_slice(&self.normals));
        self.uvs.iter().for_each(|set| hash.words(bytemuck::cast_slice(set)));
        hash.words(bytemuck::cast_slice(&self.colors));
        hash.words(bytemuck::cast_slice(&self.triangles));
        for texture in &self.textures {
            texture.rgba.iter().for_each(|texel| hash.word(u32::from_le_bytes(*texel)));
        }
        let _ = write!(hash, "{:?} {:?} {:?} {:?}", self.origin, self.parts, self.materials, self.lights);
        hash.0
    }
}

struct Fnv(u64);

impl Fnv {
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
}

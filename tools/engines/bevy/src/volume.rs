//! The irradiance volume's file, read without Bevy: what Bevy should show.

use bevy::math::{UVec3, Vec3};

/// A texture of E5B9G9R9 texels, and the transform in its metadata.
pub struct Volume {
    /// Samples along each axis.
    pub counts: UVec3,
    /// Translation of the transform.
    pub translation: Vec3,
    /// Scale of the transform.
    pub scale: Vec3,
    texels: Vec<Vec3>,
}

impl Volume {
    /// Reads a KTX2 file.
    pub fn read(path: &str) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        assert_eq!(word(12), 123, "the format is not E5B9G9R9");
        let (begin, length) = (word(80) as usize, word(88) as usize);
        let texels = (0..length / 4).map(|i| decoded(word(begin + 4 * i))).collect();
        let counts = UVec3::new(word(20), word(24) / 2, word(28) / 3);
        let [translation, scale] = ["hemicubeTranslation", "hemicubeScale"].map(|key| metadata(&bytes, key));
        Self { counts, translation, scale, texels }
    }

    /// Radiance of a white surface, E/π, by Bevy's rule.
    pub fn radiance(&self, position: Vec3, n: Vec3) -> Vec3 {
        let counts = self.counts.as_vec3();
        let at = ((position - self.translation) / self.scale + 0.5) * counts - 0.5;
        let at = at.clamp(Vec3::ZERO, counts - 1.0);
        (0..3)
            .map(|axis| {
                let sign = u32::from(n[axis] < 0.0);
                let corner = UVec3::new(0, sign * self.counts.y, axis as u32 * self.counts.z);
                n[axis] * n[axis] * self.between(at, corner)
            })
            .sum()
    }

    fn between(&self, at: Vec3, corner: UVec3) -> Vec3 {
        let low = at.floor().min(self.counts.as_vec3() - 2.0).max(Vec3::ZERO);
        let t = at - low;
        let mut sum = Vec3::ZERO;
        for i in 0..8_u32 {
            let upper = UVec3::new(i & 1, i >> 1 & 1, i >> 2 & 1);
            let weights = (0..3).map(|axis| if upper[axis] == 1 { t[axis] } else { 1.0 - t[axis] });
            sum += weights.product::<f32>() * self.texel(low.as_uvec3() + upper + corner);
        }
        sum
    }

    fn texel(&self, at: UVec3) -> Vec3 {
        let (width, height) = (self.counts.x, 2 * self.counts.y);
        self.texels[(at.x + width * (at.y + height * at.z)) as usize]
    }
}

fn decoded(code: u32) -> Vec3 {
    let step = ((code >> 27) as f32 - 24.0).exp2();
    Vec3::from([0, 9, 18].map(|shift| (code >> shift & 511) as f32 * step))
}

/// Three numbers behind a key of the file's metadata.
fn metadata(bytes: &[u8], key: &str) -> Vec3 {
    let key = [key.as_bytes(), b"\0"].concat();
    let begin = bytes.windows(key.len()).position(|window| window == key).expect("the key") + key.len();
    let end = begin + bytes[begin..].iter().position(|byte| *byte == 0).expect("the end of the value");
    let text = std::str::from_utf8(&bytes[begin..end]).expect("a text");
    let numbers: Vec<f32> = text.split(' ').map(|number| number.parse().expect("a number")).collect();
    Vec3::from_slice(&numbers)
}

//! A path-traced image under way as a file, to go on with later.

use super::film::{SUMS_LEN, Sums};
use super::progressive::Progressive;
use crate::image::write::{WriteError, write_atomic};
use crate::scene::{Background, Scene};
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;

const MAGIC: &[u8; 8] = b"hemiref1";

/// A state that cannot be gone on with.
#[derive(Debug, Error)]
pub enum StateError {
    /// The file cannot be read.
    #[error("cannot read the state {path:?}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        cause: std::io::Error,
    },
    /// The file is something else, or cut off.
    #[error("{path:?} is not a state that --resume wrote, or is damaged; delete it to start anew")]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// The state belongs to another image.
    #[error("the state {path:?} is of another scene, view, seed or number of bounces; name another file or delete it")]
    Other {
        /// The file.
        path: PathBuf,
    },
}

impl Progressive<'_, '_> {
    /// Writes the state: complete, or not at all.
    pub fn save(&self, path: &Path) -> Result<(), WriteError> {
        write_atomic(path, |sink| {
            sink.write_all(MAGIC)?;
            sink.write_all(&self.fingerprint().to_le_bytes())?;
            sink.write_all(&self.settings.batch.to_le_bytes())?;
            sink.write_all(&self.batches.to_le_bytes())?;
            for sums in &self.sums {
                let bytes: Vec<u8> = sums.to_array().into_iter().flat_map(f64::to_le_bytes).collect();
                sink.write_all(&bytes)?;
            }
            Ok(())
        })
    }

    /// Goes on from a state that [`Progressive::save`] wrote for the same scene, view and settings; its batch size is
    /// taken over.
    pub fn load(&mut self, path: &Path) -> Result<(), StateError> {
        let read = || {
            let mut bytes = vec![];
            std::fs::File::open(path)?.read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let bytes = read().map_err(|cause| StateError::Read { path: path.to_owned(), cause })?;
        let (head, body) = bytes.split_at_checked(24).unwrap_or_default();
        if !head.starts_with(MAGIC) {
            return Err(StateError::Damaged { path: path.to_owned() });
        }
        if head[8..16] != self.fingerprint().to_le_bytes() {
            return Err(StateError::Other { path: path.to_owned() });
        }
        let word = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
        let (batch, batches) = (word(16), word(20));
        let numbers: Vec<f64> = body.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        let sound = body.len() == self.sums.len() * SUMS_LEN * 8 && numbers.iter().all(|x| x.is_finite());
        if !sound || !batch.is_power_of_two() {
            return Err(StateError::Damaged { path: path.to_owned() });
        }
        self.sums = numbers.as_chunks::<SUMS_LEN>().0.iter().map(Sums::from_array).collect();
        (self.settings.batch, self.batches) = (batch, batches);
        Ok(())
    }

    /// A number that differs for anything that the sums depend on, the batch size left out.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = Fnv::default();
        hash.scene(self.tracer.scene);
        hash.text(&format!("{:?} {} {}", self.view, self.settings.bounces, self.settings.seed));
        hash.0
    }
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo): the same on every machine and for every version of the compiler.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    fn scene(&mut self, scene: &Scene) {
        self.bytes(bytemuck::cast_slice(&scene.positions));
        self.bytes(bytemuck::cast_slice(&scene.normals));
        self.bytes(bytemuck::cast_slice(&scene.triangles));
        scene.textures.iter().for_each(|texture| self.bytes(bytemuck::cast_slice(&texture.rgba)));
        self.text(&format!("{:?} {:?} {:?} {}", scene.parts, scene.materials, scene.lights, scene.origin));
        match &scene.background {
            Background::Map(map) => self.bytes(bytemuck::cast_slice(&map.rgb)),
            plain => self.text(&format!("{plain:?}")),
        }
    }
}

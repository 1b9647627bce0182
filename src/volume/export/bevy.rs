//! Bevy's `IrradianceVolume`: a 3D texture in KTX2.
//!
//! R samples along each axis make a texture of Rx × 2Ry × 3Rz texels. The face of axis a (x, y, z: 0, 1, 2) and sign s (+, −: 0, 1) of
//! sample (x, y, z) is texel (x, y + s·Ry, z + a·Rz). Bevy's shader reads it so; Bevy's documentation has the signs the other way
//! round. The transform's cube is cut into a voxel a sample with the sample in its middle, so it is one spacing longer than the grid.

use super::{Grid, measures, rgb9e5};
use glam::DVec3;

const IDENTIFIER: [u8; 12] = [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'];
/// `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`.
const FORMAT: u32 = 123;
/// Bytes before the data format descriptor: identifier, header, index, one level.
const HEAD: u32 = 12 + 9 * 4 + 4 * 4 + 2 * 8 + 3 * 8;

/// Translation and scale of the transform of the entity with the `LightProbe`.
pub fn transform(grid: &Grid) -> [DVec3; 2] {
    let counts = grid.counts.as_dvec3();
    [grid.low + 0.5 * (counts - 1.0) * grid.spacing, counts * grid.spacing]
}

/// The texels in shared exponents, row by row, slice by slice.
pub fn texels(grid: &Grid) -> Vec<u32> {
    let n = grid.counts.as_usizevec3();
    let mut texels = vec![0; 6 * grid.lights.len()];
    for (i, light) in grid.lights.iter().enumerate() {
        let (x, y, z) = (i % n.x, i / n.x % n.y, i / n.x / n.y);
        for (face, value) in measures::bevy(light).into_iter().enumerate() {
            let (axis, sign) = (face / 2, face % 2);
            let at = x + n.x * (y + sign * n.y + 2 * n.y * (z + axis * n.z));
            texels[at] = rgb9e5::encode(value);
        }
    }
    texels
}

/// The KTX2 file.
pub fn file(grid: &Grid) -> Vec<u8> {
    let descriptor = descriptor();
    let notes = notes(grid);
    let texels = texels(grid);
    let (of_descriptor, of_notes) = (descriptor.len() as u32 * 4, notes.len() as u32);
    let data = (HEAD + of_descriptor + of_notes).next_multiple_of(8);
    let size = grid.counts;
    let mut file = IDENTIFIER.to_vec();
    let mut words = |words: &[u32]| words.iter().for_each(|word| file.extend(word.to_le_bytes()));
    // Format, size of a word, width, height, depth, layers, faces, levels, no supercompression.
    words(&[FORMAT, 4, size.x, 2 * size.y, 3 * size.z, 0, 1, 1, 0]);
    words(&[HEAD, of_descriptor, HEAD + of_descriptor, of_notes, 0, 0, 0, 0]);
    let bytes = texels.len() as u32 * 4;
    words(&[data, 0, bytes, 0, bytes, 0]);
    words(&descriptor);
    file.extend(notes);
    file.resize(data as usize, 0);
    texels.iter().for_each(|texel| file.extend(texel.to_le_bytes()));
    file
}

/// Khronos' basic data format descriptor, version 1.3 (KDF 1.3, 5): linear Rec. 709, a mantissa and the exponent of each channel.
fn descriptor() -> Vec<u32> {
    const SAMPLES: u32 = 6;
    let size = 24 + 16 * SAMPLES;
    let mut words = vec![size + 4, 0, 2 | (size << 16), 1 | (1 << 8) | (1 << 16), 0, 4, 0];
    for channel in 0..3 {
        let mantissa = [(9 * channel) | (8 << 16) | (channel << 24), 0, 0, 8448];
        let exponent = [27 | (4 << 16) | ((channel | 0x20) << 24), 0, 15, 31];
        words.extend(mantissa.into_iter().chain(exponent));
    }
    words
}

/// Keys and values: the writer, and the volume's transform.
fn notes(grid: &Grid) -> Vec<u8> {
    let [translation, scale] = transform(grid);
    let list = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let mut bytes = Vec::new();
    for (key, value) in [
        ("KTXwriter", format!("hemicube {}", env!("CARGO_PKG_VERSION"))),
        ("hemicubeScale", list(scale)),
        ("hemicubeTranslation", list(translation)),
    ] {
        let pair = [key.as_bytes(), b"\0", value.as_bytes(), b"\0"].concat();
        bytes.extend((pair.len() as u32).to_le_bytes());
        bytes.extend(pair);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

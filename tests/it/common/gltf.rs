//! Small glTF files made in code.

use serde_json::{Value, json};

/// A triangle mesh as one self-contained .gltf document; `change` edits it before it is returned.
pub fn document(positions: &[[f32; 3]], indices: &[u32], change: impl FnOnce(&mut Value)) -> Value {
    let mut data: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let split = data.len();
    data.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let mut document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "Node", "mesh": 0}],
        "meshes": [{"name": "Mesh", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": split},
            {"buffer": 0, "byteOffset": split, "byteLength": data.len() - split},
        ],
        "buffers": [{"byteLength": data.len(), "uri": data_uri(&data)}],
    });
    change(&mut document);
    document
}

/// The unit right triangle in the xy plane, facing +z.
pub fn triangle(change: impl FnOnce(&mut Value)) -> Value {
    document(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2], change)
}

/// Bytes as a data URI.
pub fn data_uri(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::from("data:application/octet-stream;base64,");
    for group in bytes.chunks(3) {
        let word = group.iter().chain(&[0, 0]).take(3).fold(0u32, |word, byte| word << 8 | u32::from(*byte));
        for digit in 0..4 {
            let known = digit <= group.len();
            text.push(if known { DIGITS[(word >> (18 - 6 * digit) & 63) as usize] as char } else { '=' });
        }
    }
    text
}

/// A document and a binary chunk as a GLB file.
pub fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(document).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut chunks = Vec::new();
    for (kind, data) in [(b"JSON", &text[..]), (b"BIN\0", binary)] {
        chunks.extend((data.len() as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(data);
    }
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((chunks.len() as u32 + 12).to_le_bytes());
    file.extend(chunks);
    file
}

//! Small files made in code, one feature each.

mod attributes;
mod compressed;
mod containers;
mod lights;
mod materials;
mod placement;
mod pose;
mod tolerance;
mod triangles;

use super::*;
use crate::scene::{Texture, TextureRef};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// A file in the making: a document and its one buffer.
struct File {
    document: Value,
    data: Vec<u8>,
}

const F32: u32 = 5126;
const U16: u32 = 5123;

impl File {
    /// One node with one mesh of one primitive that has no attributes yet.
    fn new() -> Self {
        let document = json!({
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {}}]}],
            "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        Self { document, data: Vec::new() }
    }

    /// The unit right triangle in the xy plane, facing +z.
    fn triangle() -> Self {
        Self::new().attribute("POSITION", &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    fn push(&mut self, list: &str, item: Value) -> usize {
        if self.document.get(list).is_none() {
            self.document[list] = json!([]);
        }
        let items = self.document[list].as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    /// A view of its own for `bytes`.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.data.len();
        self.data.extend_from_slice(bytes);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// An accessor of `count` elements over all of `bytes`.
    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "count": count, "type": kind}))
    }

    /// A float accessor.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.accessor(bytemuck::cast_slice(values.as_flattened()), F32, values.len(), kind)
    }

    fn attribute<const N: usize>(mut self, name: &str, values: &[[f32; N]]) -> Self {
        let accessor = self.floats(values);
        self.primitive()["attributes"][name] = json!(accessor);
        self
    }

    fn indices(mut self, indices: &[u16]) -> Self {
        let accessor = self.accessor(bytemuck::cast_slice(indices), U16, indices.len(), "SCALAR");
        self.primitive()["indices"] = json!(accessor);
        self
    }

    /// Sets what a JSON pointer names.
    fn set(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match self.document.pointer_mut(parent).unwrap() {
            Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
            other => other[key] = value,
        }
        self
    }

    fn material(mut self, material: Value) -> Self {
        let index = self.push("materials", material);
        self.primitive()["material"] = json!(index);
        self
    }

    /// A 2 × 2 PNG texture in a buffer view.
    fn texture(mut self, texels: [[u8; 4]; 4]) -> Self {
        let mut png = std::io::Cursor::new(Vec::new());
        let image = image::RgbaImage::from_raw(2, 2, texels.as_flattened().to_vec()).unwrap();
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let view = self.view(png.get_ref());
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}));
        self
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.document["meshes"][0]["primitives"][0]
    }

    /// The file as a GLB.
    fn glb(&self) -> Vec<u8> {
        let mut document = self.document.clone();
        document["buffers"][0]["byteLength"] = json!(self.data.len());
        let mut text = serde_json::to_vec(&document).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() + 8 + self.data.len();
        let mut glb = b"glTF".to_vec();
        for word in [2, total as u32, text.len() as u32, 0x4E4F_534A] {
            glb.extend(word.to_le_bytes());
        }
        glb.extend(text);
        for word in [self.data.len() as u32, 0x004E_4942] {
            glb.extend(word.to_le_bytes());
        }
        glb.extend(&self.data);
        glb
    }

    /// Loads the file; keeps it as a seed where `HEMICUBE_SEEDS` names a folder for the fuzzer.
    fn try_load(&self) -> std::result::Result<Scene, SceneError> {
        let glb = self.glb();
        if let Some(folder) = std::env::var_os("HEMICUBE_SEEDS") {
            let hash = glb.iter().fold(0u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01B3));
            std::fs::write(Path::new(&folder).join(format!("{hash:016x}.glb")), &glb).unwrap();
        }
        load_from_slice("test.glb", &glb, &no_files, Limits::default())
    }

    fn load(&self) -> Scene {
        self.try_load().unwrap_or_else(|e| panic!("{e}"))
    }
}

fn no_files(_: &str) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::NotFound.into())
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

/// Sum of the triangles' areas as vectors: front sides and sizes at once.
fn area_vector(scene: &Scene) -> DVec3 {
    let triangle = |t| {
        let [a, b, c] = scene.corners(t).map(|p| p.as_dvec3());
        0.5 * (b - a).cross(c - a)
    };
    (0..scene.triangles.len() as u32).map(triangle).sum()
}

/// The only texture that the first material's base colour reads.
fn base_texture(scene: &Scene) -> (&Texture, TextureRef) {
    let used = scene.materials[0].base_texture.expect("a base colour texture");
    (&scene.textures[used.texture as usize], used)
}

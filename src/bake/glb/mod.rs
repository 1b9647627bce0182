//! A scene as a binary glTF file (GLB), with light at its vertices: what is written is read again as the same scene.
//!
//! The file has the scene as it is rendered: one mesh in world space, a primitive a material; instances, skins and morph targets
//! are applied. Textures are embedded as PNG. glTF has no place for a background: it is left out.

mod looks;
mod nodes;

use crate::scene::Scene;
use glam::Vec3;
use serde_json::{Map, Value, json};
use std::io;

/// Four bytes a component.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// Of buffer views.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// What is written beside the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extras {
    /// `_IRRADIANCE` of each vertex, W·m⁻².
    pub irradiance: Option<Vec<Vec3>>,
    /// Shows that light without a renderer: `COLOR_0` is irradiance/π times 2 to so many stops, at most 1, and materials are
    /// unlit (KHR_materials_unlit).
    pub unlit_stops: Option<f32>,
}

/// The bytes of the file.
///
/// # Errors
/// A texture that cannot be encoded, or more than 4 GB.
pub fn write(scene: &Scene, extras: &Extras) -> io::Result<Vec<u8>> {
    let mut file = Glb::default();
    let attributes = file.attributes(scene, extras);
    let textures = looks::Textures::add(&mut file, scene)?;
    let materials: Vec<_> = scene.materials.iter().map(|m| looks::material(m, &textures, extras.unlit_stops)).collect();
    let mut primitives = Vec::new();
    for part in &scene.parts {
        let indices = bytemuck::cast_slice(scene.triangles_of(part));
        let view = file.view(indices, Some(ELEMENT_ARRAY_BUFFER));
        let count = 3 * part.triangle_count;
        let indices =
            file.accessor(json!({"bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"}));
        primitives.push(json!({"attributes": attributes, "indices": indices, "material": part.material}));
    }
    if !primitives.is_empty() {
        file.root.insert("meshes".into(), json!([{"name": scene.name, "primitives": primitives}]));
        file.root.insert("materials".into(), materials.into());
    }
    looks::extensions(scene, extras.unlit_stops.is_some()).for_each(|extension| file.uses(extension));
    nodes::add(&mut file, scene);
    file.finish()
}

/// A file in the making.
#[derive(Default)]
struct Glb {
    root: Map<String, Value>,
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    extensions: Vec<&'static str>,
}

impl Glb {
    /// Adds bytes, from a multiple of four on.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Notes that an extension is used.
    fn uses(&mut self, extension: &'static str) {
        if !self.extensions.contains(&extension) {
            self.extensions.push(extension);
        }
    }

    /// Floats of every vertex, `N` each.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let view = self.view(bytemuck::cast_slice(values.as_flattened()), Some(ARRAY_BUFFER));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        self.accessor(json!({"bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind}))
    }

    /// The vertices' streams, by name.
    fn attributes(&mut self, scene: &Scene, extras: &Extras) -> Value {
        let mut attributes = Map::new();
        if scene.positions.is_empty() {
            return attributes.into();
        }
        let positions: Vec<_> = scene.positions.iter().map(|p| p.to_array()).collect();
        let at = self.floats(&positions);
        let least = scene.positions.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let most = scene.positions.iter().copied().reduce(Vec3::max).unwrap_or_default();
        self.accessors[at]["min"] = json!(least.to_array());
        self.accessors[at]["max"] = json!(most.to_array());
        attributes.insert("POSITION".into(), at.into());
        let normals: Vec<_> = scene.normals.iter().map(|n| n.to_array()).collect();
        attributes.insert("NORMAL".into(), self.floats(&normals).into());
        if !scene.tangents.is_empty() {
            let tangents: Vec<_> = scene.tangents.iter().map(|t| t.to_array()).collect();
            attributes.insert("TANGENT".into(), self.floats(&tangents).into());
        }
        for (set, uvs) in scene.uvs.iter().enumerate().filter(|(_, uvs)| !uvs.is_empty()) {
            let uvs: Vec<_> = uvs.iter().map(|uv| uv.to_array()).collect();
            attributes.insert(format!("TEXCOORD_{set}"), self.floats(&uvs).into());
        }
        if let Some(colors) = looks::colors(scene, extras) {
            attributes.insert("COLOR_0".into(), self.floats(&colors).into());
        }
        if let Some(irradiance) = &extras.irradiance {
            let irradiance: Vec<_> = irradiance.iter().map(|e| e.to_array()).collect();
            attributes.insert("_IRRADIANCE".into(), self.floats(&irradiance).into());
        }
        attributes.into()
    }

    /// Header, JSON and bytes (glTF 2.0, section 4).
    fn finish(mut self) -> io::Result<Vec<u8>> {
        let mut root = std::mem::take(&mut self.root);
        let generator = format!("hemicube {}", env!("CARGO_PKG_VERSION"));
        root.insert("asset".into(), json!({"version": "2.0", "generator": generator}));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        if !self.bytes.is_empty() {
            root.insert("buffers".into(), json!([{"byteLength": self.bytes.len()}]));
            root.insert("bufferViews".into(), self.views.into());
        }
        if !self.accessors.is_empty() {
            root.insert("accessors".into(), self.accessors.into());
        }
        if !self.extensions.is_empty() {
            root.insert("extensionsUsed".into(), json!(self.extensions));
        }
        let mut text = serde_json::to_vec(&Value::Object(root))?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut chunks = vec![(*b"JSON", text)];
        if !self.bytes.is_empty() {
            chunks.push((*b"BIN\0", self.bytes));
        }
        let length = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
        let too_long = |_| io::Error::new(io::ErrorKind::FileTooLarge, "a GLB file holds at most 4 GB");
        let mut file = Vec::with_capacity(length);
        file.extend_from_slice(b"glTF");
        file.extend_from_slice(&2u32.to_le_bytes());
        file.extend_from_slice(&u32::try_from(length).map_err(too_long)?.to_le_bytes());
        for (kind, bytes) in chunks {
            file.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
            file.extend_from_slice(&kind);
            file.extend_from_slice(&bytes);
        }
        Ok(file)
    }
}

#[cfg(test)]
mod tests;

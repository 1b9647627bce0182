//! KHR_draco_mesh_compression: a primitive's attributes and indices in one code.
//!
//! What is decoded stands for the accessors that the primitive names, so that nothing else knows where values are from.

use super::accessor::Decompressed;
use super::buffers::Buffers;
use super::document::{Document, item};
use super::error::{Fault, Kind, Result, Within};
use draco_core::decode_limits::DecodeLimits;
use draco_core::decoder_buffer::DecoderBuffer;
use draco_core::mesh::Mesh;
use draco_core::mesh_decoder::MeshDecoder;
use gltf::json;
use json::accessor::ComponentType;
use json::validation::Checked;
use serde::Deserialize;
use std::collections::BTreeMap;

const NAME: &str = "KHR_draco_mesh_compression";
/// Decoded bytes allowed for each byte of code, and in any case. Constant attributes take hardly any code.
const LARGEST_RATIO: u64 = 2048;
const SMALL: u64 = 1 << 20;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compression {
    buffer_view: usize,
    attributes: BTreeMap<String, u32>,
}

/// Decodes the primitive, if it is compressed, into the accessors that it names; whether it was.
pub fn decode(document: &Document, buffers: &Buffers<'_>, primitive: &json::mesh::Primitive) -> Result<bool> {
    let Some(value) = primitive.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(false) };
    let of = Compression::deserialize(value).map_err(Fault::invalid).within(|| NAME)?;
    let Some(indices) = primitive.indices.map(|i| i.value()) else {
        return Err(Fault::invalid("has no accessor of indices").within(NAME));
    };
    if buffers.decompressed(indices).is_some() {
        return Ok(true);
    }
    let code = buffers.view(of.buffer_view).within(|| NAME)?.bytes;
    let mesh = run(code).within(|| NAME)?;
    let corners = mesh.faces().iter().flatten().flat_map(|corner| corner.0.to_le_bytes()).collect();
    buffers.set_decompressed(indices, Decompressed { bytes: corners, integers: true, components: 1 });
    for (semantic, accessor) in &primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        if let Some(id) = of.attributes.get(&semantic.to_string()) {
            let at = || format!("{NAME}: {}", semantic.to_string());
            let values = attribute(document, &mesh, *id, accessor.value()).within(at)?;
            buffers.set_decompressed(accessor.value(), values);
        }
    }
    Ok(true)
}

fn run(code: &[u8]) -> Result<Mesh> {
    let most = (code.len() as u64).saturating_mul(LARGEST_RATIO).saturating_add(SMALL);
    let limits = DecodeLimits::default().with_max_points(most).with_max_faces(most).with_max_decoded_bytes(most);
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(code).with_limits(limits), &mut mesh);
    decoded.map_err(|error| {
        Fault::new(Kind::Unsupported, format!("cannot be decoded ({error}); re-export without Draco compression"))
    })?;
    Ok(mesh)
}

/// The values of attribute `id`, as the type that the accessor states.
fn attribute(document: &Document, mesh: &Mesh, id: u32, accessor: usize) -> Result<Decompressed> {
    let of = item(&document.accessors, "accessor", accessor)?;
    let Some(found) = mesh.attribute_by_unique_id(id) else {
        return Err(Fault::invalid(format!("its code has no attribute {id}")));
    };
    let Checked::Valid(ref component) = of.component_type else {
        return Err(Fault::invalid("componentType is none that glTF knows"));
    };
    let components = usize::from(found.num_components());
    let values = found.read_f32s(mesh.num_points(), components);
    let largest = match component.0 {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32767.0,
        ComponentType::U16 => 65535.0,
        ComponentType::U32 | ComponentType::F32 => 1.0,
    };
    let integers = !of.normalized && matches!(component.0, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
    let scale = if of.normalized { largest } else { 1.0 };
    let bytes = match integers {
        true => values.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect(),
        false => values.iter().flat_map(|v| (v / scale).to_le_bytes()).collect(),
    };
    Ok(Decompressed { bytes, integers, components })
}

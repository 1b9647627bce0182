//! Which extensions a file may require.

use super::error::{Fault, Kind, Result, quote};
use super::{Notes, document::Document};

/// Read and obeyed.
const UNDERSTOOD: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    // Its diffuse part.
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Say nothing about geometry or diffuse light: ignored with a note, even when required.
const HARMLESS: &[&str] = &[
    "ADOBE_materials_clearcoat_specular",
    "ADOBE_materials_clearcoat_tint",
    "ADOBE_materials_thin_transparency",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "KHR_animation_pointer",
    "KHR_audio_emitter",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_variants",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "VRM",
];

/// Vendors' families of which the same holds: metadata, physics, avatars.
const HARMLESS_FAMILIES: &[&str] = &["AGI_", "OMI_", "VRMC_"];

/// Refuses what the file cannot be read without; notes what is ignored.
pub fn check(document: &Document, notes: &mut Notes) -> Result<()> {
    for name in &document.extensions_required {
        if !is(UNDERSTOOD, name) && !is(HARMLESS, name) && !HARMLESS_FAMILIES.iter().any(|f| name.starts_with(f)) {
            let what = format!("requires extension {}, which is not supported; {}", quote(name), remedy(name));
            return Err(Fault::new(Kind::Unsupported, what));
        }
    }
    for name in document.extensions_used.iter().chain(&document.extensions_required) {
        if !is(UNDERSTOOD, name) {
            notes.add(format!("extension {} is ignored", quote(name)));
        }
    }
    Ok(())
}

fn is(list: &[&str], name: &str) -> bool {
    list.contains(&name)
}

fn remedy(name: &str) -> &'static str {
    match name {
        "KHR_texture_basisu" => "re-export with PNG, JPEG or WebP textures",
        "MSFT_texture_dds" | "EXT_texture_avif" => "re-export with PNG, JPEG or WebP textures",
        _ => "re-export without it",
    }
}

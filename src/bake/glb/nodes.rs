//! Nodes: the mesh, cameras and lights, about the scene's origin.

use super::Glb;
use crate::scene::{Camera, Lens, Light, Scene};
use glam::{DMat3, DMat4, DVec3, Vec3};
use serde_json::{Value, json};

/// Adds the scene's nodes, its cameras and its lights.
pub fn add(file: &mut Glb, scene: &Scene) {
    let mut nodes = Vec::new();
    if !scene.parts.is_empty() {
        nodes.push(json!({"name": scene.name, "mesh": 0, "translation": scene.origin.to_array()}));
    }
    for (index, camera) in scene.cameras.iter().enumerate() {
        let mut node = placed(camera.camera_to_world, scene.origin);
        node["camera"] = index.into();
        if !camera.name.is_empty() {
            node["name"] = json!(camera.name);
        }
        nodes.push(node);
    }
    for (index, light) in scene.lights.iter().enumerate() {
        let mut node = placed(transform(light), scene.origin);
        node["extensions"] = json!({"KHR_lights_punctual": {"light": index}});
        nodes.push(node);
    }
    if !scene.cameras.is_empty() {
        let cameras: Vec<_> = scene.cameras.iter().map(camera).collect();
        file.root.insert("cameras".into(), cameras.into());
    }
    if !scene.lights.is_empty() {
        file.uses("KHR_lights_punctual");
        let lights: Vec<_> = scene.lights.iter().map(punctual).collect();
        file.root.insert("extensions".into(), json!({"KHR_lights_punctual": {"lights": lights}}));
    }
    let all: Vec<_> = (0..nodes.len()).collect();
    if !nodes.is_empty() {
        file.root.insert("nodes".into(), nodes.into());
        file.root.insert("scenes".into(), json!([{"nodes": all}]));
        file.root.insert("scene".into(), 0.into());
    }
}

fn placed(mut to_world: DMat4, origin: DVec3) -> Value {
    to_world.w_axis += origin.extend(0.0);
    json!({"matrix": to_world.to_cols_array()})
}

fn transform(light: &Light) -> DMat4 {
    let towards = |direction: Vec3| {
        let back = -direction.as_dvec3().normalize();
        let (right, up) = back.any_orthonormal_pair();
        DMat3::from_cols(right, up, back)
    };
    match light {
        Light::Point { position, .. } => DMat4::from_translation(position.as_dvec3()),
        Light::Spot { position, direction, .. } => {
            DMat4::from_mat3_translation(towards(*direction), position.as_dvec3())
        }
        Light::Directional { direction, .. } => DMat4::from_mat3(towards(*direction)),
    }
}

fn punctual(light: &Light) -> Value {
    let (kind, power) = match light {
        Light::Point { intensity, .. } => ("point", *intensity),
        Light::Spot { intensity, .. } => ("spot", *intensity),
        Light::Directional { irradiance, .. } => ("directional", *irradiance),
    };
    let strength = power.max_element();
    let colour = if strength > 0.0 { power / strength } else { Vec3::ONE };
    let mut written = json!({"type": kind, "color": colour.to_array(), "intensity": strength});
    if let Light::Spot { cos_inner, cos_outer, .. } = light {
        written["spot"] = json!({"innerConeAngle": cos_inner.acos(), "outerConeAngle": cos_outer.acos()});
    }
    written
}

fn camera(camera: &Camera) -> Value {
    match camera.lens {
        Lens::Perspective { yfov, aspect } => {
            let mut lens = json!({"yfov": yfov, "znear": 0.01});
            if let Some(aspect) = aspect {
                lens["aspectRatio"] = aspect.into();
            }
            json!({"type": "perspective", "perspective": lens})
        }
        Lens::Orthographic { aspect, ymag } => {
            let xmag = aspect.unwrap_or(1.0) * ymag;
            json!({"type": "orthographic", "orthographic": {"xmag": xmag, "ymag": ymag, "znear": 0.0, "zfar": 1e4}})
        }
    }
}

//! What `hemicube info --json` prints: the same for programs.

use anyhow::Result;
use hemicube::methods::rates::Rates;
use hemicube::passes::geometry::SurfaceSize;
use hemicube::renderer::{Plan, Settings, check_memory, memory_needs};
use hemicube::scene::{Camera, Lens, Scene};
use hemicube::vk::{Device, DeviceChoice, Instance, PhysicalDevice, REQUIREMENTS};
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// A scene, with what a frame of it runs and takes of `device`.
pub fn scene(scene: &Scene, device: Option<&Device>) -> Value {
    let (low, high) = scene.bounds();
    let plan = Plan::of(scene, &Settings::default(), device);
    let left_out: Vec<_> = plan.left_out().iter().map(|left| json!({"pass": left.pass, "why": left.why})).collect();
    let animation = |a: &hemicube::scene::Animation| json!({"name": a.name, "seconds": a.seconds});
    json!({
        "scene": scene.name,
        "hash": format!("{:016x}", scene.fingerprint()),
        "triangles": scene.triangles.len(),
        "vertices": scene.positions.len(),
        "materials": scene.parts.len(),
        "textures": scene.textures.len(),
        "lights": scene.lights.len(),
        "emissive_triangles": scene.emitters().len(),
        "cameras": scene.cameras.iter().map(camera).collect::<Vec<_>>(),
        "animations": scene.animations.iter().map(animation).collect::<Vec<_>>(),
        "bounds": [low.to_array(), high.to_array()],
        "origin": scene.origin.to_array(),
        "notes": scene.notes,
        "plan": {"run": plan.run(), "left_out": left_out},
        "memory": device.map(|device| memory(scene, device, &plan)),
    })
}

/// In the order that `--camera` counts them in. Angles are in degrees.
fn camera(camera: &Camera) -> Value {
    let lens = match camera.lens {
        Lens::Perspective { yfov, aspect } => {
            json!({"kind": "perspective", "yfov": yfov.to_degrees(), "aspect": aspect})
        }
        Lens::Orthographic { aspect, ymag } => json!({"kind": "orthographic", "height": 2.0 * ymag, "aspect": aspect}),
    };
    json!({"name": camera.name, "lens": lens, "to_world": camera.camera_to_world.to_cols_array()})
}

fn memory(scene: &Scene, device: &Device, plan: &Plan) -> Value {
    let settings = Settings::default();
    let size = SurfaceSize::about(scene, &plan.surface_cells, plan.detail());
    let needs = memory_needs(device, scene, &size, plan, &settings);
    let by_use: Map<_, _> = needs.iter().map(|need| (need.used_for.to_owned(), json!(need.bytes))).collect();
    let misfit = check_memory(device, scene, &size, plan, &settings).err().map(|error| error.to_string());
    json!({
        "device": device.physical.name,
        "bytes": needs.iter().map(|need| need.bytes).sum::<u64>(),
        "by_use": by_use,
        "misfit": misfit,
    })
}

/// All devices, with their rates where they are to be measured.
pub fn devices(measure: bool) -> Result<Value> {
    let instance = Instance::new(false)?;
    let mut list = Vec::new();
    for (index, physical) in instance.physical_devices()?.into_iter().enumerate() {
        list.push(device(&instance, &physical, index, measure)?);
    }
    Ok(json!({"devices": list}))
}

fn device(instance: &Arc<Instance>, physical: &PhysicalDevice, index: usize, measure: bool) -> Result<Value> {
    let version = physical.api_version;
    let (major, minor) = (ash::vk::api_version_major(version), ash::vk::api_version_minor(version));
    let mut value = json!({
        "index": index,
        "name": physical.name,
        "kind": format!("{:?}", physical.kind),
        "vulkan": format!("{major}.{minor}"),
        "driver": physical.driver.trim(),
    });
    match Device::new(instance.clone(), &DeviceChoice::Named(index.to_string())) {
        Err(error) => value["error"] = json!(error.to_string()),
        Ok(device) => {
            let has = &device.capabilities;
            value["memory"] = json!(has.device_memory);
            value["largest_allocation"] = json!(has.max_allocation);
            value["largest_image"] = json!(has.limits.max_image_dimension2_d);
            value["largest_storage_buffer"] = json!(has.limits.max_storage_buffer_range);
            value["views"] = json!(has.max_views);
            let options = REQUIREMENTS.iter().map(|option| (option.name.to_owned(), json!((option.has)(has))));
            value["options"] = Value::Object(options.collect());
            if measure {
                value["rates"] = rates(&Rates::measure(&device)?);
            }
        }
    }
    Ok(value)
}

/// In a second; of captures in compute where they fit.
fn rates(rates: &Rates) -> Value {
    json!({
        "triangle_views": rates.triangle_views,
        "blended_fragments": rates.blended_fragments,
        "integrated_texels": rates.integrated_texels,
        "compute": rates.compute.map(|compute| json!({
            "triangle_views": compute.triangle_views,
            "texels": compute.texels,
            "integrated_texels": compute.integrated_texels,
        })),
        "timestamp_ms": rates.timestamp_ms,
    })
}

//! What is not an array: materials, lights, background, how textures are read.

use hemicube::scene::{Background, Light, Material, Scene, TextureRef, Wrap};
use serde_json::{Value, json};

/// Everything of `scene.json` but the list of files.
pub fn scene(scene: &Scene, (width, height): (u32, u32)) -> Value {
    let parts = |part: &hemicube::scene::Part| json!({"material": part.material, "first_triangle": part.first_triangle, "triangle_count": part.triangle_count});
    let textures = |texture: &hemicube::scene::Texture| {
        json!({
            "name": texture.name, "width": texture.width, "height": texture.height, "nearest": texture.nearest,
            "wrap": texture.wrap.map(wrap),
        })
    };
    json!({
        "name": scene.name, "width": width, "height": height, "origin": scene.origin.to_array(),
        "parts": scene.parts.iter().map(parts).collect::<Vec<_>>(),
        "materials": scene.materials.iter().map(material).collect::<Vec<_>>(),
        "textures": scene.textures.iter().map(textures).collect::<Vec<_>>(),
        "lights": scene.lights.iter().map(light).collect::<Vec<_>>(),
        "background": background(&scene.background),
    })
}

fn wrap(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::MirroredRepeat => "mirror",
        Wrap::ClampToEdge => "clamp",
    }
}

fn material(material: &Material) -> Value {
    let texture = |used: &TextureRef| {
        let rows = used.transform.transpose().to_cols_array_2d();
        json!({"texture": used.texture, "set": used.set, "transform": rows})
    };
    json!({
        "name": material.name, "base_color": material.base_color.to_array(),
        "base_texture": material.base_texture.as_ref().map(texture),
        "normal_texture": material.normal_texture.as_ref().map(texture), "normal_scale": material.normal_scale,
        "emission": material.emission.to_array(), "emission_texture": material.emission_texture.as_ref().map(texture),
        "alpha_cutoff": material.alpha_cutoff, "double_sided": material.double_sided,
    })
}

fn light(light: &Light) -> Value {
    match light {
        Light::Point { position, intensity } => {
            json!({"kind": "point", "position": position.to_array(), "colour": intensity.to_array()})
        }
        Light::Spot { position, direction, intensity, cos_inner, cos_outer } => json!({
            "kind": "spot", "position": position.to_array(), "direction": direction.to_array(),
            "colour": intensity.to_array(), "cos_inner": cos_inner, "cos_outer": cos_outer,
        }),
        Light::Directional { direction, irradiance } => {
            json!({"kind": "directional", "direction": direction.to_array(), "colour": irradiance.to_array()})
        }
    }
}

fn background(background: &Background) -> Value {
    match background {
        Background::Black => Value::Null,
        Background::Constant(radiance) => json!({"radiance": radiance.to_array()}),
        Background::Map(map) => json!({"width": map.width, "height": map.height}),
    }
}

use super::*;
use crate::scene::{Material, Wrap};
use glam::{Vec2, Vec4};

const TEXELS: [[u8; 4]; 4] = [[10, 20, 30, 40], [50, 60, 70, 80], [90, 100, 110, 120], [130, 140, 150, 160]];

fn material(material: Value) -> Material {
    File::triangle().material(material).load().materials.remove(0)
}

fn textured(info: Value) -> File {
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": info}});
    File::triangle().attribute("TEXCOORD_0", &uvs).texture(TEXELS).material(material)
}

#[test]
fn factors_emission_and_sides() {
    let m = material(json!({
        "name": "lamp", "doubleSided": true, "emissiveFactor": [1, 0.5, 0.25],
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 1},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    }));
    assert_eq!((m.name.as_str(), m.double_sided, m.emission), ("lamp", true, Vec3::new(8.0, 4.0, 2.0)));
    assert_eq!(m.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4), "metallic is ignored");
    let glossy = json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.5, 0.5, 0.5, 1]}});
    assert_eq!(material(json!({"extensions": glossy})).base_color, Vec4::new(0.5, 0.5, 0.5, 1.0));
}

#[test]
fn alpha_modes() {
    assert_eq!(material(json!({})).alpha_cutoff, None);
    assert_eq!(material(json!({"alphaMode": "MASK"})).alpha_cutoff, Some(0.5));
    assert_eq!(material(json!({"alphaMode": "MASK", "alphaCutoff": 0.25})).alpha_cutoff, Some(0.25));
    let scene = File::triangle().material(json!({"alphaMode": "BLEND"})).load();
    assert_eq!(scene.materials[0].alpha_cutoff, Some(0.5));
    assert!(scene.notes[0].contains("alpha"), "{:?}", scene.notes);
}

#[test]
fn textures_are_decoded_as_stored() {
    let scene = textured(json!({"index": 0})).load();
    let (texture, used) = base_texture(&scene);
    assert_eq!((texture.width, texture.height, texture.rgba.as_slice()), (2, 2, &TEXELS[..]));
    assert_eq!((texture.wrap, texture.nearest), ([Wrap::Repeat; 2], false));
    assert_eq!(used.transform, glam::Mat3::IDENTITY);
}

#[test]
fn samplers_are_kept_and_shared_images_decoded_once() {
    let mut file = textured(json!({"index": 0})).set("/textures/0/sampler", json!(0));
    file.push("samplers", json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}));
    file.push("textures", json!({"source": 0}));
    file.push("textures", json!({"source": 0}));
    let emission = json!({"index": 1, "texCoord": 0});
    let file = file.set("/materials/0/emissiveTexture", emission).set("/materials/0/emissiveFactor", json!([1, 1, 1]));
    let scene = file.set("/materials/0/normalTexture", json!({"index": 2})).load();
    let (texture, _) = base_texture(&scene);
    assert_eq!((texture.wrap, texture.nearest), ([Wrap::ClampToEdge, Wrap::MirroredRepeat], true));
    assert_eq!(scene.textures.len(), 2, "the same image and sampler is the same texture");
    assert_eq!(scene.materials[0].emission_texture, scene.materials[0].normal_texture);
    let dark = textured(json!({"index": 0})).set("/materials/0/emissiveTexture", json!({"index": 9})).load();
    assert_eq!(dark.materials[0].emission_texture, None, "a factor of zero reads no texture");
}

#[test]
fn texture_transforms_scale_then_turn_then_move() {
    let transform =
        json!({"offset": [0.5, 0.25], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1});
    let file = textured(json!({"index": 0, "extensions": {"KHR_texture_transform": transform}}));
    let scene = file.attribute("TEXCOORD_1", &[[0.0, 0.0]; 3]).load();
    let used = base_texture(&scene).1;
    assert_eq!(used.set, 1);
    let at = |u, v| used.transform.transform_point2(Vec2::new(u, v));
    assert!((at(0.0, 0.0) - Vec2::new(0.5, 0.25)).length() < 1e-6);
    assert!((at(1.0, 0.0) - Vec2::new(0.5, 0.25 - 2.0)).length() < 1e-6, "{}", at(1.0, 0.0));
    assert!((at(0.0, 1.0) - Vec2::new(0.5 + 3.0, 0.25)).length() < 1e-6, "{}", at(0.0, 1.0));
}

#[test]
fn jpeg_and_webp_are_read() {
    let texel = [200u8, 100, 50];
    for (format, tolerance) in [(image::ImageFormat::Jpeg, 6), (image::ImageFormat::WebP, 0)] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::RgbImage::from_pixel(16, 16, image::Rgb(texel)).write_to(&mut bytes, format).unwrap();
        let mut file = textured(json!({"index": 0}));
        let view = file.view(bytes.get_ref());
        let image = file.push("images", json!({"bufferView": view}));
        let webp = json!({"EXT_texture_webp": {"source": image}});
        let texture = if tolerance == 0 { json!({"extensions": webp}) } else { json!({"source": image}) };
        let scene = file.set("/textures/0", texture).load();
        let read = base_texture(&scene).0.rgba[17];
        assert!(texel.iter().zip(read).all(|(a, b)| a.abs_diff(b) <= tolerance) && read[3] == 255, "{read:?}");
    }
}

#[test]
fn materials_that_nothing_uses_are_not_looked_at() {
    let mut file = File::triangle();
    file.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 4}}}));
    assert_eq!(file.load().materials.len(), 1);
}

#[test]
fn a_texture_without_an_image_is_left_out() {
    let scene = textured(json!({"index": 0})).set("/textures/0", json!({})).load();
    assert_eq!((scene.materials[0].base_texture, scene.textures.len()), (None, 0));
    assert!(scene.notes[0].contains("without an image"), "{:?}", scene.notes);
    let other = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    let line = textured(json!({"index": 0})).set("/textures/0", other).try_load().unwrap_err().to_string();
    assert!(line.contains("re-export"), "{line}");
}

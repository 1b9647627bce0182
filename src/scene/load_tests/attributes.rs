use super::*;
use glam::{Vec2, Vec4};

const UVS: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

#[test]
fn normals_are_brought_to_length_one_and_bad_ones_replaced() {
    let normals = [[0.0, 3.0, 4.0], [0.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
    let scene = File::triangle().attribute("NORMAL", &normals).load();
    assert!(close(scene.normals[0], Vec3::new(0.0, 0.6, 0.8)));
    assert_eq!(&scene.normals[1..], [Vec3::Z, Vec3::Z]);
    assert_eq!(scene.notes, ["normals that are zero or not finite are replaced by the triangles' (2×)"]);
    assert_eq!(scene.positions.len(), 3);
}

#[test]
fn sparse_elements_replace_the_base_or_zeros() {
    for base in [true, false] {
        let mut file = File::triangle();
        let indices = file.view(&[1, 2]);
        let values = file.view(bytemuck::cast_slice(&[5.0f32, 0.0, 0.0, 0.0, 7.0, 0.0]));
        let accessor = &mut file.document["accessors"][0];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values},
        });
        if !base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        let scene = file.load();
        assert_eq!(scene.positions, [Vec3::ZERO, Vec3::new(5.0, 0.0, 0.0), Vec3::new(0.0, 7.0, 0.0)]);
    }
}

#[test]
fn interleaved_attributes_are_read_by_stride_and_offset() {
    let mut file = File::new();
    let vertex = |p: [f32; 3]| [p[0], p[1], p[2], 0.0, 0.0, 1.0];
    let data = [vertex([0.0, 0.0, 0.0]), vertex([1.0, 0.0, 0.0]), vertex([0.0, 1.0, 0.0])];
    let view = file.view(bytemuck::cast_slice(data.as_flattened()));
    file.document["bufferViews"][view]["byteStride"] = json!(24);
    for (name, offset) in [("POSITION", 0), ("NORMAL", 12)] {
        let accessor =
            json!({"bufferView": view, "byteOffset": offset, "componentType": F32, "count": 3, "type": "VEC3"});
        let accessor = file.push("accessors", accessor);
        file.primitive()["attributes"][name] = json!(accessor);
    }
    let scene = file.load();
    assert_eq!((scene.normals[1], scene.positions[2]), (Vec3::Z, Vec3::Y));
}

#[test]
fn quantised_attributes_are_decoded() {
    let mut file = File::new().texture([[255; 4]; 4]).material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}
    }));
    let positions: [i16; 12] = [-32768, -32767, 0, 0, 32767, 0, 0, 0, 0, 16384, 0, 0];
    let normals: [i8; 12] = [0, 0, 127, 0, 0, 0, 127, 0, 0, 0, -128, 0];
    let uvs: [u16; 6] = [0, 65535, 65535, 0, 32768, 32768];
    let mut add = |name: &str, bytes: &[u8], component: u32, stride: usize, kind: &str, normalized: bool| {
        let accessor = file.accessor(bytes, component, 3, kind);
        let view = file.document["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        file.document["bufferViews"][view]["byteStride"] = json!(stride);
        file.document["accessors"][accessor]["normalized"] = json!(normalized);
        file.primitive()["attributes"][name] = json!(accessor);
    };
    add("POSITION", bytemuck::cast_slice(&positions), 5122, 8, "VEC3", true);
    add("NORMAL", bytemuck::cast_slice(&normals), 5120, 4, "VEC3", true);
    add("TEXCOORD_0", bytemuck::cast_slice(&uvs), U16, 4, "VEC2", true);
    let file = file.set("/extensionsRequired", json!(["KHR_mesh_quantization"]));
    let scene = file.load();
    let half = 16384.0 / 32767.0;
    assert_eq!(scene.positions, [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, half, 0.0)]);
    assert_eq!(scene.normals, [Vec3::Z, Vec3::Z, Vec3::NEG_Z]);
    assert_eq!(scene.uvs[0], [Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0), Vec2::splat(32768.0 / 65535.0)]);
    let plain = file.set("/accessors/0/normalized", json!(false)).load();
    assert_eq!(plain.positions[1], Vec3::new(32767.0, 0.0, 0.0));
}

#[test]
fn vertex_colours_are_linear_rgba() {
    let scene = File::triangle().attribute("COLOR_0", &[[0.25, 0.5, 1.0], [2.0, 0.0, 0.0], [0.0; 3]]).load();
    assert_eq!(scene.colors[0], Vec4::new(0.25, 0.5, 1.0, 1.0));
    assert_eq!(scene.colors[1], Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert_eq!(scene.notes, ["vertex colours outside [0, 1] are clamped"]);
    let mut file = File::triangle();
    let accessor = file.accessor(&[255, 0, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0], 5121, 3, "VEC4");
    file.document["accessors"][accessor]["normalized"] = json!(true);
    file.primitive()["attributes"]["COLOR_0"] = json!(accessor);
    assert!((file.load().colors[0] - Vec4::new(1.0, 0.0, 0.0, 0.2)).length() < 1e-6);
}

#[test]
fn coordinates_are_kept_only_where_a_texture_reads_them() {
    let file = || File::triangle().attribute("TEXCOORD_0", &UVS).attribute("TEXCOORD_1", &UVS.map(|uv| [uv[1], uv[0]]));
    assert!(file().load().uvs.iter().all(Vec::is_empty));
    let read = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}});
    let scene = file().texture([[255; 4]; 4]).material(read).load();
    assert_eq!((scene.uvs[0].len(), scene.uvs[1][1]), (0, Vec2::Y));
    assert_eq!(base_texture(&scene).1.set, 1);
}

#[test]
fn broken_and_missing_coordinates_are_zero_with_a_note() {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let textured = |file: File| file.texture([[255; 4]; 4]).material(material.clone()).load();
    let scene = textured(File::triangle().attribute("TEXCOORD_0", &[[f32::NAN, 0.5], [1.0, 0.0], [0.0, 1.0]]));
    assert_eq!(scene.uvs[0][0], Vec2::new(0.0, 0.5));
    assert!(scene.notes[0].contains("not finite"), "{:?}", scene.notes);
    let scene = textured(File::triangle());
    assert!(scene.notes[0].contains("without texture coordinates"), "{:?}", scene.notes);
}

fn normal_mapped(file: File) -> Scene {
    file.texture([[128, 128, 255, 255]; 4]).material(json!({"normalTexture": {"index": 0, "scale": 0.5}})).load()
}

#[test]
fn tangents_come_from_the_file_made_perpendicular() {
    let normals = [[0.0, 0.0, 1.0]; 3];
    let tangents = [[2.0, 0.0, 1.0, -1.0]; 3];
    let file =
        || File::triangle().attribute("NORMAL", &normals).attribute("TANGENT", &tangents).attribute("TEXCOORD_0", &UVS);
    let scene = normal_mapped(file());
    assert_eq!(scene.tangents[0], Vec4::new(1.0, 0.0, 0.0, -1.0));
    assert_eq!(scene.materials[0].normal_scale, 0.5);
    let mirrored = normal_mapped(file().set("/nodes/0/scale", json!([-1, 1, 1])));
    assert_eq!(mirrored.tangents[0], Vec4::new(-1.0, 0.0, 0.0, 1.0), "mirroring turns the handedness");
    assert!(file().load().tangents.is_empty(), "nothing reads them");
}

#[test]
fn tangents_follow_the_coordinates_and_split_where_these_are_mirrored() {
    let positions = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let mirrored = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 0.0]];
    let file = File::new().attribute("POSITION", &positions).attribute("NORMAL", &[[0.0, 0.0, 1.0]; 4]);
    let scene = normal_mapped(file.attribute("TEXCOORD_0", &mirrored).indices(&[0, 1, 2, 1, 3, 2]));
    assert_eq!(scene.positions.len(), 6, "the two shared vertices are split");
    assert_eq!([scene.normals.len(), scene.tangents.len(), scene.uvs[0].len()], [6; 3]);
    for (triangle, side) in [(0, -1.0), (1, 1.0)] {
        for v in scene.triangles[triangle] {
            let t = scene.tangents[v as usize];
            assert!(close(t.truncate(), Vec3::X * side) && t.w == side, "{triangle}: {t}");
        }
    }
}

//! Files as programs write them: loaded, each with one note.

use super::*;

fn text(file: &File, uri: &str) -> String {
    let mut document = file.document.clone();
    document["buffers"][0] = json!({"byteLength": file.data.len(), "uri": uri});
    document.to_string()
}

fn encoded(file: &File) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let sextets = |c: &[u8]| {
        let bits = c.iter().fold(0u32, |b, x| b << 8 | u32::from(*x));
        [18, 12, 6, 0].map(|s| LETTERS[(bits >> s & 63) as usize] as char)
    };
    file.data.chunks(3).flat_map(sextets).collect()
}

fn one_note(bytes: &[u8], resolve: &Resolver<'_>, words: &str) {
    let scene = load_from_slice("a.gltf", bytes, resolve, Limits::default()).unwrap_or_else(|e| panic!("{words}: {e}"));
    assert_eq!(scene.triangles.len(), 1, "{words}");
    assert!(scene.notes.len() == 1 && scene.notes[0].contains(words), "{words}: {:?}", scene.notes);
}

#[test]
fn other_encodings_of_the_json_are_read() {
    let file = File::triangle();
    let plain = text(&file, &format!("data:application/octet-stream;base64,{}", encoded(&file)));
    one_note(format!("\u{FEFF}{plain}").as_bytes(), &no_files, "byte order mark");
    one_note(format!("{plain}\0\0\0").as_bytes(), &no_files, "padded with zeros");
    let units = |swap: bool, mark: bool| -> Vec<u8> {
        let mark = if mark { "\u{FEFF}" } else { "" };
        let pair = |u: u16| if swap { u.to_be_bytes() } else { u.to_le_bytes() };
        format!("{mark}{plain}").encode_utf16().flat_map(pair).collect()
    };
    for (swap, mark) in [(false, false), (true, false)] {
        one_note(&units(swap, mark), &no_files, "UTF-16");
    }
    let marked = load_from_slice("a.gltf", &units(true, true), &no_files, Limits::default()).unwrap();
    assert_eq!(marked.triangles.len(), 1);
}

#[test]
fn other_spellings_of_data_are_read() {
    let file = File::triangle();
    let base64 = encoded(&file);
    let wrapped = base64.as_bytes().chunks(20).map(|c| String::from_utf8_lossy(c).into_owned()).collect::<Vec<_>>();
    let percent: String = file.data.iter().map(|b| format!("%{b:02X}")).collect();
    let cases = [
        (format!("data:application/octet-stream;BASE64,{base64}"), "small letters"),
        (format!("data:;base64,{}", wrapped.join("\r\n ")), "white space"),
        (format!("data:;base64,{}", base64.replace('A', "%41")), "percent-encoded"),
        (format!("data:application/octet-stream,{percent}"), "small letters"),
    ];
    for (uri, words) in cases {
        one_note(text(&file, &uri).as_bytes(), &no_files, words);
    }
}

#[test]
fn names_with_back_slashes_or_percent_signs_are_found() {
    let file = File::triangle();
    for (uri, name, words) in [("bin\\data.bin", "bin/data.bin", "back slashes"), ("a%20b.bin", "a%20b.bin", "written")]
    {
        let resolve =
            |asked: &str| if asked == name { Ok(file.data.clone()) } else { Err(io::ErrorKind::NotFound.into()) };
        one_note(text(&file, uri).as_bytes(), &resolve, words);
    }
}

#[test]
fn roots_that_are_none_or_doubled_are_drawn_once() {
    let file = || {
        let mut file = File::triangle();
        file.push("nodes", json!({"children": [0], "translation": [0, 0, 5]}));
        file
    };
    for (roots, words, z) in [
        (json!([0]), "without the parent", 0.0),
        (json!([1, 1]), "twice", 5.0),
        (json!([0, 1]), "below another", 5.0),
        (json!([1, 0]), "below another", 5.0),
    ] {
        let scene = file().set("/scenes/0/nodes", roots).load();
        assert_eq!((scene.triangles.len(), scene.positions[0].z), (1, z), "{words}");
        assert!(scene.notes.len() == 1 && scene.notes[0].contains(words), "{:?}", scene.notes);
    }
}

#[test]
fn empty_primitives_and_zero_rotations_are_noted() {
    let mut file = File::triangle();
    let none = file.push("accessors", json!({"componentType": F32, "count": 0, "type": "VEC3"}));
    let indices = file.push("accessors", json!({"componentType": U16, "count": 0, "type": "SCALAR"}));
    let empty = [json!({"attributes": {"POSITION": none}}), json!({"attributes": {"POSITION": 0}, "indices": indices})];
    file.document["meshes"][0]["primitives"].as_array_mut().unwrap().extend(empty);
    let scene = file.set("/nodes/0/rotation", json!([0, 0, 0, 0])).load();
    assert_eq!(scene.triangles.len(), 1);
    assert_eq!(
        scene.notes,
        ["rotations that are 0 are taken as none", "primitives without vertices are left out (2×)"]
    );
}

#[test]
fn hidden_nodes_and_those_below_them_are_not_drawn() {
    let mut file = File::triangle().set("/nodes/0/children", json!([1]));
    file.push("nodes", json!({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}, "children": [2]}));
    file.document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    file.push("nodes", json!({"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    let scene = file.set("/extensionsRequired", json!(["KHR_node_visibility"])).load();
    assert_eq!((scene.triangles.len(), scene.lights.len(), scene.notes.len()), (1, 0, 0));
}

#[test]
fn something_stands_for_pictures_that_are_missing() {
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let missing = |slot: &str| {
        let texture = json!({"index": 0});
        let mut file = File::triangle().attribute("TEXCOORD_0", &uvs);
        file.push("images", json!({"uri": "gone.png"}));
        file.push("textures", json!({"source": 0}));
        let pbr = json!({"baseColorFactor": [0.8, 0.8, 0.8, 1]});
        let file = file.material(json!({"pbrMetallicRoughness": pbr, "emissiveFactor": [1, 1, 1]}));
        file.set(slot, texture).load()
    };
    let base = missing("/materials/0/pbrMetallicRoughness/baseColorTexture");
    assert_eq!(base.materials[0].base_color, glam::Vec4::new(0.4, 0.4, 0.4, 1.0));
    let bump = missing("/materials/0/normalTexture");
    assert_eq!((bump.materials[0].normal_texture, bump.materials[0].emission), (None, Vec3::ONE));
    let lamp = missing("/materials/0/emissiveTexture");
    assert_eq!(lamp.materials[0].emission, Vec3::ZERO);
    for scene in [base, bump, lamp] {
        assert!(scene.notes.len() == 1 && scene.notes[0].contains("image 0 \"gone.png\""), "{:?}", scene.notes);
    }
}

#[test]
fn higher_coordinate_sets_are_read_two_at_once() {
    let uvs = |x: f32| [[x, 0.0], [x, 0.0], [x, 0.0]];
    let mut file = File::triangle().texture([[1; 4]; 4]);
    for set in 0..4 {
        file = file.attribute(&format!("TEXCOORD_{set}"), &uvs(set as f32));
    }
    let material = |base: u32, normal: u32| {
        json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": base}},
            "normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": normal}}}})
    };
    for (base, normal) in [(2, 2), (3, 0), (1, 2), (0, 1), (3, 2)] {
        let mut file = File { document: file.document.clone(), data: file.data.clone() };
        file.push("materials", material(base, normal));
        file.primitive()["material"] = json!(0);
        let scene = file.load();
        let m = &scene.materials[0];
        for (used, set) in [(m.base_texture, base), (m.normal_texture, normal)] {
            assert_eq!(scene.uvs[used.unwrap().set as usize][0].x, set as f32, "{base} {normal}");
        }
    }
}

#[test]
fn draco_code_that_cannot_be_decoded_is_named() {
    let mut file = File::triangle().indices(&[0, 1, 2]);
    let code = file.view(b"DRACO\x02\x02\x01\x01\0\0garbage");
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": code, "attributes": {"POSITION": 0}}});
    file.primitive()["extensions"] = draco;
    let line = file.try_load().unwrap_err().to_string();
    assert!(line.contains("KHR_draco_mesh_compression") && line.contains("re-export without Draco"), "{line}");
}

use super::*;

/// A grid of `n × n` points and its triangles.
fn grid(n: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let points = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32, ((i * 7) % 5) as f32 * 0.125]).collect();
    let cell = |i: u32| [i, i + 1, i + n, i + n, i + 1, i + n + 1];
    let cells = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| y * n + x));
    (points, cells.flat_map(cell).collect())
}

/// Replaces the bytes of accessor `accessor` by a meshopt code of them.
fn compress(file: &mut File, accessor: usize, code: &[u8], extension: Value) {
    let view = file.document["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    let code_view = file.view(code);
    let mut extension = extension;
    for key in ["buffer", "byteOffset", "byteLength"] {
        extension[key] = file.document["bufferViews"][code_view][key].clone();
    }
    // As encoders do, the view itself points into a fallback buffer that need not exist.
    let fallback = file
        .push("buffers", json!({"byteLength": 1 << 30, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}));
    let length = extension["count"].as_u64().unwrap() * extension["byteStride"].as_u64().unwrap();
    file.document["bufferViews"][view] =
        json!({"buffer": fallback, "byteLength": length, "extensions": {"EXT_meshopt_compression": extension}});
}

/// The grid, its positions and indices compressed by meshoptimizer's own encoder.
fn compressed_grid(n: u32, mode: &str) -> (Scene, Scene) {
    let (points, indices) = grid(n);
    let short: Vec<u16> = indices.iter().map(|i| *i as u16).collect();
    let plain = File::new().attribute("POSITION", &points).indices(&short);
    let mut file = File::new().attribute("POSITION", &points).indices(&short);
    let code = meshopt::encode_vertex_buffer(&points).unwrap();
    compress(&mut file, 0, &code, json!({"byteStride": 12, "count": points.len(), "mode": "ATTRIBUTES"}));
    let code = match mode {
        "TRIANGLES" => meshopt::encode_index_buffer(&indices, points.len()).unwrap(),
        _ => meshopt::encode_index_sequence(&indices, points.len()).unwrap(),
    };
    compress(&mut file, 1, &code, json!({"byteStride": 2, "count": indices.len(), "mode": mode}));
    let file = file.set("/extensionsRequired", json!(["EXT_meshopt_compression"]));
    (plain.load(), file.load())
}

#[test]
fn compressed_meshes_come_back() {
    for mode in ["TRIANGLES", "INDICES"] {
        let (plain, compressed) = compressed_grid(20, mode);
        assert_eq!(plain.triangles.len(), 2 * 19 * 19);
        // The triangle codec may turn a triangle's corners; sets of corners say the same.
        let key = |s: &Scene, t: usize| {
            let mut corners = s.corners(t as u32).map(|p| p.to_array().map(f32::to_bits));
            corners.sort_unstable();
            corners
        };
        for t in 0..plain.triangles.len() {
            assert_eq!(key(&plain, t), key(&compressed, t), "{mode} {t}");
        }
        assert!((area_vector(&plain) - area_vector(&compressed)).length() < 1e-9);
    }
}

#[test]
fn filters_are_undone() {
    let directions = [[0.0, 0.6, 0.8, 0.0], [-0.48, 0.6, 0.64, 0.0], [0.0, 0.0, -1.0, 0.0]];
    let mut file = File::triangle().attribute("NORMAL", &[[0.0, 0.0, 1.0]; 3]);
    let filtered: Vec<[i16; 4]> = meshopt::encode_filter_oct(&directions, 16);
    let code = meshopt::encode_vertex_buffer(&filtered).unwrap();
    let extension = json!({"byteStride": 8, "count": 3, "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL"});
    compress(&mut file, 1, &code, extension);
    file.document["accessors"][1]["componentType"] = json!(5122);
    file.document["accessors"][1]["normalized"] = json!(true);
    let scene = file.load();
    for (read, written) in scene.normals.iter().zip(directions) {
        assert!((*read - Vec3::new(written[0], written[1], written[2])).length() < 1e-3, "{read}");
    }
}

#[test]
fn every_truncation_of_a_code_is_an_error_or_a_scene() {
    let (points, _) = grid(4);
    let code = meshopt::encode_vertex_buffer(&points).unwrap();
    for length in 0..code.len() {
        let mut file = File::new().attribute("POSITION", &points);
        compress(&mut file, 0, &code[..length], json!({"byteStride": 12, "count": points.len(), "mode": "ATTRIBUTES"}));
        let line = file.try_load().expect_err("a truncated code").to_string();
        assert!(line.contains("meshopt code is broken"), "{line}");
    }
}

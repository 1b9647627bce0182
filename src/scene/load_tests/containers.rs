use super::*;
use std::collections::HashMap;

#[test]
fn files_are_found_beside_the_scene_by_decoded_name() {
    let mut file = File::triangle();
    file.document["buffers"][0] = json!({"byteLength": file.data.len(), "uri": "my%20data.bin"});
    let files: HashMap<&str, Vec<u8>> = HashMap::from([("my data.bin", file.data.clone())]);
    let resolve = |name: &str| files.get(name).cloned().ok_or_else(|| io::ErrorKind::NotFound.into());
    let text = serde_json::to_vec(&file.document).unwrap();
    let scene = load_from_slice("folder/room.v2.gltf", &text, &resolve, Limits::default()).unwrap();
    assert_eq!((scene.name.as_str(), scene.triangles.len()), ("room.v2", 1));
}

#[test]
fn the_same_scene_from_disk() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    let mut file = File::triangle();
    file.document["buffers"][0] = json!({"byteLength": file.data.len(), "uri": "../data.bin"});
    std::fs::write(folder.path().join("data.bin"), &file.data).unwrap();
    let path = folder.path().join("sub/scene.gltf");
    std::fs::write(&path, serde_json::to_vec(&file.document).unwrap()).unwrap();
    assert_eq!(load(&path).unwrap().triangles.len(), 1);
}

#[test]
fn limits_hold_before_memory_is_taken() {
    let scene = |limits| load_from_slice("a.glb", &File::triangle().glb(), &no_files, limits);
    let line = scene(Limits { triangles: 0, texels: 0 }).unwrap_err();
    assert!(matches!(line, SceneError::TooLarge { .. }), "{line}");
    assert!(scene(Limits { triangles: 1, texels: 0 }).is_ok());
}

#[test]
fn no_prefix_of_a_file_panics() {
    let glb = File::triangle().texture([[1; 4]; 4]).material(json!({"normalTexture": {"index": 0}})).glb();
    for length in 0..glb.len() {
        let result = load_from_slice("a.glb", &glb[..length], &no_files, Limits::default());
        assert!(result.is_err(), "{length}");
    }
}

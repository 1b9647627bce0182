use super::*;

const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

#[test]
fn lists_strips_and_fans_face_alike() {
    let list = File::new().attribute("POSITION", &QUAD).indices(&[0, 1, 2, 2, 1, 3]);
    let strip = File::new().attribute("POSITION", &QUAD).set("/meshes/0/primitives/0/mode", json!(5));
    let fan =
        File::new().attribute("POSITION", &QUAD).indices(&[0, 1, 3, 2]).set("/meshes/0/primitives/0/mode", json!(6));
    for file in [list, strip, fan] {
        let scene = file.load();
        assert_eq!((scene.triangles.len(), area_vector(&scene)), (2, DVec3::Z));
        assert!(scene.normals.iter().all(|n| *n == Vec3::Z));
    }
}

#[test]
fn points_and_lines_are_left_out_with_a_note() {
    let mut file = File::triangle();
    let points = json!({"attributes": {"POSITION": 0}, "mode": 1});
    file.document["meshes"][0]["primitives"].as_array_mut().unwrap().push(points);
    let scene = file.load();
    assert_eq!(scene.triangles.len(), 1);
    assert!(scene.notes[0].contains("points or lines"), "{:?}", scene.notes);
}

#[test]
fn missing_normals_make_flat_unshared_vertices() {
    let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0]];
    let scene = File::new().attribute("POSITION", &bent).indices(&[0, 1, 2, 0, 3, 1]).load();
    assert_eq!((scene.positions.len(), scene.triangles.len()), (6, 2));
    for (t, triangle) in scene.triangles.iter().enumerate() {
        let n = scene.geometric_normal(t as u32);
        assert!(triangle.iter().all(|v| scene.normals[*v as usize] == n));
    }
}

#[test]
fn only_used_vertices_are_kept_whichever_way_they_are_found() {
    let mut positions = vec![[9.0, 9.0, 9.0]; 100];
    positions[7..10].copy_from_slice(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    positions[50] = [f32::NAN; 3];
    let normals = vec![[0.0, 0.0, 1.0]; 100];
    let few = File::new().attribute("POSITION", &positions).attribute("NORMAL", &normals).indices(&[7, 8, 9]).load();
    assert_eq!((few.positions.len(), few.triangles.as_slice()), (3, &[[0, 1, 2]][..]));
    let often: Vec<u16> = (0..20).flat_map(|_| [9, 7, 8]).collect();
    let many = File::new().attribute("POSITION", &positions).attribute("NORMAL", &normals).indices(&often).load();
    assert_eq!((many.positions, many.triangles[0]), (few.positions, [2, 0, 1]));
}

#[test]
fn triangles_without_area_are_left_out_and_counted() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
    let file = File::new().attribute("POSITION", &positions).indices(&[0, 1, 2, 0, 1, 1, 0, 1, 3]);
    let scene = file.load();
    assert_eq!(scene.triangles.len(), 1);
    assert_eq!(scene.notes, ["triangles without area are left out (2×)"]);
}

#[test]
fn tiny_triangles_are_kept() {
    let tiny = QUAD.map(|p| p.map(|x| x * 1e-30));
    let scene = File::new().attribute("POSITION", &tiny[..3]).load();
    assert_eq!((scene.triangles.len(), scene.normals[0]), (1, Vec3::Z));
}

#[test]
fn parts_group_by_material_and_the_default_is_white() {
    let mut file = File::triangle().material(json!({"name": "second"})).material(json!({"name": "first"}));
    let primitive = |material: Value| json!({"attributes": {"POSITION": 0}, "material": material});
    let mut unnamed = primitive(json!(0));
    unnamed.as_object_mut().unwrap().remove("material");
    let primitives = [unnamed, primitive(json!(1)), primitive(json!(0)), primitive(json!(1))];
    file.document["meshes"][0]["primitives"] = json!(primitives);
    let scene = file.load();
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["second", "first", ""]);
    let parts: Vec<_> = scene.parts.iter().map(|p| (p.material, p.first_triangle, p.triangle_count)).collect();
    assert_eq!(parts, [(0, 0, 1), (1, 1, 2), (2, 3, 1)]);
    assert_eq!(scene.materials[2].base_color, glam::Vec4::ONE);
    assert_eq!([0, 1, 2, 3].map(|t| scene.material_of(t)), [0, 1, 1, 2]);
}

#[test]
fn a_library_of_meshes_is_shown_as_it_stands() {
    let mut file = File::triangle();
    for list in ["nodes", "scenes"] {
        file.document.as_object_mut().unwrap().remove(list);
    }
    assert_eq!(file.load().triangles.len(), 1);
}

//! The one test light of all exporters, read back by each engine's own rule, written here anew.

use super::*;
use glam::{UVec3, dvec3};
use std::f64::consts::PI;

/// 1 + 0.5x − 0.3y + 0.2z + 0.4xy + 0.1(3z² − 1), times three colours.
fn radiance(d: DVec3) -> DVec3 {
    let value = 1.0 + 0.5 * d.x - 0.3 * d.y + 0.2 * d.z + 0.4 * d.x * d.y + 0.1 * (3.0 * d.z * d.z - 1.0);
    value * COLOUR
}

const COLOUR: DVec3 = DVec3::new(1.0, 0.6, 0.2);

fn projected(f: impl Fn(DVec3) -> DVec3) -> Light {
    let mut light = [DVec3::ZERO; 9];
    let mut h = [0.0; 9];
    for (d, weight) in sh::sphere_rule(8) {
        sh::evaluate(3, d, &mut h);
        light.iter_mut().zip(h).for_each(|(sum, h)| *sum += weight * h * f(d));
    }
    light
}

/// E/π of the test light in closed form.
fn expected(n: DVec3) -> f64 {
    1.0 + 2.0 / 3.0 * (0.5 * n.x - 0.3 * n.y + 0.2 * n.z) + 0.25 * (0.4 * n.x * n.y + 0.1 * (3.0 * n.z * n.z - 1.0))
}

const N: DVec3 = DVec3::new(0.6, -0.48, 0.64);

fn directions() -> Vec<DVec3> {
    let [x, y, z] = DVec3::AXES;
    vec![N, x, -x, y, -y, z, -z]
}

/// SphericalHarmonics3.getIrradianceAt of three.js.
fn three_irradiance(c: &Light, n: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = n;
    c[0] * 0.886227
        + c[1] * 2.0 * 0.511664 * y
        + c[2] * 2.0 * 0.511664 * z
        + c[3] * 2.0 * 0.511664 * x
        + c[4] * 2.0 * 0.429043 * x * y
        + c[5] * 2.0 * 0.429043 * y * z
        + c[6] * (0.743125 * z * z - 0.247708)
        + c[7] * 2.0 * 0.429043 * x * z
        + c[8] * 0.429043 * (x * x - y * y)
}

/// Godot's shader: cosine factors over all, of what was divided by π.
fn godot_irradiance(c: &Light, n: DVec3) -> DVec3 {
    three_irradiance(c, n)
}

/// Unity's SHEvalLinearL0L1 and L2: a polynomial in the normal.
fn unity_irradiance(c: &Light, n: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = n;
    c[0] + c[1] * y
        + c[2] * z
        + c[3] * x
        + c[4] * x * y
        + c[5] * y * z
        + c[6] * (3.0 * z * z - 1.0)
        + c[7] * x * z
        + c[8] * (x * x - y * y)
}

#[test]
fn the_test_light_is_that_of_the_engines() {
    assert!((expected(N) - 1.358_253).abs() < 1e-6);
    let light = projected(radiance);
    let known = [3.54491, -0.61400, 0.40933, 1.02333, 0.36612, 0.0, 0.31707, 0.0, 0.0];
    assert!(light.iter().zip(known).all(|(c, known)| (c.x - known).abs() < 1e-5), "{light:?}");
    let unity = measures::unity(&light);
    let known = [1.0, -0.2, 0.13333, -0.33333, -0.1, 0.0, 0.025, 0.0, 0.0];
    assert!(unity.iter().zip(known).all(|(c, known)| (c.x - known).abs() < 1e-5), "{unity:?}");
    for n in directions() {
        let is = |name: &str, got: DVec3, factor: f64| {
            let off = (got / factor - expected(n) * COLOUR).abs().max_element();
            assert!(off < 1e-5, "{name} at {n}: {got}");
        };
        is("three", three_irradiance(&light, n), PI);
        is("godot", godot_irradiance(&measures::godot(&light), n), 1.0);
        // Unity's x axis is the other way round.
        is("unity", unity_irradiance(&unity, dvec3(-n.x, n.y, n.z)), 1.0);
        is("harmonics", e_over_pi(&light, n), 1.0);
    }
}

fn bevy_value(faces: &[DVec3; 6], n: DVec3) -> DVec3 {
    measures::squares(n).iter().zip(faces).map(|(square, face)| *square * *face).sum()
}

/// The faces along the axes are the light's own; those that are fitted come nearer to it over all directions.
#[test]
fn fitted_faces_beat_exact_ones() {
    let narrow = |d: DVec3| d.dot(dvec3(0.6, -0.48, 0.64)).max(0.0).powi(8) * DVec3::ONE;
    for (name, light) in [("gentle", projected(radiance)), ("narrow", projected(narrow))] {
        let exact = measures::bevy_exact(&light);
        let fitted = measures::bevy(&light);
        if name == "gentle" {
            let known = [1.3083, 0.6417, 0.7750, 1.1750, 1.1833, 0.9167];
            assert!(exact.iter().zip(known).all(|(face, known)| (face.x - known).abs() < 1e-4), "{exact:?}");
            assert!((bevy_value(&exact, N).x - 1.2264).abs() < 1e-4);
        }
        let rms = |faces: &[DVec3; 6]| {
            let (mut off, mut all) = (0.0, 0.0);
            for (n, weight) in sh::sphere_rule(20) {
                let truth = e_over_pi(&light, n).x;
                off += weight * (bevy_value(faces, n).x - truth).powi(2);
                all += weight * truth * truth;
            }
            f64::sqrt(off / all)
        };
        let nudged = |i: usize, step: f64| {
            let mut faces = fitted;
            faces[i] += step;
            rms(&faces)
        };
        eprintln!("{name}: exact faces {:.2} %, fitted {:.2} %", 1e2 * rms(&exact), 1e2 * rms(&fitted));
        assert!(rms(&fitted) < rms(&exact));
        let least = rms(&fitted);
        assert!((0..6).all(|i| nudged(i, 1e-3) > least && nudged(i, -1e-3) > least), "not the least squares");
    }
}

fn grid() -> Grid {
    let counts = UVec3::new(3, 2, 4);
    let light = |i: u32| projected(|d| radiance(d) * f64::from(i + 1));
    let lights = (0..counts.element_product()).map(light).collect();
    Grid { counts, low: dvec3(-1.0, 0.5, 2.0), spacing: dvec3(0.5, 1.0, 0.25), lights }
}

/// Six lights, one along each axis, prove the order of the faces and the hands, through the file's own texels.
#[test]
fn bevys_texels_are_where_its_shader_looks() {
    let [x, y, z] = DVec3::AXES;
    for (face, towards) in [x, -x, y, -y, z, -z].into_iter().enumerate() {
        let mut grid = grid();
        let number = 2 + 3 * (1 + 2 * 3); // (2, 1, 3)
        grid.lights.fill([DVec3::ZERO; 9]);
        grid.lights[number] = projected(|d| (1.0 + d.dot(towards)) * DVec3::ONE);
        let file = bevy::file(&grid);
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        assert_eq!([word(12), word(20), word(24), word(28), word(32), word(36), word(40)], [123, 3, 4, 12, 0, 1, 1]);
        let (data, length) = (word(80) as usize, word(88) as usize);
        assert_eq!((data % 8, file.len()), (0, data + length));
        let texel = |x: usize, y: usize, z: usize| rgb9e5::decode(word(data + 4 * (x + 3 * (y + 4 * z))));
        let faces: [DVec3; 6] = std::array::from_fn(|f| texel(2, 1 + 2 * (f % 2), 3 + 4 * (f / 2)));
        let brightest = (0..6).max_by(|a, b| faces[*a].x.total_cmp(&faces[*b].x)).unwrap();
        assert_eq!(brightest, face, "{faces:?}");
        let fitted = measures::bevy(&grid.lights[number]);
        assert!(faces.iter().zip(fitted).all(|(a, b)| (*a - b).abs().max_element() < 0.004 * b.max_element()));
        assert_eq!(texel(0, 0, 0), DVec3::ZERO);
    }
    let [translation, scale] = bevy::transform(&grid());
    assert_eq!((translation, scale), (dvec3(-0.5, 1.0, 2.375), dvec3(1.5, 2.0, 1.0)));
}

/// Every place of the grid is found in a tetrahedron that it lies in, by the tree's planes.
#[test]
fn godots_tree_finds_the_tetrahedron_of_a_place() {
    let grid = grid();
    let (tetrahedra, nodes) = godot::tree(&grid);
    assert_eq!(tetrahedra.len(), 6 * 2 * 3);
    for i in 0..500 {
        let t = dvec3(0.819_172_5, 0.671_043_6, 0.549_700_5) * f64::from(i);
        let place = grid.low + (t - t.floor()) * dvec3(1.0, 1.0, 0.75);
        let mut at = 0_i32;
        while at >= 0 {
            let node = nodes[at as usize];
            at = if node.normal.dot(place) - node.distance > 0.0 { node.over } else { node.under };
        }
        let [a, b, c, d] = tetrahedra[(-at - 1) as usize].map(|p| grid.place(p as usize));
        let matrix = glam::DMat3::from_cols(b - a, c - a, d - a);
        let shares = matrix.inverse() * (place - a);
        assert!(shares.min_element() > -1e-9 && shares.element_sum() < 1.0 + 1e-9, "{place}: {shares}");
    }
}

#[test]
fn what_is_inside_takes_its_neighbours_light() {
    let counts = UVec3::new(3, 1, 1);
    let one = projected(radiance);
    let lights = filled(vec![Some(one), None, Some(one.map(|c| 3.0 * c))], counts);
    assert!((lights[1][0] - 2.0 * one[0]).length() < 1e-12);
    let lights = filled(vec![None, None, Some(one)], counts);
    assert_eq!(lights[0], one);
}

/// The resource has every key that Godot's `LightmapGIData::_set_probe_data` demands, with as many numbers as its checks want.
#[test]
fn godots_resource_is_whole() {
    let grid = grid();
    let text = godot::resource(&grid);
    let numbers = |key: &str| -> Vec<f64> {
        let (_, rest) = text.split_once(&format!("\"{key}\": ")).unwrap();
        let (_, rest) = rest.split_once('(').unwrap();
        rest.split_once(')').unwrap().0.split(", ").map(|n| n.parse().unwrap()).collect()
    };
    let probes = grid.lights.len();
    let counts = ["bounds", "points", "sh", "tetrahedra"].map(|key| numbers(key).len());
    assert_eq!(counts, [6, 3 * probes, 4 * 9 * probes, 4 * 6 * 6]);
    assert_eq!(numbers("bsp").len() % 6, 0);
    assert_eq!(numbers("bounds"), [-1.0, 0.5, 2.0, 1.0, 1.0, 0.75]);
    let expected = measures::godot(&grid.lights[1])[3];
    assert_eq!(
        &numbers("sh")[4 * 12..4 * 12 + 3],
        expected.as_vec3().to_array().map(|v| v.to_string().parse::<f64>().unwrap())
    );
    assert!(text.starts_with("[gd_resource type=\"LightmapGIData\" format=3]"));
    assert!(text.contains("\"interior\": false") && text.contains("\"baked_exposure\": 1.0"));
}

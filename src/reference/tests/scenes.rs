//! Small scenes built in code.

use crate::scene::{Background, EnvironmentMap, Light, Material, Part, Scene, build};
use glam::{DVec3, Vec3, dvec3, vec3};

/// A material that reflects.
pub fn diffuse(albedo: f32) -> Material {
    Material { double_sided: false, ..build::diffuse(albedo) }
}

/// A material that emits radiance 1 × `l` from both sides.
pub fn emitter(l: f32) -> Material {
    Material { emission: Vec3::splat(l), double_sided: true, ..diffuse(0.0) }
}

/// Adds flat-shaded triangles with a material of their own.
pub fn add(scene: &mut Scene, material: Material, triangles: &[[Vec3; 3]]) {
    let part = Part {
        material: scene.materials.len() as u32,
        first_triangle: scene.triangles.len() as u32,
        triangle_count: triangles.len() as u32,
    };
    for corners in triangles {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let first = scene.positions.len() as u32;
        scene.positions.extend(corners);
        scene.normals.extend([normal; 3]);
        scene.triangles.push([first, first + 1, first + 2]);
    }
    scene.parts.push(part);
    scene.materials.push(material);
}

/// Two triangles from corners in order.
pub fn quad(corners: [Vec3; 4]) -> [[Vec3; 3]; 2] {
    [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
}

/// The faces of a box: −X, +X, −Y, +Y, −Z, +Z.
pub fn box_faces(low: Vec3, high: Vec3) -> [[[Vec3; 3]; 2]; 6] {
    std::array::from_fn(|face| {
        let axis = face / 2;
        let at = |u: bool, v: bool| {
            let mut p = low;
            p[axis] = if face % 2 == 1 { high[axis] } else { low[axis] };
            p[(axis + 1) % 3] = if u { high } else { low }[(axis + 1) % 3];
            p[(axis + 2) % 3] = if v { high } else { low }[(axis + 2) % 3];
            p
        };
        quad([at(false, false), at(true, false), at(true, true), at(false, true)])
    })
}

/// A tessellated sphere, corners on the sphere.
pub fn sphere(center: DVec3, radius: f64, rows: u32) -> Vec<[Vec3; 3]> {
    let at = |i: u32, j: u32| {
        let (theta, phi) = (std::f64::consts::PI / f64::from(rows), std::f64::consts::PI / f64::from(rows));
        let (st, ct) = (theta * f64::from(i)).sin_cos();
        let (sp, cp) = (phi * f64::from(j % (2 * rows))).sin_cos();
        (center + dvec3(st * cp, st * sp, ct) * radius).as_vec3()
    };
    let mut triangles = vec![];
    for i in 0..rows {
        for j in 0..2 * rows {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if i + 1 < rows {
                triangles.push([a, b, c]);
            }
            if i > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

/// A scene of one emitter.
pub fn only_emitter(triangles: &[[Vec3; 3]]) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, emitter(1.0), triangles);
    scene
}

/// A point light of intensity 1.
pub fn point_light(position: Vec3) -> Light {
    Light::Point { position, intensity: Vec3::ONE }
}

/// An equirectangular map of a function of the direction.
pub fn map(width: u32, radiance: impl Fn(DVec3) -> f64) -> Background {
    let height = width / 2;
    let texel = |i: u32| {
        let phi = std::f64::consts::TAU * ((f64::from(i % width) + 0.5) / f64::from(width) - 0.5);
        let theta = std::f64::consts::PI * (f64::from(i / width) + 0.5) / f64::from(height);
        let l = radiance(dvec3(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()));
        [l as f32; 3]
    };
    Background::Map(EnvironmentMap { width, height, rgb: (0..width * height).map(texel).collect() })
}

/// The rectangle light of the closed form: x ∈ [.3, 1.5], y ∈ [−.7, .9], z = 1.
pub fn rectangle_light() -> Scene {
    let corners = [vec3(0.3, -0.7, 1.0), vec3(1.5, -0.7, 1.0), vec3(1.5, 0.9, 1.0), vec3(0.3, 0.9, 1.0)];
    only_emitter(&quad(corners))
}

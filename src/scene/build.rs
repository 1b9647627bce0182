//! Scenes made in code, for closed forms and extremes.

use super::{Background, Camera, Lens, Light, Material, Part, Scene, Texture, Wrap};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3, Vec4};
use std::f32::consts::{PI, TAU};

/// A scene in the making: triangles by material.
#[derive(Default)]
pub struct Builder {
    groups: Vec<(Material, Vec<[Corner; 3]>)>,
    scene: Scene,
}

#[derive(Clone, Copy)]
struct Corner {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
}

/// A diffuse surface of albedo `rho` in all channels.
pub fn diffuse(rho: f32) -> Material {
    let white = super::gltf::materials::default_material();
    Material { base_color: Vec4::new(rho, rho, rho, 1.0), double_sided: true, ..white }
}

/// A surface that emits from its front.
pub fn emitter(radiance: Vec3) -> Material {
    Material { emission: radiance, double_sided: false, ..diffuse(0.0) }
}

/// Which way a closed surface faces.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Facing {
    /// Its front is inside.
    In,
    /// Its front is outside.
    Out,
}

impl Builder {
    /// A material, to be named by what is returned.
    pub fn material(&mut self, material: Material) -> usize {
        self.groups.push((material, Vec::new()));
        self.groups.len() - 1
    }

    /// A texture, to be named by what is returned.
    pub fn texture(&mut self, width: u32, height: u32, rgba: Vec<[u8; 4]>, nearest: bool) -> u32 {
        let wrap = [Wrap::Repeat; 2];
        self.scene.textures.push(Texture { name: String::new(), width, height, rgba, wrap, nearest });
        self.scene.textures.len() as u32 - 1
    }

    /// A triangle, counter-clockwise seen from its front, its normal that of its plane (not a number where it has none).
    pub fn triangle(&mut self, material: usize, corners: [Vec3; 3]) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        self.groups[material].1.push(corners.map(|position| Corner { position, normal, uv: Vec2::ZERO }));
    }

    /// A parallelogram from `corner` along `u` and `v`; its front is where u × v points.
    pub fn quad(&mut self, material: usize, corner: Vec3, u: Vec3, v: Vec3) {
        let normal = u.cross(v).normalize();
        let at = |a: f32, b: f32| Corner { position: corner + a * u + b * v, normal, uv: Vec2::new(a, b) };
        let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        self.groups[material].1.extend([[a, b, c], [a, c, d]]);
    }

    /// A square in the plane y = `height`, centred on the axis, facing up.
    pub fn floor(&mut self, material: usize, height: f32, half: f32) {
        self.quad(material, Vec3::new(-half, height, half), Vec3::X * 2.0 * half, Vec3::NEG_Z * 2.0 * half);
    }

    /// The same facing down.
    pub fn ceiling(&mut self, material: usize, height: f32, half: f32) {
        self.quad(material, Vec3::new(-half, height, -half), Vec3::X * 2.0 * half, Vec3::Z * 2.0 * half);
    }

    /// An axis-aligned box.
    pub fn cuboid(&mut self, material: usize, low: Vec3, high: Vec3, facing: Facing) {
        let size = high - low;
        for axis in 0..3 {
            let [n, u, v] = [0, 1, 2].map(|i| Vec3::AXES[(axis + i) % 3] * size[(axis + i) % 3]);
            for corner in [low + n, low] {
                let outwards = corner != low;
                let (u, v) = if outwards == (facing == Facing::Out) { (u, v) } else { (v, u) };
                self.quad(material, corner, u, v);
            }
        }
    }

    /// A sphere of `2 n × n` quads with smooth normals.
    pub fn sphere(&mut self, material: usize, centre: Vec3, radius: f32, n: u32, facing: Facing) {
        let at = |i: u32, j: u32| {
            let (theta, phi) = (PI * j as f32 / n as f32, TAU * (i % (2 * n)) as f32 / (2 * n) as f32);
            let d = if j == 0 || j == n {
                if j == 0 { Vec3::Y } else { Vec3::NEG_Y }
            } else {
                Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
            };
            let normal = if facing == Facing::Out { d } else { -d };
            Corner { position: centre + radius * d, normal, uv: Vec2::ZERO }
        };
        let turn = |[a, b, c]: [Corner; 3]| if facing == Facing::Out { [a, b, c] } else { [a, c, b] };
        for i in 0..2 * n {
            for j in 0..n {
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                let triangles = &mut self.groups[material].1;
                if j + 1 < n {
                    triangles.push(turn([a, b, c]));
                }
                if j > 0 {
                    triangles.push(turn([a, c, d]));
                }
            }
        }
    }

    /// A punctual light.
    pub fn light(&mut self, light: Light) {
        self.scene.lights.push(light);
    }

    /// What shines from outside.
    pub fn background(&mut self, background: Background) {
        self.scene.background = background;
    }

    /// The scene, with the streams that its materials need.
    pub fn build(self) -> Scene {
        let Self { groups, mut scene } = self;
        let maps = |m: &Material| [m.base_texture, m.normal_texture, m.emission_texture];
        let textured = groups.iter().any(|(m, _)| maps(m).iter().any(Option::is_some));
        let bumpy = groups.iter().any(|(m, _)| m.normal_texture.is_some());
        for (material, triangles) in groups.into_iter().filter(|(_, triangles)| !triangles.is_empty()) {
            let first_triangle = scene.triangles.len() as u32;
            scene.parts.push(Part {
                material: scene.materials.len() as u32,
                first_triangle,
                triangle_count: triangles.len() as u32,
            });
            scene.materials.push(material);
            for corners in triangles {
                let base = scene.positions.len() as u32;
                scene.triangles.push([base, base + 1, base + 2]);
                scene.positions.extend(corners.map(|c| c.position));
                scene.normals.extend(corners.map(|c| c.normal));
                if textured {
                    scene.uvs[0].extend(corners.map(|c| c.uv));
                }
                if bumpy {
                    let [a, b, c] = corners;
                    let tangent = tangent([a, b, c]);
                    scene.tangents.extend([tangent; 3]);
                }
            }
        }
        scene
    }
}

/// `scene`, which has positions and normals alone, with every triangle cut into 4^`levels` equal ones.
pub fn tessellated(scene: &Scene, levels: u32) -> Scene {
    let mut fine = scene.clone();
    for _ in 0..levels {
        let coarse = std::mem::take(&mut fine.triangles);
        for [a, b, c] in coarse {
            let mut middle = |i: u32, j: u32| {
                fine.positions.push((fine.positions[i as usize] + fine.positions[j as usize]) * 0.5);
                fine.normals.push((fine.normals[i as usize] + fine.normals[j as usize]).normalize());
                fine.positions.len() as u32 - 1
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            fine.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
    }
    for part in &mut fine.parts {
        part.first_triangle <<= 2 * levels;
        part.triangle_count <<= 2 * levels;
    }
    fine
}

/// Direction of growing u, right-handed with v.
fn tangent([a, b, c]: [Corner; 3]) -> Vec4 {
    let (e, f) = (b.position - a.position, c.position - a.position);
    let (p, q) = (b.uv - a.uv, c.uv - a.uv);
    let along = e * q.y - f * p.y;
    (if p.perp_dot(q) < 0.0 { -along } else { along })
        .try_normalize()
        .unwrap_or(a.normal.any_orthonormal_vector())
        .extend(1.0)
}

/// A perspective camera; `yfov` in degrees.
pub fn look(eye: DVec3, target: DVec3, yfov: f64) -> Camera {
    let lens = Lens::Perspective { yfov: yfov.to_radians(), aspect: None };
    Camera { name: String::new(), camera_to_world: towards(eye, target), lens }
}

/// A parallel camera that shows `half` above and below its axis.
pub fn look_parallel(eye: DVec3, target: DVec3, half: f64) -> Camera {
    Camera {
        name: String::new(),
        camera_to_world: towards(eye, target),
        lens: Lens::Orthographic { ymag: half, aspect: None },
    }
}

fn towards(eye: DVec3, target: DVec3) -> DMat4 {
    let back = (eye - target).normalize();
    let up = if back.y.abs() > 0.999 { DVec3::NEG_Z } else { DVec3::Y };
    let right = up.cross(back).normalize();
    DMat4::from_mat3_translation(DMat3::from_cols(right, back.cross(right), back), eye)
}

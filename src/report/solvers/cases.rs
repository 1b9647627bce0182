//! Closed rooms and gaps where light goes on for long.

use crate::scene::build::{Builder, Facing, diffuse};
use crate::scene::{Light, Part, Scene};
use glam::{Vec3, vec3};
use std::f32::consts::TAU;
use std::f64::consts::PI;

/// A part of the surface, with the mean irradiance that reflected light brings to it.
#[derive(Clone, Debug)]
pub struct Region {
    /// What it is, in a word.
    pub name: &'static str,
    /// Triangles of the scene and their sides, 0 for the front.
    pub sides: Vec<(u32, usize)>,
    /// In closed form, W·m⁻²; `None`: to be traced.
    pub mean: Option<f64>,
}

/// A scene to be solved, grey, with what is known of it.
#[derive(Clone, Debug)]
pub struct Case {
    /// What it is.
    pub name: String,
    /// The scene: every triangle has vertices of its own, in order.
    pub scene: Scene,
    /// What its solution is held against.
    pub regions: Vec<Region>,
}

/// All cases. The first ones have an albedo each; the others are stiff in their own ways.
pub fn cases() -> Vec<Case> {
    let mut cases: Vec<_> = [0.1, 0.5, 0.9, 0.95, 0.99, 0.999].map(sphere).into();
    cases.extend([checkerboard(), needle()]);
    cases
}

/// The inside of a sphere of radius 1 with a lamp halfway out: everywhere E = ρ/(1 − ρ)·I/s².
pub fn sphere(rho: f32) -> Case {
    let mut b = Builder::default();
    let white = b.material(diffuse(rho));
    b.sphere(white, Vec3::ZERO, 1.0, 32, Facing::In);
    b.light(Light::Point { position: vec3(0.0, -0.5, 0.0), intensity: Vec3::ONE });
    let (scene, rho) = (b.build(), f64::from(rho));
    let regions = vec![Region { name: "all", sides: fronts(&scene), mean: Some(rho / (1.0 - rho)) }];
    Case { name: format!("sphere, ρ = {rho:.3}").trim_end_matches('0').into(), scene, regions }
}

/// The same in pieces of albedo 0 and .99 in turns, its lamp in the middle: their mean albedo counts.
pub fn checkerboard() -> Case {
    const PIECES: f32 = 32.0;
    let Case { mut scene, .. } = sphere(0.99);
    scene.lights = vec![Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE }];
    let is_black = |triangle: &[u32; 3]| {
        let middle = triangle.iter().map(|v| scene.positions[*v as usize]).sum::<Vec3>() / 3.0;
        let down = middle.normalize().y.acos() / std::f32::consts::PI * PIECES;
        let around = (middle.x.atan2(middle.z).rem_euclid(TAU) / TAU) * 2.0 * PIECES;
        (down as u32 + around as u32).is_multiple_of(2)
    };
    let (black, white): (Vec<_>, Vec<_>) = scene.triangles.iter().copied().partition(is_black);
    let count = black.len() as u32;
    scene.materials.push(diffuse(0.0));
    scene.parts = vec![
        Part { material: 1, first_triangle: 0, triangle_count: count },
        Part { material: 0, first_triangle: count, triangle_count: white.len() as u32 },
    ];
    let area = |scene: &Scene, t: u32| f64::from(scene.area(t));
    scene.triangles = black.into_iter().chain(white).collect();
    let all: f64 = (0..scene.triangles.len() as u32).map(|t| area(&scene, t)).sum();
    let rho = 0.99 * (count..scene.triangles.len() as u32).map(|t| area(&scene, t)).sum::<f64>() / all;
    let scene = with_own_vertices(&scene);
    let regions = vec![Region { name: "all", sides: fronts(&scene), mean: Some(rho / (1.0 - rho)) }];
    Case { name: "checkerboard of 0 and .99".into(), scene, regions }
}

/// A white box, ρ = .95, with one narrow cone of light: all its power Φ is left on the walls in the end.
pub fn needle() -> Case {
    const RHO: f32 = 0.95;
    let mut b = Builder::default();
    let white = b.material(diffuse(RHO));
    b.cuboid(white, Vec3::splat(-1.0), Vec3::splat(1.0), Facing::In);
    let cone = 3f64.to_radians().cos();
    let direction = vec3(0.3, -1.0, 0.2).normalize();
    let intensity = Vec3::splat(100.0);
    b.light(Light::Spot { position: Vec3::ZERO, direction, intensity, cos_inner: cone, cos_outer: cone });
    let scene = b.build();
    let flux = 100.0 * 2.0 * PI * (1.0 - cone);
    let regions = vec![closed(&scene, fronts(&scene), f64::from(RHO), flux)];
    Case { name: "needle of light, ρ = .95".into(), scene, regions }
}

/// A closed surface of one albedo: of a power Φ a share 1 − ρ stays at each reflection.
fn closed(scene: &Scene, sides: Vec<(u32, usize)>, rho: f64, flux: f64) -> Region {
    let area: f64 = sides.iter().map(|(t, _)| f64::from(scene.area(*t))).sum();
    Region { name: "all", sides, mean: Some(rho / (1.0 - rho) * flux / area) }
}

fn fronts(scene: &Scene) -> Vec<(u32, usize)> {
    (0..scene.triangles.len() as u32).map(|t| (t, 0)).collect()
}

/// Every triangle with vertices of its own, in order.
fn with_own_vertices(scene: &Scene) -> Scene {
    let corners = || scene.triangles.iter().flatten().map(|v| *v as usize);
    Scene {
        positions: corners().map(|v| scene.positions[v]).collect(),
        normals: corners().map(|v| scene.normals[v]).collect(),
        triangles: (0..scene.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..scene.clone()
    }
}

//! Cases of the sky's own light.

use super::{Bound, Case, Known, Read, Site};
use crate::scene::build::{Builder, diffuse};
use crate::scene::{Background, EnvironmentMap, Scene};
use glam::{DVec3, Vec3, dvec3};
use std::f64::consts::PI;

pub(super) fn cases() -> Vec<Case> {
    vec![furnace(), linear(), half()]
}

/// Something far below, so that the scene has geometry that nobody sees.
fn under(background: Background) -> Scene {
    let mut b = Builder::default();
    let black = b.material(diffuse(0.0));
    b.floor(black, -1.0, 0.01);
    b.background(background);
    b.build()
}

/// The same radiance from everywhere: E = πL whatever the texels, and no gradients.
fn furnace() -> Case {
    // Sums of a few thousand single-precision terms.
    let rounding = Bound::flat(1e-5);
    let (normal, u) = (dvec3(0.2, 0.9, -0.1).normalize(), DVec3::X);
    let t = (u - normal * normal.x).normalize();
    let known = vec![
        Known::new("E = πL", Read::Sky, PI, rounding),
        Known::new("dE/dn", Read::SkyTurn(t), 0.0, rounding).relative_to(PI),
        Known::new("‖∇_t E‖", Read::SkyMove, 0.0, rounding).relative_to(PI),
    ];
    let site = Site { words: String::new(), position: DVec3::ZERO, normal, known };
    Case { name: "furnace", scene: under(Background::Constant(Vec3::ONE)), light: (2, 1), sites: vec![site] }
}

fn map(radiance: impl Fn(Vec3) -> f32) -> Background {
    let (width, height) = (256, 128);
    let texel = |i: u32| {
        let uv = [((i % width) as f32 + 0.5) / width as f32, ((i / width) as f32 + 0.5) / height as f32];
        [radiance(EnvironmentMap::uv_to_direction(uv)); 3]
    };
    Background::Map(EnvironmentMap { width, height, rgb: (0..width * height).map(texel).collect() })
}

/// Radiance L₀ + L₁ω_x: E = πL₀ + (2π/3)L₁n_x, dE/dn = (2π/3)L₁ along x.
fn linear() -> Case {
    let (l0, l1) = (1.0, 0.8);
    let site = |normal: DVec3| {
        let slope = 2.0 * PI / 3.0 * l1;
        let along = (DVec3::X - normal * normal.x).normalize_or_zero();
        let across = normal.cross(along);
        let e = PI * l0 + slope * normal.x;
        // Midpoints of texels and of the map's: of second order, h²/8 and (π/128)²/8; gradients lose cos² at the horizon.
        let bound = Bound { factor: 0.5, order: 2.0, floor: 0.0 };
        let mut known = vec![Known::new("E = πL₀ + (2π/3)L₁n", Read::Sky, e, bound)];
        if along != DVec3::ZERO {
            known.push(Known::new("dE/dn", Read::SkyTurn(along), slope * along.x, bound).relative_to(slope));
            known.push(Known::new("dE/dn across", Read::SkyTurn(across), 0.0, bound).relative_to(slope));
        }
        Site { words: format!("n_x = {:.2}", normal.x), position: DVec3::ZERO, normal, known }
    };
    let sites = [DVec3::Y, dvec3(0.6, 0.8, 0.0), dvec3(-0.6, 0.48, 0.64)].map(site).into();
    Case { name: "linear sky", scene: under(map(|d| (l0 + l1 * f64::from(d.x)) as f32)), light: (2, 1), sites }
}

/// L above the horizon, nothing below: E = ½πL(1 + cos β) on a surface tilted by β, dE/dβ = −½πL sin β.
fn half() -> Case {
    let site = |degrees: f64| {
        let (s, c) = degrees.to_radians().sin_cos();
        let (normal, further) = (dvec3(s, c, 0.0), dvec3(c, -s, 0.0));
        // The horizon crosses the whole hemisphere: ∮ cosθ dl ≤ 2. The map's ramp there is even.
        let bound = |e: f64| Bound::linear(2.0 / 2f64.sqrt() / e).and(1e-4);
        let (e, slope) = (0.5 * PI * (1.0 + c), -0.5 * PI * s);
        let known = vec![
            Known::new("E = ½πL(1 + cosβ)", Read::Sky, e, bound(e)),
            Known::new("dE/dβ", Read::SkyTurn(further), slope, bound(0.5 * PI)).relative_to(0.5 * PI),
        ];
        Site { words: format!("β = {degrees}°"), position: DVec3::ZERO, normal, known }
    };
    let sites = [0.0, 30.0, 60.0, 90.0, 120.0].map(site).into();
    Case { name: "half a sky", scene: under(map(|d| if d.y > 0.0 { 1.0 } else { 0.0 })), light: (2, 1), sites }
}

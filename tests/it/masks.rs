//! Alpha masks: what is cut out lets light through, and reflects none.

use crate::common::build::diffuse;
use crate::common::closed_forms::{parallelogram, polygon};
use crate::common::{
    Builder, TINT, against, assert_close, each_capture, inside, look, look_parallel, picture, small, tinted,
};
use glam::{DVec3, Mat3, Vec3, dvec3, vec3};
use hemicube::renderer::Settings;
use hemicube::scene::{Light, Material, TextureRef};
use std::f64::consts::PI;

/// A material of albedo 0.8 times a texture, cut out at alpha ½.
fn cut_out(texture: u32) -> Material {
    let base_texture = Some(TextureRef { texture, set: 0, transform: Mat3::IDENTITY });
    Material { base_texture, alpha_cutoff: Some(0.5), ..diffuse(0.8) }
}

/// A plate with square holes lets the sun through where it is cut.
#[test]
fn an_alpha_mask_is_cut_out_of_the_shadow() {
    let mut b = Builder::default();
    let texels = (0..64).map(|i| if (i + i / 8) % 2 == 0 { [255; 4] } else { [255, 255, 255, 0] }).collect();
    let texture = b.texture(8, 8, texels, true);
    let grey = b.material(diffuse(0.5));
    let grid = b.material(cut_out(texture));
    b.floor(grey, 0.0, 2.0);
    b.floor(grid, 1.0, 1.0);
    b.light(Light::Directional { direction: Vec3::NEG_Y, irradiance: tinted(2.0) });
    let settings = Settings { bounces: 0, ..small(96) };
    let picture = picture(&b.build(), &look(dvec3(0.0, 0.8, 2.6), dvec3(0.0, 0.0, 0.0), 60.0), &settings);
    // Square of the grid that p lies under, as (column, row) and the distance to its nearest side.
    let cell = |p: DVec3| {
        let (u, v) = ((p.x + 1.0) * 4.0, (1.0 - p.z) * 4.0);
        let side = |x: f64| (x - x.round()).abs();
        ((u.floor() as i64, v.floor() as i64), side(u).min(side(v)))
    };
    let floor = |p: DVec3| p.y.abs() < 1e-4;
    let expected = |p: DVec3| {
        let ((column, row), distance) = cell(p);
        let under = inside(p, 1.0);
        let open = !under || (column + row) % 2 == 1;
        (floor(p) && distance > 0.02).then_some(if open { 2.0 } else { 0.0 })
    };
    let deviation = against(&picture, "irradiance_direct", TINT, |p, _| expected(p));
    assert_close("light through a mask", deviation, 1e-4, 1e-3, 1e-4);
    let shaded = picture.xyz("P").unwrap();
    let at = |i: usize| DVec3::from(shaded.map(|plane| f64::from(plane[i])));
    let counts = (0..shaded[0].len()).filter_map(|i| expected(at(i)).filter(|_| inside(at(i), 1.0)));
    let (open, closed): (Vec<f64>, Vec<f64>) = counts.partition(|e| *e > 0.0);
    assert!(open.len() > 50 && closed.len() > 50, "{} open, {} closed", open.len(), closed.len());
}

/// A wall of two triangles, half of it cut out, lit at right angles by a sun that grazes the floor: E = (ρ/π)·E₀ times that
/// of the other half, whatever colour the texture has where nothing is, and however few cells the wall has.
#[test]
fn what_is_cut_out_of_a_wall_has_no_part_in_its_radiance() {
    let (irradiance, linear_of_127) = (3.0, ((127.0 / 255.0 + 0.055) / 1.055f64).powf(2.4));
    let present = parallelogram(DVec3::ZERO, DVec3::Z, DVec3::Y);
    for (there, absent, factor) in [(255, 0, 1.0), (127, 255, linear_of_127)] {
        let mut b = Builder::default();
        let texture = b.texture(2, 1, vec![[there, there, there, 255], [absent, absent, absent, 0]], true);
        let (wall, black) = (b.material(cut_out(texture)), b.material(diffuse(0.0)));
        b.quad(wall, Vec3::Z, Vec3::NEG_Z * 2.0, Vec3::Y);
        b.quad(black, vec3(0.0, 0.0, 2.0), Vec3::X * 3.0, Vec3::NEG_Z * 4.0);
        b.light(Light::Directional { direction: Vec3::NEG_X, irradiance: tinted(irradiance as f32) });
        let scene = b.build();
        let camera = look_parallel(dvec3(1.5, 4.0, 0.0), dvec3(1.5, 0.0, 0.0), 1.4);
        let settings = Settings { surface_cells: Some(4), ..small(48) };
        for settings in each_capture(settings) {
            let picture = picture(&scene, &camera, &settings);
            let floor = |p: DVec3, n: DVec3| n.y > 0.9 && p.x > 0.2;
            let radiance = 0.8 * factor * irradiance / PI;
            let expected = |p, n| floor(p, n).then(|| radiance * polygon(p, n, &present));
            let deviation = against(&picture, "irradiance", TINT, expected);
            // Texels are on one side of the wall's end or the other, as a whole: the furthest off is half a texel's diagonal, as
            // captures are turned. Beside the wall the light of half of a 32nd is a fifth of the mean.
            let off = 0.2 * 2f64.sqrt();
            assert_close(&format!("wall of {there}, cut out at {absent}"), deviation, 0.02, off, 0.005);
        }
    }
}

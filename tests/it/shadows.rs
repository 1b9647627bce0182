//! Shadows of direct light end where the geometry ends, whatever the shadow map's texels, and let nothing through.

use crate::common::build::{Facing, diffuse, emitter};
use crate::common::{Builder, assert_same_bits, draw, gpu, look, look_parallel, picture, small};
use glam::{DVec3, Vec3, dvec3, vec3};
use hemicube::image::Picture;
use hemicube::renderer::Settings;
use hemicube::scene::Light;

fn direct(side: u32) -> Settings {
    Settings { bounces: 0, ..small(side) }
}

/// Floor points and whether they are lit.
fn floor_points(picture: &Picture) -> impl Iterator<Item = (DVec3, bool)> {
    let (p, n, e) = (picture.xyz("P").unwrap(), picture.xyz("N").unwrap(), picture.rgb("irradiance_direct").unwrap());
    let mask = picture.scalar("mask").unwrap();
    (0..mask.len()).filter(move |i| mask[*i] == 1.0 && p[1][*i].abs() < 1e-4 && n[1][*i] > 0.9).map(move |i| {
        let at = DVec3::from(p.map(|plane| f64::from(plane[i])));
        (at, e[0][i] > 0.0)
    })
}

/// The lights that the tests of edges use, each above the floor near (0, 2, 0).
fn lights() -> [(&'static str, Light); 3] {
    let (position, intensity, direction) = (vec3(0.3, 2.0, 0.2), Vec3::ONE, vec3(0.3, -1.0, 0.2).normalize());
    let spot = Light::Spot { position, direction: Vec3::NEG_Y, intensity, cos_inner: 0.7, cos_outer: 0.6 };
    [
        ("sun", Light::Directional { direction, irradiance: Vec3::ONE }),
        ("point", Light::Point { position, intensity }),
        ("spot", spot),
    ]
}

/// Where the ray from a floor point to the light meets the plane y = `height`.
fn above(light: &Light, p: DVec3, height: f64) -> DVec3 {
    match light {
        Light::Directional { direction, .. } => p - direction.as_dvec3() * (height / f64::from(-direction.y)),
        Light::Point { position, .. } | Light::Spot { position, .. } => {
            p + (position.as_dvec3() - p) * (height / f64::from(position.y))
        }
    }
}

/// A plate's shadow on a floor, seen so near that a texel of the map is many pixels: each pixel is as the closed form says. Only
/// the plate's corner, where it is thinner than a texel, may let light through on devices that round it to a coarse part of one: no
/// texel's centre may lie in it there.
#[test]
fn shadow_edges_lie_where_the_closed_form_has_them() {
    // An edge askew to every map's axes, and a corner of the plate.
    let (u, v) = (vec3(0.8, 0.0, 0.31), vec3(-0.2, 0.0, 0.7));
    let corner = vec3(-0.21, 0.6, -0.17);
    for (name, light) in lights() {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 20.0);
        b.quad(grey, corner, u, v);
        b.light(light);
        let edge = corner.as_dvec3() + 0.02 * u.as_dvec3();
        let foot = {
            // The floor point whose ray passes the plate's corner.
            let q = edge;
            match light {
                Light::Directional { direction, .. } => q + direction.as_dvec3() * (q.y / f64::from(-direction.y)),
                Light::Point { position, .. } | Light::Spot { position, .. } => {
                    let l = position.as_dvec3();
                    l + (q - l) * (l.y / (l.y - q.y))
                }
            }
        };
        let half = 0.03;
        let camera = look_parallel(foot + 0.3 * DVec3::Y, foot, half);
        let picture = picture(&b.build(), &camera, &direct(96));
        // Coordinates in the plate, from 0 to 1 inside.
        let (u, v) = (u.as_dvec3(), v.as_dvec3());
        let inside = |p: DVec3| {
            let d = above(&light, p, f64::from(corner.y)) - corner.as_dvec3();
            let area = u.x * v.z - u.z * v.x;
            let (s, t) = ((d.x * v.z - d.z * v.x) / area, (u.x * d.z - u.z * d.x) / area);
            s.min(1.0 - s).min(t.min(1.0 - t))
        };
        // A pixel is 0.0006 wide; the map's texels are about 0.01 (sun), 0.008 (point) and 0.002 (spot).
        let margin = 1e-5;
        const TEXELS_DIAGONAL: f64 = 0.0142;
        let may_miss = |p: DVec3| {
            let to_corner = above(&light, p, f64::from(corner.y)) - corner.as_dvec3();
            to_corner.length() < TEXELS_DIAGONAL && gpu().capabilities.limits.sub_pixel_precision_bits < 8
        };
        let (mut lit, mut dark, mut wrong, mut missed) = (0, 0, 0, 0);
        for (p, is_lit) in floor_points(&picture) {
            let depth = inside(p);
            if depth.abs() < margin {
                continue;
            }
            let should = depth < 0.0;
            (lit, dark) = (lit + u32::from(should), dark + u32::from(!should));
            let is_missed = is_lit && !should && may_miss(p);
            (wrong, missed) = (wrong + u32::from(is_lit != should && !is_missed), missed + u32::from(is_missed));
        }
        eprintln!("{name}: {lit} lit, {dark} dark, {wrong} wrong, {missed} missed of the corner");
        assert!(lit > 1000 && dark > 1000, "{name}: {lit} lit, {dark} dark");
        assert_eq!(wrong, 0, "{name}");
    }
}

/// A plate cut into slivers that all share edges with their neighbours, one fan about an inner point: no ray gets through,
/// though the slivers are far narrower than a texel of the map.
#[test]
fn no_light_gets_through_shared_edges() {
    let lights = lights().map(|(name, light)| (name, Some(light))).into_iter().chain([("lamp", None)]);
    for (name, light) in lights {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 0.3);
        let rim = |i: u32| {
            let a = f64::from(i % 1500) / 1500.0 * std::f64::consts::TAU;
            dvec3(1.6 * a.cos(), 1.0, 1.6 * a.sin()).as_vec3()
        };
        for i in 0..1500 {
            b.triangle(grey, [vec3(0.07, 1.02, 0.03), rim(i + 1), rim(i)]);
        }
        match light {
            Some(light) => b.light(light),
            None => {
                let lamp = b.material(emitter(Vec3::splat(1e6)));
                b.ceiling(lamp, 1.5, 0.3);
            }
        }
        let picture = picture(&b.build(), &look_parallel(dvec3(0.0, 0.5, 0.0), DVec3::ZERO, 0.29), &direct(128));
        let lit = floor_points(&picture).filter(|(_, lit)| *lit).count();
        assert_eq!(lit, 0, "{name}: pixels under the fan are lit");
    }
}

/// A house without thickness on open ground: its walls stand in the middle of the ground's triangles.
#[test]
fn no_light_gets_under_walls_that_stand_on_the_ground() {
    for (name, light) in lights().into_iter().filter(|(name, _)| *name != "spot") {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 3.0);
        // No floor of its own.
        let (low, high) = (vec3(0.52, 0.0, 0.41), vec3(1.13, 0.7, 0.97));
        let size = high - low;
        b.quad(grey, low, Vec3::X * size.x, Vec3::Y * size.y);
        b.quad(grey, low, Vec3::Z * size.z, Vec3::Y * size.y);
        b.quad(grey, high, -Vec3::X * size.x, -Vec3::Y * size.y);
        b.quad(grey, high, -Vec3::Z * size.z, -Vec3::Y * size.y);
        b.quad(grey, high, -Vec3::X * size.x, -Vec3::Z * size.z);
        b.light(light);
        let eye = (low + high).as_dvec3() * 0.5;
        let picture = picture(&b.build(), &look(eye, eye * dvec3(1.0, 0.0, 1.0), 100.0), &direct(128));
        let inside = |p: DVec3| p.x > 0.52 && p.x < 1.13 && p.z > 0.41 && p.z < 0.97;
        let (mut all, mut lit) = (0, 0);
        for (p, is_lit) in floor_points(&picture) {
            assert!(inside(p) || (p - eye).abs().max_element() < 0.4, "the camera sees the inside alone");
            all += 1;
            lit += u32::from(is_lit);
        }
        assert!(all > 5000, "{all} pixels");
        assert_eq!(lit, 0, "{name}: lit pixels of {all}");
    }
}

/// A sun that grazes a ball of many triangles, and plates that lie on each other: what faces the sun is lit.
#[test]
fn lit_surfaces_do_not_shadow_themselves() {
    let direction = vec3(1.0, -0.3, 0.2).normalize();
    for n in [8, 24, 96] {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.sphere(grey, Vec3::ZERO, 1.0, n, Facing::Out);
        b.light(Light::Directional { direction, irradiance: Vec3::ONE });
        let eye = -direction.as_dvec3() * 3.0 + dvec3(0.3, 1.2, 0.0);
        let picture = picture(&b.build(), &look(eye, DVec3::ZERO, 45.0), &direct(128));
        let (p, e, mask) =
            (picture.xyz("P").unwrap(), picture.rgb("irradiance_direct").unwrap(), picture.scalar("mask").unwrap());
        let cosine = |i: usize| -DVec3::from(p.map(|c| f64::from(c[i]))).normalize().dot(direction.as_dvec3());
        // A facet's normal is up to half its diagonal from the ball's: π/2n along each of two axes.
        let facing = 2.3 / f64::from(n);
        let lit: Vec<usize> = (0..mask.len()).filter(|i| mask[*i] == 1.0 && cosine(*i) > facing).collect();
        let dark = lit.iter().filter(|i| e[0][**i] == 0.0).count();
        assert!(lit.len() > 1000);
        assert_eq!(dark, 0, "{n}: dark pixels of {} on the lit side of a ball", lit.len());
    }
    for (name, light) in lights() {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 1.0);
        // The same once more, cut otherwise and facing down, and once more shifted.
        b.ceiling(grey, 0.0, 1.0);
        b.quad(grey, vec3(-0.7, 0.0, 0.5), Vec3::X, Vec3::NEG_Z);
        b.light(light);
        let picture = picture(&b.build(), &look(dvec3(0.0, 1.0, 0.9), DVec3::ZERO, 50.0), &direct(96));
        let dark = floor_points(&picture).filter(|(_, lit)| !lit).count();
        assert_eq!(dark, 0, "{name}: dark pixels on plates that lie on each other");
    }
}

#[test]
fn shadows_are_the_same_twice() {
    let scene = || {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.floor(grey, 0.0, 2.0);
        b.sphere(grey, vec3(0.1, 0.6, 0.0), 0.4, 40, Facing::Out);
        for (_, light) in lights() {
            b.light(light);
        }
        b.build()
    };
    let [a, b] = [(); 2].map(|()| draw(&scene(), &look(dvec3(1.0, 2.0, 2.0), DVec3::ZERO, 50.0), &small(64)).picture);
    assert_same_bits(&a, &b, "shadows");
}

//! Point lights, suns and spots, and their shadows.

use crate::common::build::{Facing, diffuse};
use crate::common::closed_forms::{crosses_box, point_light, spot_factor};
use crate::common::{Builder, TINT, against, assert_close, look, picture, small, tinted};
use glam::{DVec3, dvec3};
use hemicube::image::Picture;
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Light, Scene};

const BOX: [DVec3; 2] = [dvec3(-0.3, 0.3, -0.2), dvec3(0.2, 0.7, 0.3)];

fn floor_and_box(light: Light) -> Scene {
    let mut b = Builder::default();
    let grey = b.material(diffuse(0.5));
    b.floor(grey, 0.0, 2.0);
    b.cuboid(grey, BOX[0].as_vec3(), BOX[1].as_vec3(), Facing::Out);
    b.light(light);
    b.build()
}

/// Direct light on the floor: `lit` where the segment to the light passes the box, 0 where it meets it, nothing said
/// within `margin` of the shadow's edge.
fn shadowed(
    picture: &Picture,
    margin: f64,
    to_light: impl Fn(DVec3) -> DVec3,
    lit: impl Fn(DVec3, DVec3) -> f64,
) -> [crate::common::Deviation; 2] {
    let floor = |p: DVec3| p.y.abs() < 1e-4;
    let meets = |p: DVec3, margin| crosses_box(p, to_light(p), BOX[0], BOX[1], margin);
    let light = against(picture, "irradiance_direct", TINT, |p, n| (floor(p) && !meets(p, margin)).then(|| lit(p, n)));
    // Compared with 0 there is no relative error: one is added on both sides by way of the light unshadowed.
    let dark = {
        let (p, e) = (picture.xyz("P").unwrap(), picture.rgb("irradiance_direct").unwrap());
        let at = |i: usize| DVec3::from(p.map(|plane| f64::from(plane[i])));
        let shaded: Vec<usize> = (0..p[0].len()).filter(|i| floor(at(*i)) && meets(at(*i), -margin)).collect();
        assert!(shaded.len() > 20, "{} pixels in shadow", shaded.len());
        let sum: f64 = shaded.iter().map(|i| f64::from(e[0][*i] + e[1][*i] + e[2][*i])).sum();
        crate::common::Deviation { mean: sum, max: sum, energy: 1.0, pixels: shaded.len() }
    };
    [light, dark]
}

fn above() -> Camera {
    look(dvec3(0.0, 2.5, 2.5), dvec3(0.0, 0.0, 0.0), 45.0)
}

#[test]
fn a_point_light_and_its_shadow() {
    let light = dvec3(0.3, 1.6, -0.2);
    let scene = floor_and_box(Light::Point { position: light.as_vec3(), intensity: tinted(4.0) });
    let picture = picture(&scene, &above(), &Settings { bounces: 0, ..small(96) });
    let [lit, dark] = shadowed(&picture, 0.01, |_| light, |p, n| 4.0 * point_light(p, n, light));
    assert_close("I·cosθ/d²", lit, 1e-4, 1e-3, 1e-4);
    assert_close("a point light's shadow", dark, 0.0, 0.0, 0.0);
}

#[test]
fn a_sun_and_its_shadow() {
    let direction = dvec3(0.4, -1.0, 0.3).normalize();
    let scene = floor_and_box(Light::Directional { direction: direction.as_vec3(), irradiance: tinted(5.0) });
    let picture = picture(&scene, &above(), &Settings { bounces: 0, ..small(96) });
    let [lit, dark] = shadowed(&picture, 0.01, |p| p - 10.0 * direction, |_, n| 5.0 * n.dot(-direction));
    assert_close("E·cosθ", lit, 1e-4, 1e-3, 1e-4);
    assert_close("a sun's shadow", dark, 0.0, 0.0, 0.0);
}

#[test]
fn a_spot_its_cone_and_its_shadow() {
    for (inner, outer) in [(15.0f64, 30.0), (20.0, 80.0)] {
        let (light, axis) = (dvec3(0.3, 1.6, -0.2), dvec3(-0.1, -1.0, 0.1).normalize());
        let [cos_inner, cos_outer] = [inner, outer].map(|degrees: f64| degrees.to_radians().cos());
        let scene = floor_and_box(Light::Spot {
            position: light.as_vec3(),
            direction: axis.as_vec3(),
            intensity: tinted(4.0),
            cos_inner,
            cos_outer,
        });
        let picture = picture(&scene, &above(), &Settings { bounces: 0, ..small(96) });
        let lit = |p: DVec3, n| {
            let cosine = (p - light).normalize().dot(axis);
            4.0 * point_light(p, n, light) * spot_factor(cosine, cos_inner, cos_outer)
        };
        let [lit, dark] = shadowed(&picture, 0.01, |_| light, lit);
        assert_close(&format!("spot {inner}°–{outer}°"), lit, 1e-3, 5e-3, 1e-3);
        assert_close("a spot's shadow", dark, 0.0, 0.0, 0.0);
    }
}

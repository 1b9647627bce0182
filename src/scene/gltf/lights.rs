//! Lights and cameras of the nodes that carry them.

use super::Notes;
use super::document::{Document, item};
use super::error::{Fault, Result, Within, label};
use super::nodes::Placed;
use crate::scene::{Camera, Lens, Light};
use glam::{DMat3, DMat4, DVec3, Vec3};
use gltf::json;
use json::extensions::scene::khr_lights_punctual::{self as punctual, Type};
use json::validation::Checked;
use std::f64::consts::{FRAC_PI_2, PI};

/// All lights in node order, relative to `origin`.
pub fn lights(document: &Document, placed: &[Placed], origin: DVec3, notes: &mut Notes) -> Result<Vec<Light>> {
    let mut lights = Vec::new();
    for p in placed.iter().filter(|p| !p.hidden) {
        if let Some(used) = &document.nodes[p.node].extensions.light {
            let light = item(&document.lights, "light", used.light).within(|| document.node_label(p.node))?;
            let converted = light_at(light, p.to_world, origin);
            let at = || label("light", used.light, light.name.as_deref());
            let converted = converted.within(at)?;
            if let Some(what) = hard_or_wide(&converted, light.spot.as_ref()) {
                notes.add(format!("{}: {what}", at()));
            }
            lights.push(converted);
        }
    }
    Ok(lights)
}

/// What a spot's cone is taken for where the file's is not one that glTF allows.
fn hard_or_wide(light: &Light, spot: Option<&punctual::Spot>) -> Option<&'static str> {
    let Light::Spot { cos_inner, cos_outer, .. } = light else { return None };
    let wide = spot.is_some_and(|spot| f64::from(spot.outer_cone_angle) > FRAC_PI_2 + 1e-6);
    match (wide, cos_inner == cos_outer) {
        (true, _) => Some("its outer cone angle is above π/2 and taken as that"),
        (false, true) => Some("its cone angles are equal: its edge is hard"),
        (false, false) => None,
    }
}

fn light_at(light: &punctual::Light, to_world: DMat4, origin: DVec3) -> Result<Light> {
    let intensity = Vec3::from(light.color) * light.intensity;
    if !intensity.is_finite() || intensity.cmplt(Vec3::ZERO).any() {
        return Err(Fault::invalid(format!("intensity {intensity} is negative or not finite")));
    }
    let position = (to_world.w_axis.truncate() - origin).as_vec3();
    if !position.is_finite() {
        return Err(Fault::invalid("its position is beyond single precision"));
    }
    let axis = || {
        let direction = unit(-to_world.z_axis.truncate());
        direction.map(|d| d.as_vec3().normalize()).ok_or_else(|| Fault::invalid("its node's scale leaves no direction"))
    };
    match light.type_ {
        Checked::Valid(Type::Point) => Ok(Light::Point { position, intensity }),
        Checked::Valid(Type::Directional) => Ok(Light::Directional { direction: axis()?, irradiance: intensity }),
        Checked::Valid(Type::Spot) => {
            let (cos_inner, cos_outer) = cone(light.spot.as_ref())?;
            Ok(Light::Spot { position, direction: axis()?, intensity, cos_inner, cos_outer })
        }
        Checked::Invalid => Err(Fault::invalid("type is neither directional nor point nor spot")),
    }
}

/// Cosines of the inner and outer half angles. Equal ones make a hard edge; an outer one above π/2 counts as that.
fn cone(spot: Option<&punctual::Spot>) -> Result<(f64, f64)> {
    let spot = spot.ok_or_else(|| Fault::invalid("a spot light without cone angles"))?;
    let (inner, outer) = (f64::from(spot.inner_cone_angle), f64::from(spot.outer_cone_angle));
    // Angles in degrees for radians are beyond π; π/2 in single precision is a little above it.
    if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= PI + 1e-6) {
        return Err(Fault::invalid(format!("cone angles {inner} and {outer} do not rise within [0, π/2]")));
    }
    Ok((inner.min(FRAC_PI_2).cos().max(0.0), outer.min(FRAC_PI_2).cos().max(0.0)))
}

/// All cameras in node order, relative to `origin`.
pub fn cameras(document: &Document, placed: &[Placed], origin: DVec3, notes: &mut Notes) -> Result<Vec<Camera>> {
    let mut cameras = Vec::new();
    for p in placed {
        let node = &document.nodes[p.node];
        let Some(index) = node.camera else { continue };
        let camera = item(&document.cameras, "camera", index).within(|| document.node_label(p.node))?;
        let at = || label("camera", index, camera.name.as_deref());
        let lens = lens(camera).within(at)?;
        let Some(camera_to_world) = rigid(p.to_world, origin) else {
            notes.add(format!("{} is left out: its node's scale leaves no direction", at()));
            continue;
        };
        let name = node.name.clone().filter(|n| !n.is_empty()).or_else(|| camera.name.clone()).unwrap_or_default();
        cameras.push(Camera { name, camera_to_world, lens });
    }
    Ok(cameras)
}

fn lens(camera: &json::Camera) -> Result<Lens> {
    match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) => {
            let yfov = f64::from(p.yfov);
            if !(yfov > 0.0 && yfov < PI) {
                return Err(Fault::invalid(format!("yfov {yfov} is not between 0 and π")));
            }
            let aspect = p.aspect_ratio.map(f64::from);
            if aspect.is_some_and(|a| !(a > 0.0 && a.is_finite())) {
                return Err(Fault::invalid(format!("aspectRatio {} is not positive", aspect.unwrap_or(0.0))));
            }
            Ok(Lens::Perspective { yfov, aspect })
        }
        (None, Some(o)) => {
            let ymag = f64::from(o.ymag).abs();
            if !(ymag > 0.0 && ymag.is_finite()) {
                return Err(Fault::invalid("ymag is 0 or not finite"));
            }
            let aspect = Some(f64::from(o.xmag).abs() / ymag).filter(|aspect| *aspect > 0.0 && aspect.is_finite());
            Ok(Lens::Orthographic { ymag, aspect })
        }
        (None, None) => Err(Fault::invalid("has neither perspective nor orthographic")),
    }
}

/// The transform without scale, shear or mirroring: view axis and up as they are, right follows.
fn rigid(to_world: DMat4, origin: DVec3) -> Option<DMat4> {
    let back = unit(to_world.z_axis.truncate())?;
    let right = unit(unit(to_world.y_axis.truncate())?.cross(back))?;
    let rotation = DMat3::from_cols(right, back.cross(right), back);
    Some(DMat4::from_mat3_translation(rotation, to_world.w_axis.truncate() - origin))
}

/// `v` with length 1, whatever its size; `None` where it has no direction.
fn unit(v: DVec3) -> Option<DVec3> {
    (v / v.abs().max_element()).try_normalize()
}

//! The result's planes as a picture.

use crate::image::Picture;
use crate::passes::resolve::Plane;
use glam::DVec3;

/// Channel names of a plane.
fn channels(plane: Plane) -> Vec<String> {
    let rgb = |layer: &str| ["R", "G", "B"].map(|c| format!("{layer}.{c}")).to_vec();
    let xyz = |layer: &str| ["X", "Y", "Z"].map(|c| format!("{layer}.{c}")).to_vec();
    match plane {
        Plane::Final => ["R", "G", "B"].map(String::from).to_vec(),
        Plane::Direct => rgb("direct"),
        Plane::Indirect => rgb("indirect"),
        Plane::Irradiance => rgb("irradiance"),
        Plane::DirectIrradiance => rgb("irradiance_direct"),
        Plane::Albedo => rgb("albedo"),
        Plane::Emission => rgb("emission"),
        Plane::Normal => xyz("N"),
        Plane::Position => xyz("P"),
        Plane::Depth => vec!["Z".into()],
        Plane::Records => vec!["records.Y".into()],
        Plane::Mask => vec!["mask.Y".into()],
    }
}

/// The picture of `planes`, whose `values` are a list a channel; positions get the scene's origin back.
pub(super) fn picture(values: Vec<Vec<f32>>, planes: &[Plane], size: [u32; 2], origin: DVec3) -> Picture {
    let mut picture = Picture { width: size[0], height: size[1], ..Picture::default() };
    let mut all = values.into_iter();
    for plane in planes {
        let mut values: Vec<_> = all.by_ref().take(plane.channels() as usize).collect();
        if *plane == Plane::Position {
            add_origin(&mut values, origin);
        }
        picture.channels.extend(channels(*plane).into_iter().zip(values));
    }
    picture
}

/// Gives positions the scene's origin back. Where nothing is seen they are 0 and stay so.
fn add_origin(axes: &mut [Vec<f32>], origin: DVec3) {
    for pixel in 0..axes.first().map_or(0, Vec::len) {
        if axes.iter().any(|axis| axis[pixel] != 0.0) {
            axes.iter_mut()
                .zip(origin.to_array())
                .for_each(|(axis, o)| axis[pixel] = (f64::from(axis[pixel]) + o) as f32);
        }
    }
}

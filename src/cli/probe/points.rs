//! The file of points, and the file of light at them.

use anyhow::{Context, Result, bail, ensure};
use glam::{DVec3, Vec3};
use hemicube::image::write::{WriteError, write_atomic};
use hemicube::math::{deringing, sh};
use hemicube::scene::Scene;
use serde_json::{Value, json};
use std::path::Path;

/// The points of a file.
pub fn read(path: &Path) -> Result<Vec<DVec3>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read the points {}", path.display()))?;
    points_of(&text).with_context(|| path.display().to_string())
}

fn points_of(text: &str) -> Result<Vec<DVec3>> {
    const SHAPE: &str = "points are written {\"points\": [[x, y, z], …]}";
    let file: Value = serde_json::from_str(text).context("this is not JSON")?;
    let Some(points) = file["points"].as_array() else { bail!("there is no list \"points\"; {SHAPE}") };
    ensure!(!points.is_empty(), "the list \"points\" is empty; give one point at least");
    let point = |(at, value): (usize, &Value)| {
        let numbers: Option<Vec<f64>> = value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
        let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        three.map(DVec3::from).with_context(|| format!("points[{at}] is {value}, not three numbers; {SHAPE}"))
    };
    points.iter().enumerate().map(point).collect()
}

/// The points relative to the scene's origin. Beyond twice the scene's bounds they are taken for a mistake of units or axes.
pub fn within(scene: &Scene, points: &[DVec3]) -> Result<Vec<Vec3>> {
    let (low, high) = scene.bounds();
    let reach = (high - low).max_element();
    let place = |(at, point): (usize, &DVec3)| {
        let place = (*point - scene.origin).as_vec3();
        let inside = place.cmpge(low - reach).all() && place.cmple(high + reach).all();
        ensure!(
            inside,
            "points[{at}] = [{}, {}, {}] lies outside of the scene, whose bounds are {} to {}",
            point.x,
            point.y,
            point.z,
            scene.origin + low.as_dvec3(),
            scene.origin + high.as_dvec3()
        );
        Ok(place)
    };
    points.iter().enumerate().map(place).collect()
}

/// Light at a point.
pub struct Light {
    /// Coefficients of the radiance, of an order that is at least the output's.
    pub coefficients: Vec<DVec3>,
    /// Irradiance along the six directions; by the coefficients without it.
    pub irradiance: Option<[DVec3; 6]>,
    /// Relative standard error of an estimate.
    pub error: Option<f64>,
}

/// The form of the output.
#[derive(Clone, Copy)]
pub struct Output {
    /// Order of the coefficients.
    pub order: u32,
    /// Whether a window ends negative irradiance.
    pub window: bool,
}

/// Writes light at all points. Returns the strength of each window.
pub fn write(path: &Path, lights: &[Light], output: Output) -> Result<Vec<f64>, WriteError> {
    let (points, strengths): (Vec<Value>, Vec<f64>) = lights.iter().map(|light| described(light, output)).unzip();
    let result = json!({ "points": points });
    write_atomic(path, |sink| writeln!(sink, "{result}"))?;
    Ok(strengths)
}

fn described(light: &Light, output: Output) -> (Value, f64) {
    let of_channel = |c: usize| light.coefficients.iter().map(|v| v[c]).collect::<Vec<f64>>();
    let mut channels = [0, 1, 2].map(of_channel);
    let strength = if output.window { deringing::strength(&channels) } else { 0.0 };
    if strength > 0.0 {
        channels = channels.map(|channel| deringing::windowed(&channel, strength));
    }
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let by_harmonics =
        || axes.map(|axis| channels.each_ref().map(|channel| sh::irradiance(channel, axis).max(0.0) as f32)).collect();
    let irradiance: Vec<[f32; 3]> =
        light.irradiance.map_or_else(by_harmonics, |known| known.map(|e| e.as_vec3().to_array()).to_vec());
    let coefficient = |i: usize| channels.each_ref().map(|channel| channel[i] as f32);
    let sh: Vec<[f32; 3]> = (0..sh::count(output.order)).map(coefficient).collect();
    let mut value = json!({"sh": sh, "irradiance": irradiance});
    if output.window {
        value["window"] = json!(strength);
    }
    if let Some(error) = light.error {
        value["se"] = json!(error);
    }
    (value, strength)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_and_what_is_wrong_is_named() {
        assert_eq!(points_of("{\"points\": [[1, 2.5, -3]]}").unwrap(), [DVec3::new(1.0, 2.5, -3.0)]);
        for (text, words) in [
            ("{\"points\": [", "not JSON"),
            ("[[1, 2, 3]]", "no list \"points\""),
            ("{\"points\": []}", "empty"),
            ("{\"points\": [[1, 2, 3], [1, 2]]}", "points[1] is [1,2]"),
            ("{\"points\": [[1, 2, \"3\"]]}", "not three numbers"),
        ] {
            let error = points_of(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    #[test]
    fn points_outside_are_refused_by_number() {
        let scene = hemicube::scene::cornell();
        let inside = scene.origin + DVec3::splat(0.2);
        assert_eq!(within(&scene, &[inside]).unwrap().len(), 1);
        let error = within(&scene, &[inside, DVec3::splat(50.0)]).unwrap_err().to_string();
        assert!(error.contains("points[1] = [50, 50, 50]") && error.contains("bounds"), "{error}");
    }
}

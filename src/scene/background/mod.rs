//! Radiance from outside the scene: the `--background` argument, and looking a direction up.

mod read;

use super::{Background, EnvironmentMap, SceneError};
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::path::Path;

/// Narrower maps are cut finer before they are turned.
const TURNED: u32 = 1024;

/// Extensions of files that are read as maps.
const MAPS: [&str; 2] = ["exr", "hdr"];

impl Background {
    /// Reads `R,G,B` (W·sr⁻¹·m⁻², finite and not negative), or an equirectangular map: the name of an `.exr` file, `#` and
    /// one of its layers behind it where it has several, or of a Radiance `.hdr` file.
    pub fn parse(argument: &str) -> Result<Self, SceneError> {
        Self::parse_noting(argument, &mut Vec::new())
    }

    /// The same; what was tolerated in the file goes to `notes`, a line each.
    pub fn parse_noting(argument: &str, notes: &mut Vec<String>) -> Result<Self, SceneError> {
        let (file, layer) = match argument.rsplit_once('#') {
            Some((file, layer)) if is_map(file) => (file, Some(layer)),
            _ => (argument, None),
        };
        let result = if is_map(file) {
            EnvironmentMap::load_layer(Path::new(file), layer, notes).map(Self::Map)
        } else {
            parse_rgb(argument)
        };
        result.map_err(|what| SceneError::Background { file: argument.replace(char::is_control, " "), what })
    }

    /// The same sky, `strength` times as bright and turned by `degrees` about +Y, counter-clockwise seen from above.
    pub fn adjusted(self, degrees: f32, strength: f32) -> Self {
        let scaled = match self {
            Self::Black => Self::Black,
            Self::Constant(radiance) => Self::Constant(radiance * strength),
            Self::Map(map) => Self::Map(map.turned(degrees).times(strength)),
        };
        if strength == 0.0 { Self::Black } else { scaled }
    }

    /// Radiance that arrives from the unit vector `direction`, W·sr⁻¹·m⁻².
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Black => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(direction),
        }
    }

    /// Whether any radiance can arrive.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Black => true,
            Self::Constant(radiance) => *radiance == Vec3::ZERO,
            Self::Map(map) => map.rgb.iter().flatten().all(|x| *x == 0.0),
        }
    }
}

fn is_map(file: &str) -> bool {
    let extension = Path::new(file).extension();
    extension.is_some_and(|e| MAPS.iter().any(|map| e.eq_ignore_ascii_case(map)))
}

fn parse_rgb(argument: &str) -> Result<Background, String> {
    let parts: Vec<&str> = argument.split(',').collect();
    let [r, g, b] = parts[..] else {
        return Err("is neither three numbers R,G,B nor the name of an .exr or .hdr file".into());
    };
    let mut rgb = [0.0f32; 3];
    for (value, text) in rgb.iter_mut().zip([r, g, b]) {
        *value = text.trim().parse().map_err(|_| format!("\"{}\" is not a number", text.trim()))?;
        if !(value.is_finite() && *value >= 0.0) {
            return Err(format!("{value} is negative or not finite"));
        }
    }
    let constant = Vec3::from(rgb);
    Ok(if constant == Vec3::ZERO { Background::Black } else { Background::Constant(constant) })
}

impl EnvironmentMap {
    /// Solid angle of each texel of a row, sr: exact, so that a row's sum is that of the zone between two heights.
    pub fn solid_angle(&self, row: u32) -> f64 {
        let height = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(self.height)).cos();
        (height(row) - height(row + 1)) * std::f64::consts::TAU / f64::from(self.width)
    }

    /// The map between whose texels the bilinear lookup shows the same, with `factor` times as many of them along each axis.
    pub(crate) fn finer(&self, [across, down]: [u32; 2]) -> Self {
        let (width, height) = (self.width * across, self.height * down);
        let at = |i: u32, factor: u32| {
            let place = (i as f32 + 0.5) / factor as f32 - 0.5;
            (place.floor() as i64, place - place.floor())
        };
        let texel = |i: usize| {
            let ((x, fx), (y, fy)) = (at(i as u32 % width, across), at(i as u32 / width, down));
            let row = |y| self.texel(x, y).lerp(self.texel(x + 1, y), fx);
            row(y).lerp(row(y + 1), fy).to_array()
        };
        Self { width, height, rgb: (0..width as usize * height as usize).map(texel).collect() }
    }

    fn turned(self, degrees: f32) -> Self {
        let turns = (f64::from(degrees) / 360.0).rem_euclid(1.0);
        if turns == 0.0 {
            return self;
        }
        // Between texels a turn blurs by a texel: a small one.
        let map = if self.width < TURNED { self.finer([TURNED.div_ceil(self.width), 1]) } else { self };
        let shift = turns * f64::from(map.width);
        let (whole, part) = (shift.floor() as i64, shift.fract() as f32);
        let texel = |i: usize| {
            let (x, y) = ((i % map.width as usize) as i64 + whole, (i / map.width as usize) as i64);
            map.texel(x, y).lerp(map.texel(x + 1, y), part).to_array()
        };
        let rgb = (0..map.rgb.len()).map(texel).collect();
        Self { rgb, ..map }
    }

    fn times(mut self, strength: f32) -> Self {
        self.rgb.as_flattened_mut().iter_mut().for_each(|x| *x *= strength);
        self
    }

    /// Place of a unit vector in the map, each coordinate in [0, 1], v = 0 at the top.
    pub fn direction_to_uv(direction: Vec3) -> [f32; 2] {
        let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
        [u, direction.y.clamp(-1.0, 1.0).acos() / PI]
    }

    /// Unit vector of a place in the map; the inverse of [`Self::direction_to_uv`].
    pub fn uv_to_direction([u, v]: [f32; 2]) -> Vec3 {
        let ((sin_theta, y), (sin_phi, cos_phi)) = ((v * PI).sin_cos(), ((u - 0.5) * TAU).sin_cos());
        Vec3::new(sin_theta * sin_phi, y, -sin_theta * cos_phi)
    }

    /// Radiance from the unit vector `direction`: bilinear, going round horizontally, ending at the poles.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [u, v] = Self::direction_to_uv(direction);
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let row = |dy| {
            let (a, b) = (self.texel(x0 as i64, y0 as i64 + dy), self.texel(x0 as i64 + 1, y0 as i64 + dy));
            a.lerp(b, fx)
        };
        row(0).lerp(row(1), fy)
    }

    fn texel(&self, x: i64, y: i64) -> Vec3 {
        let x = x.rem_euclid(i64::from(self.width)) as usize;
        let y = y.clamp(0, i64::from(self.height) - 1) as usize;
        self.rgb[y * self.width as usize + x].into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, height: u32, rgb: Vec<[f32; 3]>) -> EnvironmentMap {
        EnvironmentMap { width, height, rgb }
    }

    #[test]
    fn three_numbers_are_a_constant() {
        assert!(matches!(Background::parse("1, 2,0.5"), Ok(Background::Constant(c)) if c == Vec3::new(1.0, 2.0, 0.5)));
        assert!(matches!(Background::parse("0,0,0"), Ok(Background::Black)));
        for bad in ["", "1", "1,2", "1,2,3,4", "1,2,x", "1,-2,3", "1,nan,3", "inf,0,0", "missing.exr"] {
            let line = Background::parse(bad).unwrap_err().to_string();
            assert!(line.starts_with(&format!("background {bad}: ")) && !line.contains('\n'), "{line}");
        }
    }

    #[test]
    fn directions_and_places_are_inverse() {
        let places = [(Vec3::NEG_Z, [0.5, 0.5]), (Vec3::X, [0.75, 0.5]), (Vec3::NEG_X, [0.25, 0.5])];
        for (direction, uv) in places {
            assert_eq!(EnvironmentMap::direction_to_uv(direction), uv);
            assert!((EnvironmentMap::uv_to_direction(uv) - direction).length() < 1e-6);
        }
        assert_eq!(EnvironmentMap::direction_to_uv(Vec3::Y)[1], 0.0);
        let d = Vec3::new(0.3, -0.5, 0.7).normalize();
        assert!((EnvironmentMap::uv_to_direction(EnvironmentMap::direction_to_uv(d)) - d).length() < 1e-6);
    }

    #[test]
    fn lookup_is_exact_at_texel_centres_and_goes_round() {
        let m = map(4, 2, (0..8).map(|i| [i as f32, 0.0, 1.0]).collect());
        let at = |x: f32, y: f32| m.radiance(EnvironmentMap::uv_to_direction([x / 4.0, y / 2.0])).x;
        for i in 0..8 {
            assert!((at((i % 4) as f32 + 0.5, (i / 4) as f32 + 0.5) - i as f32).abs() < 1e-5);
        }
        assert!((at(4.0, 0.5) - 1.5).abs() < 1e-5, "between the last and the first column");
        assert!((at(0.5, 1.0) - 2.0).abs() < 1e-5, "between the rows");
    }

    #[test]
    fn a_file_comes_back_and_bad_texels_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bad: f32| {
            let path = folder.path().join(name);
            let pixel = |x: usize, y: usize| (x as f32, y as f32, if (x, y) == (2, 1) { bad } else { 1.0 });
            exr::prelude::write_rgb_file(&path, 4, 2, pixel).unwrap();
            Background::parse(path.to_str().unwrap())
        };
        let Ok(Background::Map(m)) = write("good.exr", 3.0) else { panic!("a map") };
        assert_eq!((m.width, m.height, m.rgb[6]), (4, 2, [2.0, 1.0, 3.0]));
        for (name, bad) in [("nan.exr", f32::NAN), ("infinite.exr", f32::INFINITY)] {
            let line = write(name, bad).unwrap_err().to_string();
            assert!(line.contains("pixel (2, 1)"), "{line}");
        }
    }
}

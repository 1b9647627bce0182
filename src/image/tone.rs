//! From radiance to what a screen shows: exposure, tone curve, sRGB code values; and false colour.

use std::fmt;
use std::str::FromStr;

/// How radiance is brought into the range of a screen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// AgX (Sobotka 2022): 16.5 stops, bright colours go to white without changing hue abruptly.
    #[default]
    Agx,
    /// Values as they are, cut at 0 and 1, with the sRGB transfer function: for comparisons and data.
    Srgb,
    /// `L / (1 + L)` on the luminance (Reinhard et al. 2002, eq. 3), then sRGB.
    Reinhard,
}

/// A tone map and the exposure before it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Look {
    /// The curve.
    pub tone: ToneMap,
    /// Exposure in stops: radiance is multiplied by 2 to this power.
    pub stops: f32,
}

/// The exposure of a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Exposure {
    /// By the picture's own luminance: [`auto_stops`].
    #[default]
    Auto,
    /// In stops.
    Stops(f32),
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse::<f32>() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(stops) if stops.abs() <= 100.0 => Ok(Self::Stops(stops)),
            _ => Err("neither auto nor a number of stops from -100 to 100".into()),
        }
    }
}

/// Stops that bring the picture's log-average luminance to middle grey (Reinhard et al. 2002, eq. 1 and 2). The darkest
/// and the brightest twentieth do not count, and neither do black and what is no number; 0 for a picture without light.
pub fn auto_stops([r, g, b]: [&[f32]; 3]) -> f32 {
    let all = r.iter().zip(g).zip(b).map(|((r, g), b)| luminance([*r, *g, *b]));
    let mut lit: Vec<f32> = all.filter(|l| l.is_finite() && *l > 0.0).collect();
    lit.sort_unstable_by(f32::total_cmp);
    let cut = lit.len() / 20;
    let middle = &lit[cut..lit.len() - cut];
    if middle.is_empty() {
        return 0.0;
    }
    let mean = middle.iter().map(|l| f64::from(*l).log2()).sum::<f64>() / middle.len() as f64;
    (f64::from(MIDDLE_GREY).log2() - mean).clamp(-100.0, 100.0) as f32
}

impl FromStr for ToneMap {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "agx" => Ok(Self::Agx),
            "srgb" | "linear" => Ok(Self::Srgb),
            "reinhard" => Ok(Self::Reinhard),
            _ => Err(format!("there is no tone map {name:?}; tone maps are: agx, srgb, reinhard")),
        }
    }
}

impl fmt::Display for ToneMap {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Agx => "agx",
            Self::Srgb => "srgb",
            Self::Reinhard => "reinhard",
        })
    }
}

/// Shown where a value is not a number, so that it is seen rather than taken for black.
pub const NAN_COLOUR: [u8; 3] = [255, 0, 255];

impl Look {
    /// 8-bit sRGB code values of a linear Rec.709 colour. Rounded to nearest, without dithering: same input, same bytes.
    pub fn apply(&self, rgb: [f32; 3]) -> [u8; 3] {
        if rgb.iter().any(|value| value.is_nan()) {
            return NAN_COLOUR;
        }
        let scale = self.stops.exp2();
        // An infinite value would turn into NaN in the matrices; this is far above every curve's white.
        let exposed = rgb.map(|value| (value * scale).clamp(0.0, 1e9));
        let coded = match self.tone {
            ToneMap::Agx => agx(exposed),
            ToneMap::Srgb => exposed.map(srgb_encode),
            ToneMap::Reinhard => {
                let shown = 1.0 / (1.0 + luminance(exposed));
                exposed.map(|value| srgb_encode(value * shown))
            }
        };
        coded.map(|value| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
    }
}

/// Relative luminance of linear Rec.709 (ITU-R BT.709-6, item 3.2).
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// sRGB code value, 0 to 1, of a linear one (IEC 61966-2-1).
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.0031308 { 12.92 * linear.max(0.0) } else { 1.055 * linear.min(1.0).powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of an sRGB code value, both 0 to 1 (IEC 61966-2-1).
pub fn srgb_decode(coded: f32) -> f32 {
    if coded <= 0.04045 { coded / 12.92 } else { ((coded + 0.055) / 1.055).powf(2.4) }
}

type Matrix = [[f32; 3]; 3];

/// Rec.709 to AgX's working space, its primaries moved inwards (Sobotka, "AgX"; digits as in Wrensch 2023,
/// "Minimal AgX Implementation"). Rows.
const AGX_INSET: Matrix = [
    [0.842_479_06, 0.078_433_6, 0.079_223_745],
    [0.042_328_242, 0.878_468_64, 0.079_166_13],
    [0.042_375_655, 0.078_433_6, 0.879_143],
];

/// Its inverse. Rows.
const AGX_OUTSET: Matrix = [
    [1.196_879, -0.098_020_88, -0.099_029_74],
    [-0.052_896_85, 1.151_903_1, -0.098_961_18],
    [-0.052_971_635, -0.098_043_45, 1.151_073_7],
];

/// Middle grey, and AgX's range around it: 10 stops below and 6.5 above.
const MIDDLE_GREY: f32 = 0.18;
const STOPS_BELOW: f32 = 10.0;
const STOPS_ABOVE: f32 = 6.5;

/// AgX's base look, as sRGB code values.
fn agx(rgb: [f32; 3]) -> [f32; 3] {
    let encode = |value: f32| {
        let stops = (value.max(1e-10) / MIDDLE_GREY).log2();
        agx_curve(((stops + STOPS_BELOW) / (STOPS_BELOW + STOPS_ABOVE)).clamp(0.0, 1.0))
    };
    multiply(&AGX_OUTSET, multiply(&AGX_INSET, rgb).map(encode))
}

/// Sobotka's sigmoid itself rather than a polynomial through it: `y₀ + s(x−x₀) / (1 + a|x−x₀|^p)^(1/p)` with slope
/// s = 2 through middle grey (x₀ = 10/16.5, y₀ = 0.5) and power p = 3 below, 3.25 above. `a` follows from the ends,
/// f(0) = 0 and f(1) = 1: with length l to the end, `a = ((s·l/y₀)^p − 1) / l^p`.
fn agx_curve(x: f32) -> f32 {
    const SLOPE: f32 = 2.0;
    const X0: f32 = STOPS_BELOW / (STOPS_BELOW + STOPS_ABOVE);
    let (power, length) = if x < X0 { (3.0, X0) } else { (3.25, 1.0 - X0) };
    let a = ((SLOPE * length / 0.5f32).powf(power) - 1.0) / length.powf(power);
    0.5 + SLOPE * (x - X0) / (1.0 + a * (x - X0).abs().powf(power)).powf(1.0 / power)
}

fn multiply(rows: &Matrix, v: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// False colour of a value from 0 to 1 as sRGB code values: dark blue, green, yellow, dark red.
///
/// Turbo (Mikhailov 2019, "Turbo, An Improved Rainbow Colormap"), by the polynomial fit of degree 5 given with it.
pub fn turbo(value: f32) -> [u8; 3] {
    const FIT: [[f32; 6]; 3] = [
        [0.135_721_38, 4.615_392_6, -42.660_324, 132.131_1, -152.942_4, 59.286_38],
        [0.091_402_61, 2.194_188_4, 4.842_966_6, -14.185_033, 4.277_298_6, 2.829_566],
        [0.106_673_3, 12.641_946, -60.582_047, 110.362_77, -89.903_11, 27.348_25],
    ];
    if value.is_nan() {
        return NAN_COLOUR;
    }
    let x = value.clamp(0.0, 1.0);
    FIT.map(|c| c.iter().rev().fold(0.0, |sum, factor| sum * x + factor))
        .map(|y| (y.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agx_curve_meets_its_ends_and_its_published_constants() {
        assert!(agx_curve(0.0).abs() < 1e-6 && (agx_curve(1.0) - 1.0).abs() < 1e-6);
        assert!((agx_curve(20.0 / 33.0) - 0.5).abs() < 1e-6);
        // Wrensch's polynomial of degree 6, published with a mean squared error of some 4e-6 against Sobotka's table.
        let fit = |x: f32| {
            [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232].iter().fold(0.0, |sum, factor| sum * x + factor)
        };
        let squared = (0..=1000).map(|i| i as f32 / 1000.0).map(|x| (agx_curve(x) - fit(x)).powi(2));
        assert!(squared.sum::<f32>() / 1001.0 < 1e-5);
    }

    #[test]
    fn exposure_by_itself_takes_away_any_scale() {
        let ramp: Vec<f32> = (0..1000).map(|i| 0.18 * ((i as f32 - 499.5) / 200.0).exp2()).collect();
        for stops in [-40.0f32, -15.0, 0.0, 3.0, 60.0] {
            let scaled: Vec<f32> = ramp.iter().map(|l| l * stops.exp2()).collect();
            assert!((auto_stops([&scaled; 3]) + stops).abs() < 0.01, "{stops}");
        }
        let mut odd = vec![0.0, f32::NAN, f32::INFINITY, -1.0];
        assert_eq!(auto_stops([&odd; 3]), 0.0);
        odd.extend([0.18; 100]);
        odd.extend([1e6; 4]);
        assert!(auto_stops([&odd; 3]).abs() < 1e-3, "a few bright pixels do not count");
        assert_eq!("auto".parse(), Ok(Exposure::Auto));
        assert_eq!("-2.5".parse(), Ok(Exposure::Stops(-2.5)));
        assert!("nan".parse::<Exposure>().is_err() && "1e9".parse::<Exposure>().is_err());
    }

    #[test]
    fn matrices_are_inverse() {
        for axis in 0..3 {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let back = multiply(&AGX_OUTSET, multiply(&AGX_INSET, unit));
            assert!((0..3).all(|k| (back[k] - unit[k]).abs() < 1e-5), "{back:?}");
        }
    }

    #[test]
    fn grey_stays_grey_and_brighter_is_brighter() {
        for tone in [ToneMap::Agx, ToneMap::Srgb, ToneMap::Reinhard] {
            let mut last = 0;
            for stop in -12..10 {
                let [r, g, b] = Look { tone, stops: stop as f32 }.apply([1.0; 3]);
                assert!(r.abs_diff(g) <= 1 && g.abs_diff(b) <= 1 && g >= last, "{tone} at {stop}: {r} {g} {b}");
                last = g;
            }
        }
        let middle = Look::default().apply([0.18; 3]);
        assert!(middle.iter().all(|code| code.abs_diff(128) <= 1), "middle grey is half the code range: {middle:?}");
        assert_eq!(Look { tone: ToneMap::Srgb, stops: 0.0 }.apply([0.5, 0.0, 2.0]), [188, 0, 255]);
    }

    #[test]
    fn odd_values_have_a_colour() {
        for tone in [ToneMap::Agx, ToneMap::Srgb, ToneMap::Reinhard] {
            let look = Look { tone, stops: 3.0 };
            assert_eq!(look.apply([f32::NAN, 0.5, 0.5]), NAN_COLOUR);
            assert!(look.apply([f32::INFINITY; 3]).iter().all(|&value| value >= 254), "{tone}");
            assert!(look.apply([-1.0; 3]).iter().all(|&value| value <= 1), "{tone}");
            assert_eq!(tone.to_string().parse(), Ok(tone));
        }
        assert_eq!(turbo(f32::NAN), NAN_COLOUR);
    }

    #[test]
    fn turbo_runs_from_blue_over_green_to_red() {
        // The table's entries 0, 128 and 255 are (48,18,59), (164,252,60) and (122,4,3); the fit is worst at the ends.
        for (value, expected) in [(0.0, [48, 18, 59]), (128.0 / 255.0, [164, 252, 60]), (1.0, [122, 4, 3])] {
            let colour = turbo(value);
            assert!((0..3).all(|k| colour[k].abs_diff(expected[k]) <= 32), "{value}: {colour:?}");
        }
    }

    #[test]
    fn srgb_codes_invert() {
        assert!((0..=255).map(|i| i as f32 / 255.0).all(|x| (srgb_encode(srgb_decode(x)) - x).abs() < 1e-5));
    }
}

//! Three mantissas of nine bits and one exponent (`VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`; Vulkan 1.3, 15.8).

use glam::DVec3;

const BIAS: i32 = 15;
const BITS: i32 = 9;
/// The largest value.
pub const MOST: f64 = 65408.0;

/// The nearest value; negative ones become 0, what is too large the largest.
pub fn encode(rgb: DVec3) -> u32 {
    let rgb = rgb.clamp(DVec3::ZERO, DVec3::splat(MOST));
    let largest = rgb.max_element();
    let rough = if largest > 0.0 { largest.log2().floor() as i32 } else { i32::MIN / 2 };
    let mut exponent = (rough + 1 + BIAS).max(0);
    let step = |exponent: i32| f64::from(exponent - BIAS - BITS).exp2();
    // Rounded up the mantissa may need a bit more.
    if (largest / step(exponent)).round() >= f64::from(1 << BITS) {
        exponent += 1;
    }
    let [r, g, b] = (rgb / step(exponent)).to_array().map(|v| v.round() as u32);
    (exponent as u32) << 27 | b << 18 | g << 9 | r
}

/// What is stored.
pub fn decode(code: u32) -> DVec3 {
    let step = f64::from((code >> 27) as i32 - BIAS - BITS).exp2();
    DVec3::from([0, 9, 18].map(|shift| f64::from(code >> shift & 0x1ff) * step))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    #[test]
    fn values_come_back_to_a_512th_of_the_largest() {
        for rgb in [dvec3(1.0, 0.5, 0.25), dvec3(0.3, 17.0, 4.2), dvec3(1e-4, 2e-4, 0.0), dvec3(0.999_999, 0.1, 0.0)] {
            let back = decode(encode(rgb));
            assert!((back - rgb).abs().max_element() <= rgb.max_element() / 511.0, "{rgb} {back}");
        }
        assert_eq!(decode(encode(dvec3(-1.0, f64::MAX, 0.0))), dvec3(0.0, MOST, 0.0));
        assert_eq!(encode(DVec3::ZERO), 0);
        assert_eq!(decode(encode(DVec3::ONE)), DVec3::ONE);
    }
}

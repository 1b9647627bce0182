//! How far an irradiance record reaches: Ward's weight, its bounded form, and the tests that reject a record.
//!
//! `d` = ‖P − P_k‖ and R in the same unit of length; `cos` = n·n_k. A weight of zero or less means "not used".

use glam::DVec3;

/// Ward, Rubinstein, Clear 1988: `1 / (d/R + √(1 − n·n_k))`; a record is used where this exceeds 1/a.
///
/// Infinite at the record itself. See [`used`].
pub fn ward(d: f64, r: f64, cos: f64) -> f64 {
    1.0 / (d / r + (1.0 - cos).max(0.0).sqrt())
}

/// [`ward`], 0 where the record is not used at accuracy `a`, finite at the record.
///
/// The bound stands so far above any useful weight that the record's own value is met to single precision.
pub fn used(d: f64, r: f64, cos: f64, a: f64) -> f64 {
    let w = ward(d, r, cos);
    if w > 1.0 / a { w.min(1e9) } else { 0.0 }
}

/// Tabellion and Lamorlette 2004, with the zone's radius given: `1 − max(d/radius, √((1 − n·n_k)/(1 − cos α)))`.
///
/// Their `clamp(R/2, R⁻, R⁺)/κ` is `radius`; `cos_alpha` is the cosine of the largest angle between the normals (theirs:
/// 10° at κ = 1). Bounded by 1, and 0 at the border of the zone.
pub fn bounded(d: f64, radius: f64, cos: f64, cos_alpha: f64) -> f64 {
    let angle = ((1.0 - cos).max(0.0) / (1.0 - cos_alpha)).sqrt();
    (1.0 - (d / radius).max(angle)).max(0.0)
}

/// Whether the record stands in front of P, `offset` = P − P_k away: P may then see surfaces that the record does not.
///
/// Ward 1988 (dᵢ < 0), with a tolerance relative to R so that scaling the world changes nothing.
pub fn in_front(offset: DVec3, n: DVec3, n_k: DVec3, r: f64) -> bool {
    const RELATIVE_TOLERANCE: f64 = 0.01;
    offset.dot(n + n_k) * 0.5 < -RELATIVE_TOLERANCE * r
}

/// R of a record whose linear extrapolation errs by ½a² of its irradiance, along the worst direction, at the distance a·R.
///
/// The error is ½|λ|d², λ the largest eigenvalue of the Hessian `h` = (xx, xy, yy) of the irradiance `e` (Jarosz,
/// Schwarzhaupt, Popov, Dachsbacher 2012). `most` = π·L_max; a share of it stands for irradiance next to nothing.
/// Where no light is seen at all nothing follows from this, and the harmonic mean distance stands for R.
pub fn hessian_radius(e: f64, most: f64, h: DVec3) -> f64 {
    const DARK_SHARE: f64 = 0.02;
    let lambda = (h.x + h.z).abs() / 2.0 + ((h.x - h.z) / 2.0).hypot(h.y);
    ((e + DARK_SHARE * most) / lambda).sqrt()
}

/// What a record tells of a point where its gradients change its irradiance `e` by `change`: within its evidence.
///
/// At least 0. At most `most` = π·L_max, a hemisphere full of the brightest thing that the record sees; and at most 2e,
/// for linear growth is evidence for as much again and no more.
pub fn extrapolated(e: f64, change: f64, most: f64) -> f64 {
    (e + change).clamp(0.0, (2.0 * e).min(most.max(e)))
}

/// A new record's R and its neighbour's, after each is limited by the other (Křivánek, Bouatouch, Pattanaik, Žára 2006).
///
/// If the neighbour sees something at R_i, the new record at distance d cannot be further from it than R_i + d.
pub fn clamp_neighbours(r_new: f64, r_i: f64, d: f64) -> (f64, f64) {
    let r_new = r_new.min(r_i + d);
    (r_new, r_i.min(r_new + d))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ward_reaches_a_times_r() {
        assert!(used(0.199, 1.0, 1.0, 0.2) > 0.0);
        assert_eq!(used(0.201, 1.0, 1.0, 0.2), 0.0);
        // a = 0.2: normals may differ by acos(1 − 0.04).
        assert!(used(0.0, 1.0, 0.961, 0.2) > 0.0);
        assert_eq!(used(0.0, 1.0, 0.959, 0.2), 0.0);
        assert!(used(0.0, 1.0, 1.0, 0.2).is_finite());
    }

    #[test]
    fn bounded_falls_from_one_to_zero() {
        let cos10 = 10f64.to_radians().cos();
        assert_eq!(bounded(0.0, 1.0, 1.0, cos10), 1.0);
        assert_eq!(bounded(0.25, 1.0, 1.0, cos10), 0.75);
        assert_eq!(bounded(1.0, 1.0, 1.0, cos10), 0.0);
        assert!(bounded(0.0, 1.0, cos10, cos10).abs() < 1e-7);
    }

    #[test]
    fn in_front_means_below_the_record_in_a_concave_corner() {
        // The record stands on a step; P lies on the floor below it.
        assert!(in_front(DVec3::new(0.1, 0.0, -0.5), DVec3::Z, DVec3::Z, 1.0));
        assert!(!in_front(DVec3::new(0.1, 0.0, 0.0), DVec3::Z, DVec3::Z, 1.0));
        for scale in [1e-6, 1e6] {
            assert!(!in_front(DVec3::new(0.1, 0.0, -0.005) * scale, DVec3::Z, DVec3::Z, scale));
        }
    }

    #[test]
    fn extrapolation_stays_within_its_evidence() {
        let values = [0.0, 1e-30, 0.3, 1.0, 17.0, 1e30];
        for e in values {
            for change in values.into_iter().flat_map(|v| [v, -v]) {
                for share in [1.0, 1.5, 100.0] {
                    let got = extrapolated(e, change, share * e);
                    assert!(got >= 0.0 && got <= 2.0 * e && got <= share * e, "{e} {change} {share}: {got}");
                    let inside = e + change >= 0.0 && change <= e && e + change <= share * e;
                    assert!(!inside || got == e + change, "{e} {change} {share}: {got}");
                }
            }
        }
        // Rounding may leave π·L_max below E in a furnace: the record's own value stands.
        assert_eq!(extrapolated(1.0, 0.0, 0.999_999), 1.0);
    }

    #[test]
    fn hessian_radius_is_where_a_parabola_errs() {
        let (e, a): (f64, f64) = (2.0, 0.3);
        for h in [DVec3::new(5.0, 0.0, 1.0), DVec3::new(1.0, 0.0, -5.0), DVec3::new(0.0, 5.0, 0.0)] {
            let lambda = h.x.abs().max(h.z.abs()).max(h.y.abs());
            let d = a * hessian_radius(e, 0.0, h);
            assert!((0.5 * lambda * d * d - 0.5 * a * a * e).abs() < 1e-12, "{h}");
        }
        assert!(hessian_radius(e, 0.0, DVec3::ZERO).is_infinite());
    }

    #[test]
    fn neighbours_limit_each_other() {
        assert_eq!(clamp_neighbours(10.0, 1.0, 0.5), (1.5, 1.0));
        assert_eq!(clamp_neighbours(1.0, 10.0, 0.5), (1.0, 1.5));
    }
}

//! Gauss–Legendre quadrature, in one dimension and over spherical triangles and arcs.

use glam::DVec3;
use std::f64::consts::PI;

/// Points and weights of the rule with `count` points on [0, 1], exact for polynomials of degree 2·`count` − 1.
///
/// Newton's method on the Legendre polynomial, from the roots' asymptotic places (Press et al. 2007, §4.6.1).
pub fn gauss_legendre(count: u32) -> Vec<(f64, f64)> {
    let n = f64::from(count);
    let point = |i: u32| {
        let mut x = (PI * (f64::from(i) + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..50 {
            let (value, before) = legendre(count, x);
            slope = n * (x * value - before) / (x * x - 1.0);
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(point).collect()
}

/// P_n and P_{n−1} at x, for n ≥ 1.
fn legendre(n: u32, x: f64) -> (f64, f64) {
    let (mut before, mut now) = (1.0, x);
    for l in 2..=n {
        let l = f64::from(l);
        (before, now) = (now, ((2.0 * l - 1.0) * x * now - (l - 1.0) * before) / l);
    }
    (now, before)
}

/// Directions and solid angles that integrate over the spherical triangle a, b, c of unit vectors. The solid angles are
/// negative if the corners run clockwise as seen from the centre's far side, that is if a·(b×c) < 0.
///
/// A point p of the flat triangle has dω = a·(b×c) du dv / |p|³; Duffy's map (1982) takes the triangle to a square.
pub fn spherical_triangle([a, b, c]: [DVec3; 3], rule: &[(f64, f64)]) -> impl Iterator<Item = (DVec3, f64)> {
    let volume = a.dot(b.cross(c));
    rule.iter().flat_map(move |&(u, wu)| {
        rule.iter().map(move |&(v, wv)| {
            let p = a + u * ((b - a) + v * (c - b));
            let length = p.length();
            (p / length, wu * wv * u * volume / (length * length * length))
        })
    })
}

/// Directions and lengths that integrate along the arc of the great circle from a to b, both unit vectors less than π apart.
pub fn arc(a: DVec3, b: DVec3, rule: &[(f64, f64)]) -> impl Iterator<Item = (DVec3, f64)> {
    let across = a.cross(b);
    let angle = across.length().atan2(a.dot(b));
    let side = across.cross(a).normalize_or_zero();
    rule.iter().map(move |&(t, weight)| {
        let (sine, cosine) = (t * angle).sin_cos();
        (cosine * a + sine * side, weight * angle)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials() {
        for count in 1..=20 {
            let rule = gauss_legendre(count);
            for degree in 0..2 * count as i32 {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                assert!((sum * f64::from(degree + 1) - 1.0).abs() < 1e-12, "{count} {degree}: {sum}");
            }
        }
    }

    /// An octant: solid angle π/2, ∫ ω dω = π/4 along each axis; its side: length π/2, ∫ ω dl = (1, 1, 0).
    #[test]
    fn an_octant_and_its_side() {
        let rule = gauss_legendre(24);
        let octant = [DVec3::X, DVec3::Y, DVec3::Z];
        let flux: DVec3 = spherical_triangle(octant, &rule).map(|(d, w)| d * w).sum();
        let solid: f64 = spherical_triangle(octant, &rule).map(|(_, w)| w).sum();
        assert!((flux - DVec3::splat(PI / 4.0)).length() < 1e-12 && (solid - PI / 2.0).abs() < 1e-12);
        let along: DVec3 = arc(DVec3::X, DVec3::Y, &rule).map(|(d, w)| d * w).sum();
        assert!((along - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-12);
    }
}

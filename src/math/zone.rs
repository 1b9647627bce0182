//! What of a record's zone of influence the screen can show: the CPU twin of `glsl/splat/splat.vert`.
//!
//! A record lights what lies within its radius r and no further below its own surface than a tenth of r along the mean of both
//! normals, which are at most some angle apart: what is left of the sphere is a body that one plane cuts, the cap. Its outline on
//! the screen lies in a rectangle about the sphere's, one side of which the plane moves in: seen at a grazing angle, to half.

use glam::DVec3;

/// A tenth of the radius: `glsl/splat/body.glsl`.
const BELOW: f64 = 0.1;

/// How far below its plane, in radii, a record lights anything, where normals differ by angles of √(1 − cos) ≤ `limit`.
///
/// The mean of the normals is half that angle β from the record's own, and a point no further below it than `BELOW`/cos β: in all
/// no further below the record's plane than the sine of β and of that together.
pub fn depth_below(limit: f64) -> f64 {
    let half_cos = (1.0 - 0.5 * limit.min(1.0).powi(2)).sqrt();
    ((BELOW / half_cos).asin() + half_cos.acos()).sin()
}

/// Corners of the rectangle, about the plane of the sphere's outline, that holds the cap as seen from the origin: two where the
/// plane cuts and two across; `centre` relative to the eye. None where the eye is in the sphere.
///
/// The outline of a sphere at distance d is a circle at (1 − r²/d²)·d of radius r√(1 − r²/d²). The cap's own outline is part of
/// that and part of its border, a circle about c − ε·r·n: symmetric to the plane through eye, centre and normal, and furthest out
/// there.
pub fn rectangle(centre: DVec3, r: f64, normal: DVec3, below: f64) -> Option<[DVec3; 4]> {
    let d = centre.length();
    let k = 1.0 - r * r / (d * d);
    if k <= 0.0 {
        return None;
    }
    let (way, middle, rho) = (centre / d, centre * k, r * k.sqrt());
    let cosine = -normal.dot(way);
    let across = normal + cosine * way;
    let sine = across.length();
    let up = if sine > 1e-3 { across / sine } else { way.any_orthonormal_vector() };
    let border = (1.0 - below * below).sqrt();
    let reach = |sign: f64| {
        let height = r * (-below * sine + sign * border * cosine);
        -d * k * height / (d + r * (below * cosine + sign * border * sine))
    };
    let is_cut = r * r / d * cosine - rho * sine < -below * r;
    let lower = if is_cut { reach(1.0).max(reach(-1.0)).clamp(0.0, rho) } else { rho };
    let side = way.cross(up);
    Some([[-lower, -rho], [-lower, rho], [rho, -rho], [rho, rho]].map(|[x, y]| middle + x * up + y * side))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sequence::fibonacci_sphere;
    use glam::dvec3;

    /// The rectangle holds all points of the cap, and each of its sides is near one.
    #[test]
    fn the_rectangle_holds_the_cap_and_little_else() {
        let centre = dvec3(1.0, -0.5, -4.0);
        for limit in [0.0, 0.2, 0.6, 1.0] {
            let below = depth_below(limit);
            for normal in (0..24).map(|i| fibonacci_sphere(i, 24).as_dvec3()).filter(|n| n.dot(centre) < 0.4) {
                for r in [0.1, 1.0, 3.0] {
                    let corners = rectangle(centre, r, normal, below).unwrap();
                    let (up, side) = (corners[2] - corners[0], corners[1] - corners[0]);
                    // A point of the rectangle's plane on the ray through p, in shares of the rectangle.
                    let share = |p: DVec3| {
                        let q = p * (corners[0].dot(centre) / p.dot(centre)) - corners[0];
                        [q.dot(up) / up.length_squared(), q.dot(side) / side.length_squared()]
                    };
                    let cap = (0..20_000).map(|i| fibonacci_sphere(i, 20_000).as_dvec3());
                    let cap = cap.map(|p| p.dot(normal).max(-below) * normal + (p - p.dot(normal) * normal));
                    let (mut least, mut most) = ([1.0f64; 2], [0.0f64; 2]);
                    for p in cap.filter(|p| p.length() <= 1.0).map(|p| share(centre + r * p)) {
                        least = [0, 1].map(|i| least[i].min(p[i]));
                        most = [0, 1].map(|i| most[i].max(p[i]));
                    }
                    let edges = [least[0], least[1], 1.0 - most[0], 1.0 - most[1]];
                    assert!(edges.iter().all(|e| *e > -1e-9), "{normal} {r} {limit}: {edges:?}");
                    assert!(edges.iter().all(|e| *e < 0.05), "{normal} {r} {limit}: {edges:?}");
                }
            }
        }
    }

    /// Points that a record lights lie above the plane at `depth_below`.
    #[test]
    fn nothing_below_the_plane_is_lit() {
        for limit in [0.0, 0.2, 0.7, 1.0] {
            let (n, below) = (DVec3::Z, depth_below(limit));
            let angle = (1.0f64 - limit * limit).acos();
            let tilted = dvec3(angle.sin(), 0.0, angle.cos());
            let lowest = (0..100_000).map(|i| fibonacci_sphere(i, 100_000).as_dvec3());
            let lowest = lowest.filter(|p| p.dot(n + tilted) * 0.5 >= -BELOW).map(|p| p.z).fold(1.0, f64::min);
            assert!(lowest >= -below && lowest < -below + 0.02, "{limit}: {lowest} {below}");
        }
    }
}

//! Light at outlines: twin of `glsl/capture_compute/outlines.glsl`, which derives it.

use super::adjacency::NONE;
use glam::DVec3;

/// Triangles that are followed at most, beyond the nearer one (`STEPS` of the shader).
const STEPS: usize = 3;

/// A surface as seen from the origin.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Corners of its triangles.
    pub triangles: &'a [[DVec3; 3]],
    /// The triangles across the edges opposite to these, or [`NONE`].
    pub across: &'a [[u32; 3]],
}

/// Two neighbouring directions that see different triangles.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// What they see, the nearer one first; beyond it there may be [`NONE`].
    pub triangles: [u32; 2],
    /// The directions.
    pub ways: [DVec3; 2],
}

/// Where the plane of both directions leaves a triangle.
#[derive(Clone, Copy)]
struct Leave {
    point: DVec3,
    /// Tangent of the angle from the first direction.
    turn: f64,
    next: u32,
}

impl Surface<'_> {
    /// Σ (L_{i+1} − L_i)/|P_i|ᵐ over the outlines between the directions of `pair`, no 1/|P| above `most`; none where what lies
    /// between leads elsewhere. `power` m is 1 for the gradient, 2 for the second derivatives. `light`: of a triangle, in a
    /// direction of any length.
    pub fn moved(&self, pair: &Pair, most: f64, power: i32, light: impl Fn(u32, DVec3) -> f64) -> Option<f64> {
        let [near, far] = pair.triangles;
        let normal = pair.ways[0].cross(pair.ways[1]);
        let fan = [normal, pair.ways[0], normal.cross(pair.ways[0])];
        let last = fan[2].dot(pair.ways[1]) / fan[1].dot(pair.ways[1]);
        let closeness = |leave: &Leave| leave.point.length_recip().min(most).powi(power);
        let mut leave = self.leave(near, fan, None).filter(|leave| leave.turn <= last)?;
        let mut moved = -light(near, pair.ways[0]) * closeness(&leave);
        let mut came = near;
        for _ in 0..STEPS {
            let number = leave.next;
            let next = (number != NONE && number != far).then(|| self.leave(number, fan, Some(came))).flatten();
            // Else it turns away.
            let Some(next) = next.filter(|next| next.turn > leave.turn) else { break };
            if next.turn > last {
                return None; // what the other direction would see
            }
            moved += light(number, leave.point + next.point) * (closeness(&leave) - closeness(&next));
            (came, leave) = (number, next);
        }
        Some(moved + if far == NONE { 0.0 } else { light(far, pair.ways[1]) * closeness(&leave) })
    }

    /// Where the plane (its normal, the first direction, across it) leaves a triangle, but for the edge to the one it `came` from.
    fn leave(&self, triangle: u32, [normal, along, across]: [DVec3; 3], came: Option<u32>) -> Option<Leave> {
        let corners = self.triangles[triangle as usize];
        let by = |edge: usize| {
            let [a, b] = [1, 2].map(|turn| corners[(edge + turn) % 3]);
            let (h, k) = (normal.dot(a), normal.dot(b));
            let point = (a * k - b * h) / (k - h);
            let next = self.across[triangle as usize][edge];
            let leaves = (h >= 0.0) != (k >= 0.0) && came != Some(next) && along.dot(point) > 0.0;
            leaves.then(|| Leave { point, turn: across.dot(point) / along.dot(point), next })
        };
        (0..3).filter_map(by).max_by(|a, b| a.turn.total_cmp(&b.turn))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::adjacency;
    use crate::math::capture::{Projection, Seen, Table};
    use crate::math::form_factor::polygon;
    use glam::{DQuat, dvec3};
    use std::f64::consts::TAU;

    /// Corners of a dark side.
    const DARK: [DVec3; 4] =
        [dvec3(1.0, -1.0, 0.1), dvec3(1.0, -0.02, 0.1), dvec3(1.0, -0.02, 0.8), dvec3(1.0, -1.0, 0.8)];
    /// Around an edge of it a bright one, which is seen from near to its plane.
    const BRIGHT: [DVec3; 4] = [DARK[1], dvec3(3.0, -0.02, 0.1), dvec3(3.0, -0.02, 0.8), DARK[2]];

    fn light(triangle: u32, _: DVec3) -> f64 {
        f64::from(u8::from(triangle >= 2))
    }

    fn see(triangles: &[[DVec3; 3]], way: DVec3) -> (u32, Seen) {
        let mut best = (NONE, Seen { radiance: 0.0, inverse_distance: 0.0, plane: DVec3::ZERO });
        for (number, [a, b, c]) in (0..).zip(triangles) {
            let sides = [a.cross(*b), b.cross(*c), c.cross(*a)].map(|side| side.dot(way));
            let normal = (b - a).cross(c - a);
            let plane = normal / normal.dot(*a);
            let inverse_distance = plane.dot(way);
            let within = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
            if within && inverse_distance > best.1.inverse_distance {
                best = (number, Seen { radiance: light(number, way), inverse_distance, plane });
            }
        }
        best
    }

    /// ∇_t E and second derivatives of a hemicube, the steps between different triangles followed, and as they are without.
    fn derivatives(table: &Table, triangles: &[[DVec3; 3]], across: &[[u32; 3]]) -> [[DVec3; 2]; 2] {
        let seen: Vec<_> = table.texels.iter().map(|t| see(triangles, t.direction)).collect();
        let plain = table.integrate(&seen.iter().map(|(_, seen)| *seen).collect::<Vec<_>>());
        let plain = [plain.translation.with_z(0.0), plain.hessian];
        let mut followed = plain;
        for edge in &table.edges {
            let [mut i, mut j] = [edge.i, edge.j].map(|i| i as usize);
            let mut steps = [edge.step.with_z(0.0), edge.bend()];
            if seen[j].1.inverse_distance > seen[i].1.inverse_distance {
                (i, j, steps) = (j, i, steps.map(|step| -step));
            }
            let (near, q) = (seen[i].1, seen[i].1.inverse_distance);
            if seen[i].0 == seen[j].0 || q == 0.0 {
                continue;
            }
            let ways = [i, j].map(|texel| table.texels[texel].direction);
            let pair = Pair { triangles: [seen[i].0, seen[j].0], ways };
            let at_edge = near.plane.dot(table.between(edge).normalize()).clamp(-q, 3.0 * q);
            for (power, moves) in [(1, at_edge), (2, q * q)] {
                if let Some(moved) = (Surface { triangles, across }).moved(&pair, 3.0 * q, power, light) {
                    let which = power as usize - 1;
                    followed[which] += (moved - (seen[j].1.radiance - near.radiance) * moves) * steps[which];
                }
            }
        }
        [followed, plain]
    }

    /// Those of the bright side alone, in closed form.
    fn exact(corners: &[DVec3]) -> [DVec3; 2] {
        let d = 1e-3;
        let at =
            |x: f64, y: f64| polygon(DVec3::Z, &corners.iter().map(|c| c - dvec3(x, y, 0.0)).collect::<Vec<_>>()).abs();
        let slope = dvec3(at(d, 0.0) - at(-d, 0.0), at(0.0, d) - at(0.0, -d), 0.0) / (2.0 * d);
        let twice =
            [at(d, 0.0) + at(-d, 0.0), (at(d, d) - at(d, -d) - at(-d, d) + at(-d, -d)) / 4.0, at(0.0, d) + at(0.0, -d)];
        [slope, (DVec3::from(twice) - 2.0 * at(0.0, 0.0) * dvec3(1.0, 0.0, 1.0)) / (d * d)]
    }

    /// A bright side thinner than a texel, which most hemicubes miss: its own light is lost, the change of it is not.
    #[test]
    fn a_side_between_two_texels_is_followed() {
        let table = Projection::Hemicube.table(64);
        let turns = 12;
        let mut errors = [[0.0; 2]; 2];
        for turn in 0..turns {
            let turn = DQuat::from_rotation_z(TAU * (0.137 + 0.618_034 * f64::from(turn)));
            let corners: Vec<DVec3> = [DARK, BRIGHT].as_flattened().iter().map(|c| turn * *c).collect();
            let indices = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
            let positions: Vec<_> = [DARK, BRIGHT].as_flattened().iter().map(|c| c.as_vec3()).collect();
            let triangles = indices.map(|t| t.map(|i| corners[i as usize]));
            let exact = exact(&corners[4..]);
            let both = derivatives(&table, &triangles, &adjacency::neighbours(&indices, &positions));
            for (errors, got) in errors.iter_mut().zip(both) {
                for ((error, got), exact) in errors.iter_mut().zip(got).zip(exact) {
                    *error += (got - exact).length() / exact.length() / f64::from(turns);
                }
            }
        }
        eprintln!("{errors:?}");
        let [followed, plain] = errors;
        // The side is some fifteen texels high, its ends are up to half a texel off; without it most of the change is lost.
        assert!(followed.iter().all(|error| *error < 1.0 / 15.0), "{errors:?}");
        assert!(plain.iter().all(|error| *error > 0.5), "{errors:?}");
    }
}

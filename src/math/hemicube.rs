//! The hemicube's measure: exact weights of its texels, edges between them, and the CPU twin of `integrate.comp`.
//!
//! Local frame: the normal is +z. Five faces at distance 1 (Cohen and Greenberg 1985): the top along +z, then +x, −x, +y,
//! −y, of which only the half above the horizon counts. The views are those of `glsl/inc/views.glsl`.

use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// A texel of the hemicube.
#[derive(Clone, Copy, Debug)]
pub struct Texel {
    /// Face, 0 the top.
    pub face: u32,
    /// Column on the face, from the left.
    pub x: u32,
    /// Row on the face, from the top.
    pub y: u32,
    /// Unit direction through the centre.
    pub direction: DVec3,
    /// Solid angle, sr.
    pub solid_angle: f64,
    /// Cosine-weighted solid angle; all texels sum to π.
    pub weight: f64,
    /// Component of the direction along the face's axis.
    pub forward: f64,
}

/// An edge between two texels, with the factor of the translation gradient.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// First texel.
    pub i: u32,
    /// Second texel.
    pub j: u32,
    /// `tan(γ/2)·n·(a + b)·m`: the exact ∫cosθ dl along the edge, times the unit vector m across it from i to j.
    pub step: DVec3,
}

/// All texels and inner edges of a hemicube of `size` × `size` texels at the top.
pub struct Hemicube {
    /// Texels, face by face, row by row.
    pub texels: Vec<Texel>,
    /// Edges, seams between faces included; those on the horizon vanish and are left out.
    pub edges: Vec<Edge>,
}

/// What a capture tells about its record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integral {
    /// Irradiance for radiance given in W·sr⁻¹·m⁻².
    pub irradiance: f64,
    /// Rotation gradient ∫ L (n×ω) dω.
    pub rotation: DVec3,
    /// Translation gradient.
    pub translation: DVec3,
    /// Harmonic mean of the distances, cosine-weighted: 1/R.
    pub inverse_distance: f64,
}

/// Point (x, y) at distance 1 on a face; twin of `face_direction` in `views.glsl`.
pub fn face_direction(face: u32, p: DVec2) -> DVec3 {
    match face {
        0 => DVec3::new(p.x, p.y, 1.0),
        1 => DVec3::new(1.0, p.x, p.y),
        2 => DVec3::new(-1.0, -p.x, p.y),
        3 => DVec3::new(-p.x, 1.0, p.y),
        4 => DVec3::new(p.x, -1.0, p.y),
        _ => DVec3::new(p.x, -p.y, -1.0),
    }
}

impl Hemicube {
    /// A hemicube of `size` texels a side; `size` is even.
    pub fn new(size: u32) -> Self {
        assert!(size >= 2 && size.is_multiple_of(2), "a hemicube's size is even");
        let mut texels = Vec::with_capacity(3 * (size * size) as usize);
        let mut corners = Vec::with_capacity(texels.capacity());
        for face in 0..5 {
            let rows = if face == 0 { size } else { size / 2 };
            for (y, x) in (0..rows).flat_map(|y| (0..size).map(move |x| (y, x))) {
                texels.push(texel(face, x, y, size));
                corners.push(texel_corners(face, x, y, size));
            }
        }
        let sum: f64 = texels.iter().map(|t| t.weight).sum();
        texels.iter_mut().for_each(|t| t.weight *= PI / sum);
        let edges = inner_edges(&texels, &corners, size);
        Self { texels, edges }
    }

    /// CPU twin of `integrate.comp`: `seen` holds radiance and distance (infinite for the sky) of each texel.
    pub fn integrate(&self, seen: &[(f64, f64)]) -> Integral {
        let mut sum = Integral::default();
        for (texel, (radiance, distance)) in self.texels.iter().zip(seen) {
            sum.irradiance += texel.weight * radiance;
            sum.inverse_distance += texel.weight / distance / PI;
            sum.rotation += texel.solid_angle * *radiance * DVec3::Z.cross(texel.direction);
        }
        for edge in &self.edges {
            let ((a, ra), (b, rb)) = (seen[edge.i as usize], seen[edge.j as usize]);
            sum.translation -= (a - b) / ra.min(rb) * edge.step;
        }
        sum
    }
}

fn texel(face: u32, x: u32, y: u32, size: u32) -> Texel {
    let pitch = 2.0 / f64::from(size);
    let (left, top) = (f64::from(x) * pitch - 1.0, 1.0 - f64::from(y) * pitch);
    let centre = face_direction(face, DVec2::new(left + pitch / 2.0, top - pitch / 2.0));
    let corner = |i: usize| {
        face_direction(
            face,
            [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]
                .map(|(u, v)| DVec2::new(left + u * pitch, top - v * pitch))[i],
        )
    };
    let polygon = [corner(0), corner(1), corner(2), corner(3)].map(DVec3::normalize);
    Texel {
        face,
        x,
        y,
        direction: centre.normalize(),
        solid_angle: rectangle_solid_angle(left, left + pitch, top - pitch, top),
        weight: projected_solid_angle(&polygon),
        forward: 1.0 / centre.length(),
    }
}

/// Solid angle of the rectangle [x0, x1] × [y0, y1] of a plane at distance 1: differences of arctangents.
pub fn rectangle_solid_angle(x0: f64, x1: f64, y0: f64, y1: f64) -> f64 {
    let at = |x: f64, y: f64| (x * y).atan2((1.0 + x * x + y * y).sqrt());
    at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0)
}

/// ∫ cosθ dω over a spherical polygon above the horizon (Lambert 1760): ½ Σ Θ_i n·Γ_i, counter-clockwise from within.
pub fn projected_solid_angle(vertices: &[DVec3]) -> f64 {
    let mut sum = 0.0;
    for (i, a) in vertices.iter().enumerate() {
        let b = vertices[(i + 1) % vertices.len()];
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 {
            sum += sine.atan2(a.dot(b)) * cross.z / sine;
        }
    }
    sum.abs() / 2.0
}

type Corner = [i64; 3];

/// Corners of a texel in units of 1/size on the cube: integers, so that faces agree on shared ones.
fn texel_corners(face: u32, x: u32, y: u32, size: u32) -> [Corner; 4] {
    let n = f64::from(size);
    [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(u, v)| {
        let p = DVec2::new(f64::from(2 * (x + u)) / n - 1.0, 1.0 - f64::from(2 * (y + v)) / n);
        (face_direction(face, p) * n).to_array().map(|c| c.round() as i64)
    })
}

fn inner_edges(texels: &[Texel], corners: &[[Corner; 4]], size: u32) -> Vec<Edge> {
    let mut open: HashMap<(Corner, Corner), u32> = HashMap::new();
    let mut edges = Vec::with_capacity(texels.len() * 2);
    for (j, quad) in corners.iter().enumerate() {
        for side in 0..4 {
            let (a, b) = (quad[side], quad[(side + 1) % 4]);
            let key = (a.min(b), a.max(b));
            match open.remove(&key) {
                Some(i) => edges.push(edge(i, j as u32, key, texels, size)),
                None => {
                    open.insert(key, j as u32);
                }
            }
        }
    }
    edges.sort_by_key(|e| (e.i, e.j));
    edges
}

fn edge(i: u32, j: u32, (a, b): (Corner, Corner), texels: &[Texel], size: u32) -> Edge {
    let unit = |c: Corner| (DVec3::from_array(c.map(|v| v as f64)) / f64::from(size)).normalize();
    let (a, b) = (unit(a), unit(b));
    let across = a.cross(b).normalize();
    let towards = texels[j as usize].direction - texels[i as usize].direction;
    let m = if across.dot(towards) >= 0.0 { across } else { -across };
    // tan(γ/2) = sinγ/(1 + cosγ)
    let tangent = a.cross(b).length() / (1.0 + a.dot(b));
    Edge { i, j, step: tangent * (a.z + b.z) * m }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rectangle of EQUATIONS §7: x ∈ [.3, 1.5], y ∈ [−.7, .9], z = 1, L = 1, from the origin.
    fn rectangle(size: u32) -> Integral {
        let cube = Hemicube::new(size);
        let seen: Vec<_> = cube
            .texels
            .iter()
            .map(|t| {
                let p = t.direction / t.direction.z;
                let inside = p.x > 0.3 && p.x < 1.5 && p.y > -0.7 && p.y < 0.9;
                if inside { (1.0, p.length()) } else { (0.0, f64::INFINITY) }
            })
            .collect();
        cube.integrate(&seen)
    }

    #[test]
    fn weights_sum_to_the_hemisphere() {
        for size in [2, 8, 32, 128] {
            let cube = Hemicube::new(size);
            let solid: f64 = cube.texels.iter().map(|t| t.solid_angle).sum();
            let weight: f64 = cube.texels.iter().map(|t| t.weight).sum();
            assert!((solid - 2.0 * PI).abs() < 1e-10, "{size}: {solid}");
            assert!((weight - PI).abs() < 1e-12, "{size}: {weight}");
            // Each texel but those at the rim has four edges.
            let n = size as usize;
            assert_eq!(
                cube.edges.len(),
                2 * n * (n - 1) + 4 * (n * (n / 2 - 1) + (n - 1) * (n / 2)) + 4 * n + 4 * (n / 2)
            );
        }
    }

    #[test]
    fn texel_weights_agree_with_the_form_factor() {
        let cube = Hemicube::new(64);
        for t in cube.texels.iter().step_by(37) {
            let area = (2.0 / 64.0_f64).powi(2);
            let cosine = t.direction.z;
            let midpoint = area * t.forward.powi(3) * cosine;
            assert!((t.weight - midpoint).abs() < 2e-3 * area, "{t:?} {midpoint}");
        }
    }

    #[test]
    fn furnace_has_no_gradients() {
        let cube = Hemicube::new(16);
        let got = cube.integrate(&vec![(2.0, 3.0); cube.texels.len()]);
        assert!((got.irradiance - 2.0 * PI).abs() < 1e-12);
        assert!((got.inverse_distance - 1.0 / 3.0).abs() < 1e-12);
        assert!(got.rotation.length() < 1e-12 && got.translation.length() < 1e-12);
    }

    #[test]
    fn rectangle_agrees_with_the_closed_form_and_converges() {
        let (coarse, fine) = (rectangle(32), rectangle(128));
        assert!((fine.irradiance - 0.552554).abs() < 0.552554 * 0.01, "{}", fine.irradiance);
        let exact = DVec2::new(0.85859, 0.06285);
        let error = |got: Integral| (got.translation.truncate() - exact).length();
        assert!(error(fine) < 0.01 && error(coarse) < 0.06, "{} {}", error(coarse), error(fine));
    }

    #[test]
    fn rotation_gradient_agrees_with_finite_differences() {
        // A linear radiance L0 + L1·ω: E(n) = πL0 + (2π/3) L1·n, so dE/dn = (2π/3) L1; a turn about axis u moves n by u × n.
        let cube = Hemicube::new(64);
        let l1 = DVec3::new(0.3, -0.2, 0.4);
        let seen: Vec<_> = cube.texels.iter().map(|t| (1.0 + l1.dot(t.direction), 1.0)).collect();
        let got = cube.integrate(&seen);
        // E changes by (n_k × n)·∇_r E; for n tilted by δ towards x, n_k × n = δ·y.
        let along_x = got.rotation.y;
        // Light from below the tilted horizon joins in; only the hemisphere's own part is in the integral.
        let expected = 2.0 * PI / 3.0 * l1.x + 0.0;
        assert!((along_x - expected).abs() < 0.02 * expected.abs(), "{along_x} {expected}");
    }
}

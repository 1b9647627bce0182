//! A projection and a basis as tables: of each texel the integral of each basis function over it, of each edge that along it.
//!
//! A coefficient c = ∫ L·B dω moves with the point x as the irradiance does (`mod.rs`), the basis function B in the cosine's
//! place: ∇c = −Σ_edges (L_i − L_j) ∫ B m dl / r. [`Weights::integrate`] is the CPU twin of `glsl/project`.

use super::{Edge, Projection, Seen, Table, inverse_edge_distance};
use crate::math::{hsh, sh};
use glam::DVec3;

/// Functions that radiance is projected onto, in the frame of the capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The cosine to the normal: its one coefficient is the irradiance.
    Cosine,
    /// Hemispherical harmonics of this order ([`hsh`]).
    Hsh(u32),
    /// Spherical harmonics of this order ([`sh`]).
    Sh(u32),
}

impl Basis {
    /// Number of coefficients.
    pub fn count(self) -> usize {
        match self {
            Self::Cosine => 1,
            Self::Hsh(order) => hsh::count(order),
            Self::Sh(order) => sh::count(order),
        }
    }

    /// Values of all functions in the unit direction `d`; `out` has [`Self::count`] places.
    pub fn evaluate(self, d: DVec3, out: &mut [f64]) {
        match self {
            Self::Cosine => out[0] = d.z.max(0.0),
            Self::Hsh(order) => hsh::evaluate(order, d, out),
            Self::Sh(order) => sh::evaluate(order, d, out),
        }
    }
}

/// The tables of a projection × a basis, in the order of [`Table::texels`] and [`Table::edges`].
pub struct Weights {
    /// The basis.
    pub basis: Basis,
    /// ∫ B_c dω over texel t, sr: at t·count + c.
    pub texels: Vec<f64>,
    /// ∫ B_c m dl along edge e, the unit vector m across the edge from its first texel to its second: at e·count + c.
    pub edges: Vec<DVec3>,
    /// Share of each texel in the harmonic mean distance; they sum to 1. Cosine-weighted where the projection has a horizon,
    /// else by solid angle.
    pub distance: Vec<f64>,
}

/// A coefficient of what a capture sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficient {
    /// ∫ L·B dω, W·m⁻² for radiance in W·sr⁻¹·m⁻².
    pub value: f64,
    /// Its gradient as the point moves, the frame's axes kept.
    pub translation: DVec3,
}

impl Weights {
    /// Those of `projection` with `size` texels a side; `table` is its table.
    pub fn new(projection: Projection, size: u32, table: &Table, basis: Basis) -> Self {
        let count = basis.count();
        let mut values = vec![0.0; count];
        let shape = projection.shape(size);
        let mut texels = vec![0.0; table.texels.len() * count];
        let mut solid_angles = vec![0.0; table.texels.len()];
        shape.visit_texels(&mut |i, direction, solid_angle| {
            basis.evaluate(direction, &mut values);
            solid_angles[i] += solid_angle;
            let sums = &mut texels[i * count..][..count];
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += solid_angle * value);
        });
        // The rule's own error in the solid angle, which is known exactly.
        for ((sums, by_rule), texel) in texels.chunks_mut(count).zip(solid_angles).zip(&table.texels) {
            sums.iter_mut().for_each(|sum| *sum *= texel.solid_angle / by_rule);
        }
        let mut edges = vec![DVec3::ZERO; table.edges.len() * count];
        shape.visit_edges(table, &mut |e, direction, across| {
            basis.evaluate(direction, &mut values);
            let sums = &mut edges[e * count..][..count];
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += *value * across);
        });
        Self { basis, texels, edges, distance: distance_shares(projection, table) }
    }

    /// All coefficients and 1/R, the harmonic mean of the distances: `seen` holds what each texel of `table` sees.
    pub fn integrate(&self, table: &Table, seen: &[Seen]) -> (Vec<Coefficient>, f64) {
        let count = self.basis.count();
        let mut sums = vec![Coefficient::default(); count];
        for (weights, seen) in self.texels.chunks(count).zip(seen) {
            sums.iter_mut().zip(weights).for_each(|(sum, weight)| sum.value += weight * seen.radiance);
        }
        for (edge, steps) in table.edges.iter().zip(self.edges.chunks(count)) {
            let moved = change_over(table, edge, seen);
            sums.iter_mut().zip(steps).for_each(|(sum, step)| sum.translation += moved * *step);
        }
        (sums, self.distance.iter().zip(seen).map(|(share, seen)| share * seen.inverse_distance).sum())
    }
}

/// (L_j − L_i)/r of an edge.
fn change_over(table: &Table, edge: &Edge, seen: &[Seen]) -> f64 {
    let (a, b) = (&seen[edge.i as usize], &seen[edge.j as usize]);
    (b.radiance - a.radiance) * inverse_edge_distance(a, b, table.between(edge).normalize())
}

fn distance_shares(projection: Projection, table: &Table) -> Vec<f64> {
    let weight = |t: &super::Texel| if projection.has_horizon() { t.weight() } else { t.solid_angle };
    let sum: f64 = table.texels.iter().map(weight).sum();
    table.texels.iter().map(|t| weight(t) / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{polygon_flux, polygon_solid_angle};
    use super::*;
    use crate::math::quadrature::{gauss_legendre, spherical_triangle};
    use glam::dvec3;
    use std::f64::consts::PI;

    const PLANE: Projection = Projection::Plane { half_width: 2.0, compensated: true };
    const USERS: [(Projection, Basis); 5] = [
        (Projection::Cube, Basis::Sh(3)),
        (Projection::Hemicube, Basis::Hsh(6)),
        (Projection::Hemisphere, Basis::Hsh(3)),
        (PLANE, Basis::Hsh(3)),
        (Projection::Cube, Basis::Sh(6)),
    ];

    /// A light of radiance 1 on a black ground: a rectangle's corners, or a sphere's centre and radius.
    enum Light {
        Rectangle([DVec3; 4]),
        Sphere(DVec3, f64),
    }

    impl Light {
        fn seen(&self, d: DVec3) -> Seen {
            let dark = Seen { radiance: 0.0, inverse_distance: 0.0, plane: DVec3::ZERO };
            match self {
                Self::Rectangle([a, b, c, e]) => {
                    let sides = [(a, b), (b, c), (c, e), (e, a)].map(|(p, q)| p.cross(*q).dot(d));
                    let inside = sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0);
                    let n = (*b - *a).cross(*e - *a).normalize();
                    let plane = n / n.dot(*a);
                    let inverse_distance = plane.dot(d);
                    if inside && inverse_distance > 0.0 {
                        Seen { radiance: 1.0, inverse_distance, plane }
                    } else {
                        dark
                    }
                }
                Self::Sphere(centre, radius) => {
                    let along = centre.dot(d);
                    let under = along * along - centre.length_squared() + radius * radius;
                    if along < 0.0 || under < 0.0 {
                        return dark;
                    }
                    // The plane that the outline lies in.
                    let plane = *centre / (centre.length_squared() - radius * radius);
                    let inverse_distance = 1.0 / (along - under.sqrt());
                    Seen { radiance: 1.0, inverse_distance, plane }
                }
            }
        }

        /// The coefficients from a point moved by `step`, by a rule of high order; all of the light lies above the horizon.
        fn exact(&self, basis: Basis, step: DVec3) -> Vec<f64> {
            let mut values = vec![0.0; basis.count()];
            let mut sums = vec![0.0; basis.count()];
            let mut add = |d: DVec3, weight: f64| {
                basis.evaluate(d, &mut values);
                sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight.abs() * value);
            };
            match self {
                Self::Rectangle(corners) => {
                    let [a, b, c, e] = corners.map(|p| (p - step).normalize());
                    for triangle in [[a, b, c], [a, c, e]] {
                        spherical_triangle(triangle, &gauss_legendre(24)).for_each(|(d, w)| add(d, w));
                    }
                }
                Self::Sphere(centre, radius) => {
                    let to = *centre - step;
                    let (axis, sine) = (to.normalize(), radius / to.length());
                    let least = (1.0 - sine * sine).sqrt();
                    let across = axis.any_orthonormal_vector();
                    for (t, weight) in gauss_legendre(16) {
                        let cosine = least + t * (1.0 - least);
                        for i in 0..32 {
                            let (s, c) = (PI * f64::from(i) / 16.0).sin_cos();
                            let side = (c * across + s * axis.cross(across)) * (1.0 - cosine * cosine).sqrt();
                            add(cosine * axis + side, weight * (1.0 - least) * PI / 16.0);
                        }
                    }
                }
            }
            sums
        }

        /// Central differences along the axes.
        fn exact_gradients(&self, basis: Basis) -> Vec<DVec3> {
            let h = 1e-4;
            let along = |axis: DVec3| {
                let [less, more] = [-h, h].map(|h| self.exact(basis, h * axis));
                more.iter().zip(less).map(|(more, less)| (more - less) / (2.0 * h)).collect::<Vec<_>>()
            };
            let [x, y, z] = DVec3::AXES.map(along);
            (0..x.len()).map(|i| dvec3(x[i], y[i], z[i])).collect()
        }
    }

    fn lights() -> [Light; 2] {
        let corners = [(0.3, -0.7), (1.5, -0.7), (1.5, 0.9), (0.3, 0.9)];
        [Light::Rectangle(corners.map(|(x, y)| dvec3(x, y, 1.0))), Light::Sphere(dvec3(-0.4, 0.7, 1.1), 0.5)]
    }

    fn rms(values: impl Iterator<Item = f64>) -> f64 {
        values.map(|v| v * v).sum::<f64>().sqrt()
    }

    /// One function for all bases: its cosine is the table that was made for the cosine alone.
    #[test]
    fn the_cosine_is_one_of_the_bases() {
        for projection in [Projection::Hemicube, PLANE, Projection::Hemisphere] {
            let table = projection.table(16);
            let weights = Weights::new(projection, 16, &table, Basis::Cosine);
            // The disc's rim, where dω has a pole, and the plane's border texels, which reach down to the horizon.
            let bound = if projection == Projection::Hemicube { 1e-9 } else { 2e-4 };
            for (got, texel) in weights.texels.iter().zip(&table.texels) {
                assert!((got - texel.weight()).abs() < bound * texel.weight(), "{projection:?} {texel:?} {got}");
            }
            for (got, edge) in weights.edges.iter().zip(&table.edges) {
                assert!(
                    (*got - edge.step).length() < 1e-4 * edge.step.length() + 1e-12,
                    "{projection:?} {edge:?} {got}"
                );
            }
        }
    }

    /// A cube's texels make up the sphere, and every one of them has four edges.
    #[test]
    fn the_cube_is_the_whole_sphere() {
        for n in [2_u32, 8, 32] {
            let table = Projection::Cube.table(n);
            assert_eq!(table.texels.len(), 6 * (n * n) as usize);
            assert_eq!(table.edges.len(), 12 * (n * n) as usize);
            let solid: f64 = table.texels.iter().map(|t| t.solid_angle).sum();
            let flux: DVec3 = table.texels.iter().map(|t| t.flux).sum();
            assert!((solid - 4.0 * PI).abs() < 1e-10 && flux.length() < 1e-12, "{solid} {flux}");
            assert!(table.texels.iter().all(|t| t.flux.dot(t.direction) > 0.0));
        }
    }

    /// Constant radiance: the first coefficient is √4π (√2π on the hemisphere), all others are 0, and nothing moves. Each texel's
    /// integrals are exact, so that nothing is left but rounding.
    #[test]
    fn a_constant_is_the_first_coefficient() {
        for (projection, basis) in USERS {
            let table = projection.table(16);
            let weights = Weights::new(projection, 16, &table, basis);
            let one = Seen { radiance: 1.0, inverse_distance: 0.5, plane: DVec3::Z };
            let (sums, inverse_distance) = weights.integrate(&table, &vec![one; table.texels.len()]);
            let first = if projection.has_horizon() { (2.0 * PI).sqrt() } else { (4.0 * PI).sqrt() };
            let bound = if projection.has_horizon() { 1e-3 } else { 1e-9 };
            for (i, sum) in sums.iter().enumerate() {
                let expected = if i == 0 { first } else { 0.0 };
                assert!((sum.value - expected).abs() < bound, "{projection:?} {basis:?} {i}: {sum:?}");
                assert_eq!(sum.translation, DVec3::ZERO);
            }
            assert!((inverse_distance - 0.5).abs() < 1e-12);
        }
    }

    /// A linear and quadratic sky, sampled at texels' centres: to the second order in a texel's width.
    #[test]
    fn smooth_skies_converge_by_the_second_order() {
        let (linear, quadratic) = (dvec3(0.4, -0.7, 0.2), dvec3(0.5, -0.8, 0.3));
        let sky = |d: DVec3| 1.0 + linear.dot(d) + quadratic.dot(d * d);
        let table = |size| Projection::Cube.table(size);
        let mut exact = vec![0.0; 9];
        let mut values = vec![0.0; 9];
        for (d, weight) in sh::sphere_rule(6) {
            sh::evaluate(3, d, &mut values);
            exact.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * sky(d) * value);
        }
        let errors = [16, 32].map(|size| {
            let table = table(size);
            let weights = Weights::new(Projection::Cube, size, &table, Basis::Sh(3));
            let see = |t: &super::super::Texel| Seen {
                radiance: sky(t.direction),
                inverse_distance: 0.0,
                plane: DVec3::ZERO,
            };
            let (sums, _) = weights.integrate(&table, &table.texels.iter().map(see).collect::<Vec<_>>());
            rms(sums.iter().zip(&exact).map(|(sum, exact)| sum.value - exact)) / rms(exact.iter().copied())
        });
        eprintln!("{errors:?}");
        assert!(errors[0] < 2e-3 && errors[1] < 0.3 * errors[0], "{errors:?}");
    }

    /// Values and gradients of a rectangle and of a sphere light, against a rule of high order and its central differences.
    /// A light's edge is known to half a texel: errors are of the first order.
    #[test]
    fn lights_agree_with_finite_differences_and_converge() {
        for (projection, basis) in USERS {
            for (which, light) in lights().iter().enumerate() {
                let (exact, slopes) = (light.exact(basis, DVec3::ZERO), light.exact_gradients(basis));
                let errors = [32, 128].map(|size| {
                    let table = projection.table(size);
                    let weights = Weights::new(projection, size, &table, basis);
                    let seen: Vec<_> = table.texels.iter().map(|t| light.seen(t.direction)).collect();
                    let (sums, _) = weights.integrate(&table, &seen);
                    let value = rms(sums.iter().zip(&exact).map(|(sum, exact)| sum.value - exact));
                    let slope = rms(sums.iter().zip(&slopes).map(|(sum, exact)| (sum.translation - *exact).length()));
                    [value / rms(exact.iter().copied()), slope / rms(slopes.iter().map(|s| s.length()))]
                });
                eprintln!("{projection:?} {basis:?} light {which}: {errors:?}");
                let texel = if projection == PLANE { 2.0 } else { 1.0 };
                for (size, [value, slope]) in [32.0, 128.0].into_iter().zip(errors) {
                    assert!(value < 3.0 * texel / size, "{projection:?} {basis:?} {which}: {errors:?}");
                    assert!(slope < 6.0 * texel / size, "{projection:?} {basis:?} {which}: {errors:?}");
                }
            }
        }
    }

    /// The rule of a spherical polygon agrees with its closed forms.
    #[test]
    fn texels_are_measured_as_polygons_are() {
        let corners = [dvec3(0.3, -0.7, 1.0), dvec3(1.5, -0.7, 1.0), dvec3(1.5, 0.9, 1.0)].map(DVec3::normalize);
        let rule = gauss_legendre(24);
        let flux: DVec3 = spherical_triangle(corners, &rule).map(|(d, w)| w * d).sum();
        let solid: f64 = spherical_triangle(corners, &rule).map(|(_, w)| w).sum();
        assert!((flux - polygon_flux(&corners)).length() < 1e-12);
        assert!((solid - polygon_solid_angle(&corners)).abs() < 1e-12);
    }
}

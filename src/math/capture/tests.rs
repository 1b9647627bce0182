//! Tables against closed forms.

use super::*;
use glam::{DVec2, dvec3};

const WIDE: f64 = 2.0;
const COMPENSATED: Projection = Projection::Plane { half_width: WIDE, compensated: true };
const BARE: Projection = Projection::Plane { half_width: WIDE, compensated: false };
const WHOLE: [Projection; 3] = [Projection::Hemicube, COMPENSATED, Projection::Hemisphere];

fn solid_angle(table: &Table) -> f64 {
    table.texels.iter().map(|t| t.solid_angle).sum()
}

fn seen(radiance: f64, inverse_distance: f64, plane: DVec3) -> Seen {
    Seen { radiance, inverse_distance, plane }
}

/// The rectangle x ∈ [.3, 1.5], y ∈ [−.7, .9] at height 1, of radiance 1, seen from the origin.
fn rectangle(projection: Projection, size: u32) -> Integral {
    let table = projection.table(size);
    let see = |t: &Texel| {
        let p = t.direction / t.direction.z;
        let inside = p.x > 0.3 && p.x < 1.5 && p.y > -0.7 && p.y < 0.9;
        if inside { seen(1.0, 1.0 / p.length(), DVec3::Z) } else { seen(0.0, 0.0, DVec3::ZERO) }
    };
    table.integrate(&table.texels.iter().map(see).collect::<Vec<_>>())
}

#[test]
fn weights_sum_to_the_hemisphere() {
    for projection in WHOLE {
        for size in [2, 8, 16, 32, 64, 128, 256] {
            let table = projection.table(size);
            let (weight, solid) = (table.weight(), solid_angle(&table));
            assert!((weight - PI).abs() < 1e-11, "{projection:?} {size}: {weight}");
            assert!((solid - 2.0 * PI).abs() < 1e-9, "{projection:?} {size}: {solid}");
            assert!(table.texels.iter().all(|t| t.weight() > 0.0 && t.solid_angle >= t.weight()));
            let sideways: DVec3 = table.texels.iter().map(Texel::turn).sum();
            assert!(sideways.length() < 1e-11, "{projection:?} {size}: {sideways}");
        }
    }
}

/// A square of half width 2 at distance 1 sees 83.1 % of the cosine-weighted hemisphere and 59.0 % of the solid angle.
#[test]
fn a_plane_without_compensation_sees_its_form_factor() {
    for size in [2, 8, 32, 256] {
        let table = BARE.table(size);
        assert!((table.weight() / PI - seen_by_plane(WIDE)).abs() < 1e-12, "{}", table.weight());
        assert!((solid_angle(&table) / (2.0 * PI) - 0.590).abs() < 5e-4, "{}", solid_angle(&table));
    }
    assert!((seen_by_plane(WIDE) - 0.831).abs() < 5e-4);
}

/// What compensation adds to a border texel is ½cos²θ_b δφ and cosθ_b δφ, θ_b at its own outer edge.
#[test]
fn compensation_is_that_of_each_texel_s_own_edge() {
    for half_width in [0.5, 1.0, WIDE, 5.0] {
        let size = 128;
        let tables = [true, false].map(|compensated| Projection::Plane { half_width, compensated }.table(size));
        let pitch = pitch(size, half_width);
        for (with, without) in tables[0].texels.iter().zip(&tables[1].texels) {
            let added = [with.weight() - without.weight(), with.solid_angle - without.solid_angle];
            let p = without.direction.truncate() / without.direction.z;
            let is_border = |c: f64| c.abs() > half_width - 0.75 * pitch;
            match [is_border(p.x), is_border(p.y)] {
                [false, false] => assert!(added.iter().all(|a| a.abs() < 1e-12)),
                [true, true] => {}
                [across, _] => {
                    let along = if across { p.y } else { p.x };
                    let azimuth =
                        ((along + pitch / 2.0) / half_width).atan() - ((along - pitch / 2.0) / half_width).atan();
                    let cosine = (1.0 + half_width * half_width + along * along).sqrt().recip();
                    let expected = [0.5 * cosine * cosine * azimuth, cosine * azimuth];
                    for (got, expected) in added.iter().zip(expected) {
                        assert!((got - expected).abs() < 1e-3 * expected, "{half_width} {p}: {got} {expected}");
                    }
                }
            }
        }
        let missing: f64 = solid_angle(&tables[0]) - solid_angle(&tables[1]);
        if half_width == WIDE {
            // One angle for all texels would give 2.094.
            assert!((missing - 2.574).abs() < 1e-3, "{missing}");
        }
    }
}

/// Each measure against the midpoint rule, which is good to the second order in the texel's width.
#[test]
fn measures_agree_with_midpoints() {
    for (projection, half_width) in [(Projection::Hemicube, 1.0), (BARE, WIDE)] {
        let table = projection.table(64);
        let area = pitch(64, half_width).powi(2);
        for t in table.texels.iter().step_by(7) {
            let solid = area * t.forward.powi(3);
            assert!((t.solid_angle - solid).abs() < 2e-3 * area, "{t:?} {solid}");
            assert!((t.flux - solid * t.direction).length() < 2e-3 * area, "{t:?}");
        }
    }
    let table = Projection::Hemisphere.table(64);
    let area = pitch(64, 1.0).powi(2);
    for t in table.texels.iter().filter(|t| t.direction.z > 0.6) {
        assert!((t.weight() - area).abs() < 1e-12, "{t:?}");
        assert!((t.flux - area * t.direction / t.direction.z).length() < 0.01 * area, "{t:?}");
        assert!((t.solid_angle - area / t.direction.z).abs() < 0.01 * area, "{t:?}");
    }
}

/// The number of edges: every texel but those at the rim has four.
#[test]
fn edges_are_complete() {
    for n in [2_usize, 8, 32] {
        let hemicube = 2 * n * (n - 1) + 4 * (n * (n / 2 - 1) + (n - 1) * (n / 2)) + 4 * n + 4 * (n / 2);
        assert_eq!(Projection::Hemicube.table(n as u32).edges.len(), hemicube);
        assert_eq!(BARE.table(n as u32).edges.len(), 2 * n * (n - 1));
        // And the meridians between neighbours at the border.
        assert_eq!(COMPENSATED.table(n as u32).edges.len(), 2 * n * (n - 1) + 4 * (n - 1));
    }
}

/// A texel that is a patch of the unit sphere and shines alone: E = Ω v_z (v·ω)/|v|⁴ with v = ω − δ from a point moved
/// by δ, whose gradient is Ω (3 ω_z ω − n).
#[test]
fn edges_of_a_texel_are_the_change_of_its_form_factor() {
    for projection in [Projection::Hemicube, BARE, COMPENSATED, Projection::Hemisphere] {
        let table = projection.table(64);
        for (index, t) in table.texels.iter().enumerate().filter(|(_, t)| t.direction.z > 0.6).step_by(15) {
            let outwards: DVec3 = table
                .edges
                .iter()
                .filter_map(|e| match index as u32 {
                    i if i == e.i => Some(e.step),
                    i if i == e.j => Some(-e.step),
                    _ => None,
                })
                .sum();
            let expected = 3.0 * t.direction.z * t.direction * t.solid_angle - DVec3::Z * t.solid_angle;
            let got = -outwards;
            let scale = t.solid_angle;
            assert!((got - expected).length() < 0.01 * scale, "{projection:?} {index}: {got} {expected}");
        }
    }
}

#[test]
fn furnace_has_no_gradients() {
    for projection in WHOLE {
        let table = projection.table(16);
        let got = table.integrate(&vec![seen(2.0, 1.0 / 3.0, DVec3::Z); table.texels.len()]);
        assert!((got.irradiance - 2.0 * PI).abs() < 1e-11);
        assert!((got.inverse_distance - 1.0 / 3.0).abs() < 1e-12);
        assert!(got.rotation.length() < 1e-11 && got.translation.length() < 1e-12 && got.hessian.length() < 1e-12);
    }
}

/// Texels are sampled at their centres: an edge of the light moves by up to half a texel, so that the error is of the
/// first order in a texel's width.
#[test]
fn rectangle_agrees_with_the_closed_form_and_converges() {
    let exact = DVec2::new(0.85859, 0.06285);
    for projection in [Projection::Hemicube, COMPENSATED, BARE, Projection::Hemisphere] {
        let errors = [32, 128, 256].map(|size| {
            let got = rectangle(projection, size);
            ((got.irradiance - 0.552554).abs() / 0.552554, (got.translation.truncate() - exact).length())
        });
        eprintln!("{projection:?}: {errors:?}");
        for (size, (irradiance, gradient)) in [32.0, 128.0, 256.0].into_iter().zip(errors) {
            let texel = if matches!(projection, Projection::Plane { .. }) { WIDE / size } else { 1.0 / size };
            assert!(irradiance < 3.0 * texel && gradient < 4.0 * texel, "{projection:?} {size}: {errors:?}");
        }
    }
}

/// Central second differences of the rectangle's closed form.
#[test]
fn hessian_agrees_with_finite_differences() {
    use crate::math::form_factor::polygon;
    let corners = [(0.3, -0.7), (1.5, -0.7), (1.5, 0.9), (0.3, 0.9)].map(|(x, y)| dvec3(x, y, 1.0));
    let at = |x: f64, y: f64| polygon(DVec3::Z, &corners.map(|c| c - dvec3(x, y, 0.0)));
    let d = 1e-3;
    let exact = dvec3(
        at(d, 0.0) - 2.0 * at(0.0, 0.0) + at(-d, 0.0),
        (at(d, d) - at(d, -d) - at(-d, d) + at(-d, -d)) / 4.0,
        at(0.0, d) - 2.0 * at(0.0, 0.0) + at(0.0, -d),
    ) / (d * d);
    for projection in [Projection::Hemicube, COMPENSATED, Projection::Hemisphere] {
        let errors = [32, 128].map(|size| (rectangle(projection, size).hessian - exact).length() / exact.length());
        eprintln!("{projection:?}: {exact}, {errors:?}");
        assert!(errors[0] < 0.3 && errors[1] < 0.08, "{projection:?}: {errors:?}");
    }
}

/// A linear radiance L0 + L1·ω: ∇_r E is ∫ L (n×ω) dω = (2π/3) n × L1 over the hemisphere.
#[test]
fn rotation_gradient_of_a_linear_radiance() {
    let l1 = dvec3(0.3, -0.2, 0.4);
    for projection in WHOLE {
        let errors = [16, 64].map(|size| {
            let table = projection.table(size);
            let seen: Vec<_> = table.texels.iter().map(|t| seen(1.0 + l1.dot(t.direction), 1.0, t.direction)).collect();
            (table.integrate(&seen).rotation - 2.0 * PI / 3.0 * DVec3::Z.cross(l1)).length()
        });
        eprintln!("{projection:?}: {errors:?}");
        // What a plane does not see it takes from its border, where ω is not what it is there.
        let bound = if projection == COMPENSATED { [0.04, 0.04] } else { [0.02, 0.004] };
        assert!(errors[0] < bound[0] && errors[1] < bound[1], "{projection:?}: {errors:?}");
    }
}

/// Every edge is to the left of one texel, above one, or a seam.
#[test]
fn faces_have_all_edges() {
    for n in [2_usize, 8, 32] {
        let table = Projection::Hemicube.table(n as u32);
        let faces = Faces::of(&table);
        let inner: Vec<_> = faces.inner.iter().flatten().flatten().collect();
        assert_eq!(inner.len() + faces.seams.len(), table.edges.len());
        assert_eq!(faces.seams.len(), 4 * n + 4 * (n / 2));
        // Twice n at the top's sides, its corners once; at each side's top and two sides.
        assert_eq!(faces.border_count as usize, 4 * (n - 1) + 4 * (if n > 2 { 2 * n - 2 } else { n }));
        for (j, [left, up]) in faces.inner.iter().enumerate() {
            let place = |i: u32| {
                let t = &table.texels[i as usize];
                (t.layer, t.x, t.y)
            };
            let (layer, x, y) = place(j as u32);
            assert!(left.is_none_or(|e| e.j == j as u32 && place(e.i) == (layer, x - 1, y)));
            assert!(up.is_none_or(|e| e.j == j as u32 && place(e.i) == (layer, x, y - 1)));
        }
    }
}

/// The middle between two texels' centres is that of their edge to the second order in the texel's width; within a face it
/// lies on its plane, at distance 1 along an axis.
#[test]
fn between_is_on_the_face() {
    let table = Projection::Hemicube.table(32);
    for edge in &table.edges {
        let between = table.between(edge);
        let is_seam = table.texels[edge.i as usize].layer != table.texels[edge.j as usize].layer;
        let off = (between.normalize() - edge.middle).length();
        assert!(off < if is_seam { 0.02 } else { 1e-3 }, "{edge:?} {between}");
        assert!(is_seam || (between.abs().max_element() - 1.0).abs() < 1e-12);
    }
}

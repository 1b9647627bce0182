//! Distances by direction, by render passes and in compute: of a box in closed form, and the share of triangles' backs.

use crate::common::build::{Builder, Facing, diffuse};
use crate::common::gpu;
use glam::{DVec3, Vec3, vec3};
use hemicube::math::octahedron;
use hemicube::math::sh::sphere_rule;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::sphere_probes::{SphereProbeSettings, SphereProbes};
use hemicube::passes::distances::{CELLS, back_share};
use hemicube::renderer::Settings;
use hemicube::vk::pass::Recorder;

/// Distance to a cube of half side 1 around the origin.
fn to_cube(d: DVec3) -> f64 {
    1.0 / d.abs().max_element()
}

/// Means of the distance and of its square over each cell, by solid angle over the distance's square.
fn of_cube() -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 3]; CELLS];
    for (d, weight) in sphere_rule(120) {
        let sum = &mut sums[octahedron::cell(d)];
        [to_cube(d).powi(-2), to_cube(d).recip(), 1.0].iter().zip(sum).for_each(|(v, sum)| *sum += weight * v);
    }
    sums.iter().map(|[weight, first, second]| [first / weight, second / weight]).collect()
}

#[test]
fn a_box_around_a_point_has_its_distances_and_one_side() {
    let device = gpu();
    let expected = of_cube();
    for facing in [Facing::In, Facing::Out] {
        let mut b = Builder::default();
        let grey = b.material(diffuse(0.5));
        b.cuboid(grey, Vec3::NEG_ONE, Vec3::ONE, facing);
        b.quad(grey, vec3(3.0, 0.0, 0.0), Vec3::X * 0.1, Vec3::Y * 0.1);
        let scene = b.build();
        for capture in [CaptureMode::Hemicube, CaptureMode::Compute] {
            let settings = SphereProbeSettings {
                order: 2,
                capture_size: 32,
                capture,
                gradients: false,
                distances: Some(0.0),
                lights: Settings::default().lights,
                surface_cells: 1 << 10,
            };
            let mut recorder = Recorder::new(&device);
            let probes = SphereProbes::new(&device, &mut recorder, &scene, &settings).unwrap();
            let found = &probes.measure(&mut recorder, &[Vec3::ZERO], |_| {}).unwrap()[0];
            let cells = &found.distances;
            assert_eq!(cells.len(), CELLS);
            let share = if matches!(facing, Facing::In) { 0.0 } else { 1.0 };
            assert!((back_share(cells) - share).abs() < 1e-5, "{capture:?}: {}", back_share(cells));
            for (cell, expected) in cells.iter().zip(&expected) {
                let off = |i: usize| (f64::from(cell.moments[i]) / expected[i] - 1.0).abs();
                assert!(off(0) < 0.02 && off(1) < 0.04, "{capture:?}: {cell:?} {expected:?}");
                assert!(cell.nearness <= 1.001 && cell.nearness > 0.5, "{cell:?}");
            }
        }
    }
}

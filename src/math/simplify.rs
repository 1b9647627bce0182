//! Fewer triangles for much the same surface.

use super::adjacency;
use glam::Vec3;
use meshopt::{SimplifyOptions, VertexDataAdapter};

/// `triangles` with edges collapsed (Garland and Heckbert 1997, by meshoptimizer) as far as that moves the surface by no more than
/// `error`, in the positions' unit and as quadrics measure it. Corners are some of `positions`; what is joined or closed stays so.
pub fn simplified(positions: &[Vec3], triangles: &[[u32; 3]], error: f32) -> Vec<[u32; 3]> {
    // Without seams: only positions matter.
    let welded = adjacency::welded(positions, triangles);
    let bytes = bytemuck::cast_slice(positions);
    let vertices = VertexDataAdapter::new(bytes, size_of::<Vec3>(), 0).expect("positions are whole vertices");
    // Sparse: vertices that are not named are none, and do not stand beside those at their positions.
    let options = SimplifyOptions::ErrorAbsolute | SimplifyOptions::Sparse;
    let corners = meshopt::simplify(welded.as_flattened(), &vertices, 0, error, options, None);
    corners.as_chunks::<3>().0.to_vec()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A closed box of squares, `n` a side, whose lid is a wave of that height.
    pub(in crate::math) fn wavy_box(n: u32, height: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        let mut face = |at: &dyn Fn(f32, f32) -> Vec3| {
            let first = positions.len() as u32;
            positions.extend(
                (0..=n)
                    .flat_map(|i| (0..=n).map(move |j| (i, j)))
                    .map(|(i, j)| at(i as f32 / n as f32, j as f32 / n as f32)),
            );
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let corner = |di: u32, dj: u32| first + (i + di) * (n + 1) + j + dj;
                triangles
                    .extend([[corner(0, 0), corner(1, 0), corner(0, 1)], [corner(1, 1), corner(0, 1), corner(1, 0)]]);
            }
        };
        let wave = |x: f32, y: f32| height * (9.0 * x).sin() * (7.0 * y).sin() * x * (1.0 - x) * y * (1.0 - y) * 16.0;
        face(&|u, v| Vec3::new(u, v, 1.0 + wave(u, v)));
        face(&|u, v| Vec3::new(v, u, 0.0));
        face(&|u, v| Vec3::new(0.0, v, u));
        face(&|u, v| Vec3::new(1.0, u, v));
        face(&|u, v| Vec3::new(u, 0.0, v));
        face(&|u, v| Vec3::new(v, 1.0, u));
        (positions, triangles)
    }

    /// Within a closed surface.
    pub(in crate::math) fn volume(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
        let below = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        triangles.iter().map(below).sum()
    }

    #[test]
    fn few_triangles_stay_close_and_closed() {
        let (positions, triangles) = wavy_box(64, 0.1);
        let [fewer, few] = [1e-3, 1e-2].map(|error| simplified(&positions, &triangles, error));
        assert!(fewer.len() < triangles.len() / 8, "{} of {}", fewer.len(), triangles.len());
        assert!(few.len() < fewer.len() / 2, "{} of {}", few.len(), fewer.len());
        for triangles in [fewer, few] {
            let across = adjacency::neighbours(&triangles, &positions);
            assert!(across.iter().flatten().all(|t| *t != adjacency::NONE), "no gaps");
            // A wave's volume is small, for its parts have both signs; an error of .01 everywhere would be 1 %.
            let volume = volume(&positions, &triangles);
            assert!((volume - 1.0).abs() < 0.01, "{volume}");
        }
    }
}

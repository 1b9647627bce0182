//! A ray against a triangle without cracks between triangles that share an edge.

use glam::{DVec3, Vec3};

/// A ray as the intersection test wants it: the axes permuted so that the direction is longest along z, then sheared so
/// that it is (0, 0, 1).
///
/// Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013, in double precision: of two triangles with a
/// common edge both compute the same edge function with opposite sign, so that no ray passes between them.
pub struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy)]
pub struct TriangleHit {
    /// Distance along the ray in units of its direction.
    pub t: f64,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: (f64, f64),
}

impl ShearedRay {
    /// `direction` is not zero; it need not be a unit vector.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let z = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let [x, y, z] = axes.map(|i| direction[i]);
        Self { origin, axes, shear: DVec3::new(x / z, y / z, 1.0 / z) }
    }

    /// Meets the triangle from either side at any t, also behind the origin.
    #[inline(always)]
    pub fn meet(&self, corners: &[Vec3; 3]) -> Option<TriangleHit> {
        let (ax, ay, az) = self.shear_corner(corners[0]);
        let (bx, by, bz) = self.shear_corner(corners[1]);
        let (cx, cy, cz) = self.shear_corner(corners[2]);
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None; // edge-on
        }
        let t = (u * az + v * bz + w * cz) * self.shear.z / sum;
        Some(TriangleHit { t, barycentric: (v / sum, w / sum) })
    }

    // Plain arithmetic: this is where the time goes.
    #[inline(always)]
    fn shear_corner(&self, corner: Vec3) -> (f64, f64, f64) {
        let p = (corner.as_dvec3() - self.origin).to_array();
        let [x, y, z] = self.axes;
        (p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], p[z])
    }
}

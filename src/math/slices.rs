//! The voxels of a scene's slices: a grid over its bounds.

use glam::{UVec3, Vec3};

/// Samples along a side of a voxel's face, which what it shows is averaged over; `SAMPLES` in `glsl/slices`.
pub const SAMPLES: u32 = 4;

/// A grid of voxels. Faces of the scene's bounds pass through the middles of the outermost ones, so that walls there are met
/// where they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Lowest corner.
    pub low: Vec3,
    /// Sides of a voxel along the axes; next to equal.
    pub voxel: Vec3,
    /// Voxels along the axes.
    pub dims: UVec3,
}

impl Grid {
    /// Over a box, the longest side of which is as long as `across` voxels.
    pub fn of([low, high]: [Vec3; 2], across: u32) -> Self {
        let extent = (high - low).max(Vec3::ZERO);
        let usual = extent.max_element() / across as f32;
        let usual = if usual > 0.0 { usual } else { 1.0 };
        // As many whole ones as come next to that size; an axis along which all is flat needs none between its faces.
        let between = (extent / usual).round().max(Vec3::ONE);
        let is_flat = extent.cmple(Vec3::splat(1e-3 * usual));
        let voxel = Vec3::select(is_flat, Vec3::splat(usual), extent / between);
        let between = Vec3::select(is_flat, Vec3::ZERO, between);
        Self { low: low - 0.5 * voxel, voxel, dims: between.as_uvec3() + 1 }
    }

    /// Number of voxels.
    pub fn voxels(&self) -> u64 {
        self.dims.to_array().map(u64::from).iter().product()
    }

    /// Middles of slices that a line may pass, at most.
    pub fn crossings(&self) -> u32 {
        self.dims.element_sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{uvec3, vec3};

    #[test]
    fn bounds_pass_through_middles() {
        let (low, high) = (vec3(-1.0, 2.0, 0.5), vec3(7.0, 5.1, 1.7));
        let grid = Grid::of([low, high], 16);
        assert_eq!(grid.dims, uvec3(17, 7, 3));
        let middle = |index: Vec3| grid.low + grid.voxel * (index + 0.5);
        assert!(middle(Vec3::ZERO).abs_diff_eq(low, 1e-6));
        assert!(middle((grid.dims - 1).as_vec3()).abs_diff_eq(high, 1e-5));
        assert_eq!((grid.voxels(), grid.crossings()), (357, 27));
    }

    #[test]
    fn what_is_flat_or_a_point_has_one_slice() {
        let grid = Grid::of([Vec3::ZERO, vec3(4.0, 0.0, 2.0)], 8);
        assert_eq!((grid.dims, grid.voxel), (uvec3(9, 1, 5), Vec3::splat(0.5)));
        assert_eq!(grid.low.y, -0.25);
        assert_eq!(Grid::of([Vec3::ONE; 2], 8).dims, UVec3::ONE);
    }
}

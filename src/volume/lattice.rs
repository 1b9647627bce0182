//! Cells of a volume and their corners, as whole numbers.

use glam::{DVec3, UVec3, uvec3};

/// Largest number of levels below the cells of the grid.
pub const MOST_LEVELS: u32 = 10;
/// Largest number of cells of the grid along a side.
pub const MOST_DIVISIONS: u32 = 1 << 10;

/// A box that is cut into `divisions` cells along each axis. Each cell is the root of an octree of up to `levels` levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Lowest corner, in the scene's coordinates.
    pub low: DVec3,
    /// Highest corner.
    pub high: DVec3,
    /// Cells of level 0 along each axis.
    pub divisions: UVec3,
    /// Finest level.
    pub levels: u32,
    /// Cells that are not cut any further; together they fill the box.
    pub leaves: Vec<Cell>,
}

/// A cell of some level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Level: each level has cells half as long as the one before.
    pub level: u32,
    /// Number of the cell among those of its level, along each axis.
    pub at: UVec3,
    /// Samples at its corners: number i is at the upper end along x if i & 1, along y if i & 2, along z if i & 4.
    pub corners: [u32; 8],
}

/// Offsets of a cell's corners, in cells; of its children, in children.
pub fn octants() -> [UVec3; 8] {
    std::array::from_fn(|i| uvec3(i as u32 & 1, i as u32 >> 1 & 1, i as u32 >> 2 & 1))
}

impl Lattice {
    /// A box without leaves.
    pub fn new(low: DVec3, high: DVec3, divisions: UVec3, levels: u32) -> Self {
        Self { low, high, divisions, levels, leaves: Vec::new() }
    }

    /// The corner of a cell of `level`, in steps of the finest level.
    pub fn corner(&self, level: u32, at: UVec3) -> UVec3 {
        at << (self.levels - level)
    }

    /// The level at which a corner first occurs: the coarsest that has it.
    pub fn level_of(&self, corner: UVec3) -> u32 {
        let twos = (corner.x | corner.y | corner.z).trailing_zeros();
        self.levels - twos.min(self.levels)
    }

    /// Position of a corner, in the scene's coordinates.
    pub fn place(&self, corner: UVec3) -> DVec3 {
        self.low + corner.as_dvec3() / (self.divisions << self.levels).as_dvec3() * (self.high - self.low)
    }

    /// Lengths of a cell's sides.
    pub fn size(&self, level: u32) -> DVec3 {
        (self.high - self.low) / (self.divisions << level).as_dvec3()
    }

    /// The cells of `level` that touch a corner of the finest level's steps.
    pub fn around(&self, level: u32, corner: UVec3) -> impl Iterator<Item = UVec3> {
        let most = self.divisions << level;
        let at = corner >> (self.levels - level);
        octants().into_iter().filter_map(move |back| {
            let fits = back.cmple(at).all() && (at - back).cmplt(most).all();
            fits.then(|| at - back)
        })
    }

    /// All cells of a level, without corners.
    pub fn cells_of(&self, level: u32) -> Vec<UVec3> {
        let most = self.divisions << level;
        let row = move |z| (0..most.y).flat_map(move |y| (0..most.x).map(move |x| uvec3(x, y, z)));
        (0..most.z).flat_map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_have_the_level_that_first_has_them() {
        let lattice = Lattice::new(DVec3::ZERO, DVec3::ONE, uvec3(1, 2, 1), 3);
        assert_eq!(lattice.level_of(uvec3(0, 8, 8)), 0);
        assert_eq!(lattice.level_of(uvec3(4, 8, 0)), 1);
        assert_eq!(lattice.level_of(uvec3(4, 6, 0)), 2);
        assert_eq!(lattice.level_of(uvec3(4, 6, 1)), 3);
        assert_eq!(lattice.around(0, uvec3(0, 8, 8)).count(), 2);
        assert_eq!(lattice.around(3, uvec3(1, 1, 1)).count(), 8);
        assert_eq!(lattice.cells_of(1).len(), 16);
    }
}

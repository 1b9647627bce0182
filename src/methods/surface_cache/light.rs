//! Irradiance of the surface cells, and the light that they reflect of it.

use super::SurfaceCache;
use super::choose::Chosen;
use super::interpolate::{Interpolator, Weight};
use super::reflected::Reflected;
use super::sides::Point;
use super::solve::Solution;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f32::consts::PI;
use std::ops::Range;

impl SurfaceCache<'_> {
    /// Irradiance of both sides of each cell by light that was reflected, W·m⁻².
    pub(super) fn irradiance(&self, chosen: &Chosen, reflected: &Reflected, solution: &Solution) -> Vec<[f32; 3]> {
        let of_triangle = |interpolator: &mut Interpolator<'_>, (triangle, cells): (u32, Range<u32>)| {
            let mut fits: HashMap<u32, Option<Fitted>> = HashMap::new();
            let mut of_side = |cell_side: u32| {
                let side = self.sides.of_cell(cell_side);
                let fit = fits.entry(side).or_insert_with(|| match reflected.shares(side) {
                    Some(shares) => Fitted::of(self.sides.point(side), shares, solution),
                    None => {
                        interpolator.find(side);
                        Fitted::of(self.sides.point(side), &interpolator.weights, solution)
                    }
                });
                let at = |fit: &Fitted| fit.irradiance(self.sides.cell_position(triangle, cell_side / 2));
                fit.as_ref().map_or(Vec3::ZERO, at).to_array()
            };
            (2 * cells.start..2 * cells.end).map(&mut of_side).collect::<Vec<_>>()
        };
        self.sides
            .cells_of_triangles()
            .with_min_len(64)
            .map_init(|| Interpolator::new(&chosen.places, &self.sides), of_triangle)
            .collect::<Vec<_>>()
            .concat()
    }

    /// Direct light and what is reflected of `irradiance`, of both sides of each cell.
    pub(super) fn light(&self, irradiance: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let of_cell = |(triangle, cell): (u32, u32)| {
            let both = 2 * cell as usize..2 * cell as usize + 2;
            let is_dark = irradiance[both.clone()].iter().all(|e| *e == [0.0; 3]);
            let reflected = if is_dark { Vec3::ZERO } else { self.sides.cell_albedo(triangle, cell) / PI };
            let of_side =
                |side: usize| (Vec3::from(self.direct[side]) + reflected * Vec3::from(irradiance[side])).into();
            both.map(of_side).collect::<Vec<[f32; 3]>>()
        };
        self.sides
            .cells_of_triangles()
            .with_min_len(64)
            .flat_map_iter(|(triangle, cells)| cells.map(move |cell| (triangle, cell)))
            .flat_map_iter(of_cell)
            .collect()
    }
}

/// Irradiance about the middle of a patch, as a linear fit has it.
struct Fitted {
    middle: Vec3,
    axes: [Vec3; 2],
    value: Vec3,
    slope: [Vec3; 2],
}

impl Fitted {
    /// That of a patch with a middle and shares of places, if there is any.
    fn of(middle: Point, shares: &[Weight], solution: &Solution) -> Option<Self> {
        let sum = |of: &dyn Fn(&Weight) -> f32| {
            let of_place = |w: &Weight| solution.irradiance[w.place as usize] * f64::from(of(w));
            shares.iter().map(of_place).sum::<DVec3>().as_vec3()
        };
        let value = sum(&|w| w.value);
        let slope = [sum(&|w| w.slope[0]), sum(&|w| w.slope[1])];
        let axes = middle.normal.any_orthonormal_pair().into();
        (value != Vec3::ZERO).then_some(Self { middle: middle.position, axes, value, slope })
    }

    /// At a point of the patch: not negative, and not twice of what there is in the middle.
    fn irradiance(&self, position: Vec3) -> Vec3 {
        let way = position - self.middle;
        let change = self.slope[0] * way.dot(self.axes[0]) + self.slope[1] * way.dot(self.axes[1]);
        self.value + change.clamp(-self.value, self.value)
    }
}

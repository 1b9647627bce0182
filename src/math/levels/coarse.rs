//! Cells of coarse triangles, and what they show.

use super::base::Around;
use super::cells::{self, Piece};
use super::{First, Graph, MOST_COARSE_CELLS, Surface, corners};
use rayon::prelude::*;

/// Cells along a side, to one of the surface's, of what is exact: as it is seen nearby, they show what is beneath them more nearly.
const EXACT_FINENESS: u32 = 2;

/// Coarse triangles with their cells.
pub struct CoarseCells<'a> {
    surface: &'a Surface<'a>,
    first: First,
    triangles: &'a [[u32; 3]],
    resolutions: Vec<u32>,
    /// First cell of each, and the end.
    pub first_cell: Vec<u32>,
}

impl<'a> CoarseCells<'a> {
    /// Cells for `triangles` that are off by `errors`.
    pub fn new(surface: &'a Surface<'a>, first: First, triangles: &'a [[u32; 3]], errors: &[f32]) -> Self {
        // Where it is shown, an error of the surface may be seen: no finer need its light be.
        let resolution = |(t, e): (&[u32; 3], &f32)| {
            let fineness = if *e > 0.0 { 1 } else { EXACT_FINENESS };
            fineness * surface.density.resolution(&corners(surface.positions, *t), f64::from(*e).powi(2))
        };
        let mut resolutions: Vec<u32> = triangles.iter().zip(errors).map(resolution).collect();
        let of_surface = surface.first_cell[surface.triangles.len()] - surface.first_cell[0];
        limit(&mut resolutions, u64::from(of_surface) * u64::from(MOST_COARSE_CELLS));
        let mut first_cell = vec![first.cell];
        first_cell.extend(resolutions.iter().scan(first.cell, |next, r| {
            *next += r * r;
            Some(*next)
        }));
        Self { surface, first, triangles, resolutions, first_cell }
    }

    /// For each cell the one of the surface that it shows.
    pub fn shown(&self, graph: &Graph) -> Vec<u32> {
        let of_merged = self.shown_by_merged(graph);
        let pieces = |clusters: &[usize]| {
            clusters.iter().flat_map(|c| &graph.clusters[*c].triangles).map(|t| self.piece(*t)).collect::<Vec<_>>()
        };
        let of_groups: Vec<_> = graph
            .groups
            .par_iter()
            .map(|g| cells::shown(pieces(&g.made), pieces(&g.replaced), g.bound.error))
            .collect();
        let mut shown_cell = vec![0; (self.first_cell[self.triangles.len()] - self.first.cell) as usize];
        // By level: what a finer coarse cell shows is known by then.
        for (coarse, fine) in of_merged.into_iter().chain(of_groups).flatten() {
            let through = fine.checked_sub(self.first.cell).map(|finer| shown_cell[finer as usize]);
            shown_cell[(coarse - self.first.cell) as usize] = through.unwrap_or(fine);
        }
        shown_cell
    }

    /// Of the finest triangles that are not the surface's own.
    fn shown_by_merged(&self, graph: &Graph) -> Vec<Vec<(u32, u32)>> {
        let finest = graph.clusters.iter().filter(|c| c.refined.is_none()).flat_map(|c| &c.triangles);
        let merged: Vec<u32> = finest.copied().filter(|t| *t >= self.first.triangle).collect();
        if merged.is_empty() {
            return Vec::new();
        }
        let around = Around::new(self.surface);
        let shown = |triangle: &u32| {
            let beneath = around.meeting(&self.triangles[(triangle - self.first.triangle) as usize]);
            let beneath = beneath.into_iter().map(|t| self.piece(t)).collect();
            cells::shown(vec![self.piece(*triangle)], beneath, around.margin)
        };
        merged.par_iter().map(shown).collect()
    }

    fn piece(&self, triangle: u32) -> Piece {
        let Surface { positions, triangles, first_cell, .. } = *self.surface;
        match triangle.checked_sub(self.first.triangle) {
            None => {
                let [from, end] = [0, 1].map(|i| first_cell[triangle as usize + i]);
                Piece::new(corners(positions, triangles[triangle as usize]), from, (end - from).isqrt())
            }
            Some(coarse) => {
                let coarse = coarse as usize;
                Piece::new(
                    corners(positions, self.triangles[coarse]),
                    self.first_cell[coarse],
                    self.resolutions[coarse],
                )
            }
        }
    }
}

/// Lowers resolutions, all by the same share, until they come to `most` cells, or to one each.
fn limit(resolutions: &mut [u32], most: u64) {
    let shared = |r: u32, share: f64| ((f64::from(r) * share) as u32).max(1);
    let cells = |share| resolutions.iter().map(|r| u64::from(shared(*r, share)).pow(2)).sum::<u64>();
    let mut share = 1.0;
    while cells(share) > most.max(resolutions.len() as u64) {
        share *= 0.95;
    }
    resolutions.iter_mut().for_each(|r| *r = shared(*r, share));
}

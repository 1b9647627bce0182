use super::*;
use crate::math::cells::centre;
use crate::math::density::Focus;
use crate::math::merge::tests::{shadow, sheet};
use glam::Vec2;

/// A sheet of `side`² squares of size 1/side, bent by `height`, a cell a triangle.
struct Sheet {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    first_cell: Vec<u32>,
}

impl Sheet {
    fn new(side: u32, height: f32) -> Self {
        let (positions, triangles) = sheet(side, |x, y| height * (7.0 * x).sin() * (5.0 * y).cos());
        let first_cell = (0..=triangles.len() as u32).collect();
        Self { positions, triangles, first_cell }
    }

    fn levels(&self) -> Levels {
        let Self { positions, triangles, first_cell } = self;
        let count = triangles.len() as u32;
        let corners = triangles.iter().map(|t| t.map(|v| positions[v as usize]));
        let density = Density::new(corners, count, &[]);
        let surface = Surface { positions, triangles, first_cell, density: &density, radius: 0.7 };
        Levels::new(&surface, First { triangle: count, cell: count })
    }

    fn corners(&self, levels: &Levels, triangle: u32) -> [Vec3; 3] {
        let all = self.triangles.len() as u32;
        let t = triangle
            .checked_sub(all)
            .map_or_else(|| self.triangles[triangle as usize], |coarse| levels.triangles[coarse as usize]);
        t.map(|v| self.positions[v as usize])
    }
}

fn shown<'a>(levels: &'a Levels, eye: Vec3, allowed: f32) -> impl Iterator<Item = u32> + 'a {
    let is_shown = move |c: &&Cluster| c.own.suffices(eye, allowed) && !c.coarser.suffices(eye, allowed);
    levels.clusters.iter().filter(is_shown).flat_map(|c| c.triangles.iter().copied())
}

#[test]
fn the_finest_level_is_every_triangle_once() {
    let levels = Sheet::new(64, 0.1).levels();
    let mut finest: Vec<u32> = shown(&levels, Vec3::splat(3.0), 0.0).collect();
    finest.sort_unstable();
    assert!(finest.into_iter().eq(0..2 * 64 * 64));
}

/// Whatever is chosen covers the sheet's plane once: its shadow on the plane has the area 1.
#[test]
fn from_anywhere_clusters_shown_are_the_whole_surface_once() {
    let sheet = Sheet::new(64, 0.1);
    let levels = sheet.levels();
    let mut fewest = usize::MAX;
    for (x, z) in [(0.3, 0.01), (0.9, 0.2), (0.5, 1.0), (-2.0, 5.0), (0.5, 100.0)] {
        let chosen: Vec<u32> = shown(&levels, Vec3::new(x, 0.4, z), 0.03).collect();
        let total: f32 = chosen.iter().map(|t| shadow(sheet.corners(&levels, *t))).sum();
        assert!((total - 1.0).abs() < 1e-4, "{total} from {x}, {z}");
        fewest = fewest.min(chosen.len());
    }
    assert!(fewest < 64 * 64 / 20, "{fewest} triangles at a distance");
}

/// A coarse cell shows a cell of the surface, near it: no further away than the errors and the cells' own sizes allow.
#[test]
fn coarse_cells_show_cells_of_the_surface_beside_them() {
    let sheet = Sheet::new(64, 0.05);
    let levels = sheet.levels();
    let count = sheet.triangles.len() as u32;
    let middle = |t: u32| sheet.corners(&levels, t).iter().sum::<Vec3>() / 3.0;
    for cluster in levels.clusters.iter().filter(|c| c.level > 0) {
        for triangle in &cluster.triangles {
            let index = (triangle - count) as usize;
            let [first, end] = [levels.first_cell[index], levels.first_cell[index + 1]];
            let corners = sheet.corners(&levels, *triangle);
            for cell in first..end {
                let uv = centre((end - first).isqrt(), cell - first);
                let at = corners[0] + uv.x * (corners[1] - corners[0]) + uv.y * (corners[2] - corners[0]);
                let seen = levels.shown_cell[(cell - count) as usize];
                assert!(seen < count);
                let distance = middle(seen).distance(at);
                let allowed = 4.0 * cluster.own.error + 3.0 * cluster.level as f32 / 64.0;
                assert!(distance < allowed, "level {}: {distance} above {allowed}", cluster.level);
            }
        }
    }
}

/// Every level of flat ground is exact, so that its cells are to be as fine as the surface's: as many for each level.
#[test]
fn coarse_cells_are_no_more_than_memory_is_foreseen_for() {
    let Sheet { positions, triangles, .. } = Sheet::new(128, 0.0);
    for foci in [&[][..], &[Focus::camera(Vec3::new(0.5, 0.5, 0.1), 0.7)]] {
        let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
        let density = Density::new(triangles.iter().map(corners), 9 * triangles.len() as u32, foci);
        let counts = triangles.iter().map(|t| density.resolution(&corners(t), 0.0).pow(2));
        let end = |end: &mut u32, n: u32| Some(std::mem::replace(end, *end + n));
        let first_cell: Vec<u32> = counts.chain([0]).scan(0, end).collect();
        let cells = first_cell[triangles.len()];
        let surface = Surface {
            positions: &positions,
            triangles: &triangles,
            first_cell: &first_cell,
            density: &density,
            radius: 0.7,
        };
        let coarse = Levels::new(&surface, First { triangle: triangles.len() as u32, cell: cells }).shown_cell.len();
        let share = coarse as f64 / f64::from(cells);
        assert!(share > 0.9 * f64::from(MOST_COARSE_CELLS), "few: nothing to limit in {share}");
        assert!(share <= f64::from(MOST_COARSE_CELLS), "{share}");
    }
}

/// What is flat needs few triangles, however near one looks: those cover it once, and their cells show what lies beneath them.
#[test]
fn flat_ground_is_exact_by_fewer_triangles() {
    let side = 64;
    let mut sheet = Sheet::new(side, 0.0);
    let bent = |p: &Vec3| Vec3::new(p.x, p.y, if p.x > 0.75 { 0.1 * (40.0 * (p.x - 0.75) * p.y).sin() } else { 0.0 });
    sheet.positions = sheet.positions.iter().map(bent).collect();
    let levels = sheet.levels();
    let count = sheet.triangles.len() as u32;
    let finest: Vec<_> = levels.clusters.iter().filter(|c| c.level == 0).flat_map(|c| &c.triangles).copied().collect();
    let nearby: Vec<u32> = shown(&levels, Vec3::new(0.3, 0.4, 0.01), 0.0).collect();
    assert!(nearby.len() == finest.len() && nearby.len() < sheet.triangles.len() / 2, "{} of {count}", nearby.len());
    let is_bent = |t: &[u32; 3]| t.iter().all(|v| sheet.positions[*v as usize].x > 0.76);
    assert!(nearby.iter().filter(|t| **t < count).count() >= sheet.triangles.iter().filter(|t| is_bent(t)).count());
    let area: f32 = nearby.iter().map(|t| shadow(sheet.corners(&levels, *t))).sum();
    assert!((area - 1.0).abs() < 1e-4, "{area}");
    for triangle in nearby.into_iter().filter(|t| *t >= count) {
        let index = (triangle - count) as usize;
        let [first, end] = [levels.first_cell[index], levels.first_cell[index + 1]];
        let [a, b, c] = sheet.corners(&levels, triangle);
        for cell in first..end {
            let uv = centre((end - first).isqrt(), cell - first);
            let at = a + uv.x * (b - a) + uv.y * (c - a);
            let [p, q, r] = sheet.corners(&levels, levels.shown_cell[(cell - count) as usize]).map(|p| p.truncate());
            let within = |a: Vec2, b: Vec2| (b - a).perp_dot(at.truncate() - a) > -1e-6;
            assert!(within(p, q) && within(q, r) && within(r, p), "{at} is not beneath");
        }
    }
}

//! Levels of detail: clusters of triangles, and coarser ones that stand for groups of them at a distance.
//!
//! The graph of clusters of Karis, "Nanite: A Deep Dive" (2021), built by meshoptimizer: neighbouring clusters form a
//! group, whose surface is simplified to half its triangles while its border stays; what comes out is cut into clusters
//! again, and grouped anew. A cluster is shown where its own error is small enough for the distance and the error of
//! what replaces it is not. Both are measured from boxes that hold all that a group stands for, so that wherever one looks
//! from, the clusters shown are the whole surface once, without a gap.
//!
//! Where a surface has many vertices in flat places, the finest level is the same surface by fewer triangles; those that are not the
//! surface's own are coarse triangles as well.
//!
//! Coarse triangles have cells of light like those of the surface, each of which shows one of the surface's.

mod base;
mod cells;
mod coarse;
#[cfg(test)]
mod tests;

use super::adjacency;
use super::density::Density;
use coarse::CoarseCells;
use glam::Vec3;
use meshopt::{ClodConfig, ClodMesh, VertexDataAdapter};
use rayon::slice::ParallelSliceMut;

/// Triangles of a cluster, at most.
pub const CLUSTER: usize = 64;
/// Clusters of a group, about: of 4 to 24 the number that leaves fewest triangles to draw of a scene of a million.
const GROUP: usize = 8;
/// Most cells of coarse triangles to one of the surface's: where there would be more, as on flat ground whose every level is
/// exact, they are larger. Only that each coarse triangle has one goes before.
pub const MOST_COARSE_CELLS: u32 = 5;

/// How wrong a group's simplification is, and what it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Lowest corner of a box around all that it stands for, at every level.
    pub low: Vec3,
    /// Highest corner.
    pub high: Vec3,
    /// Distance from the finer surface, and from what that stands for, in scene units.
    pub error: f32,
}

impl Bound {
    /// Of what is exact.
    pub const EXACT: Self = Self { low: Vec3::ZERO, high: Vec3::ZERO, error: 0.0 };
    /// Of what nothing replaces.
    pub const NEVER: Self = Self { low: Vec3::ZERO, high: Vec3::ZERO, error: f32::MAX };

    /// From a point to the nearest one of its box.
    pub fn distance(&self, p: Vec3) -> f32 {
        (self.low - p).max(p - self.high).max(Vec3::ZERO).length()
    }

    /// Whether it is fine enough to be looked at from `eye`, where an error of `allowed` is at distance 1.
    pub fn suffices(&self, eye: Vec3, allowed: f32) -> bool {
        self.error <= allowed * self.distance(eye)
    }
}

/// Neighbouring triangles of one level.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// Numbers of the triangles: those of the surface, then those of [`Levels::triangles`].
    pub triangles: Vec<u32>,
    /// Number of simplifications behind it.
    pub level: u32,
    /// Of itself.
    pub own: Bound,
    /// Of what replaces it.
    pub coarser: Bound,
}

/// Coarser levels of a surface.
#[derive(Debug)]
pub struct Levels {
    /// Corners of the coarse triangles, level by level: vertices of the surface.
    pub triangles: Vec<[u32; 3]>,
    /// All clusters, those of the surface itself included.
    pub clusters: Vec<Cluster>,
    /// First cell of each coarse triangle, and the end.
    pub first_cell: Vec<u32>,
    /// For each coarse cell the cell of the surface that it shows.
    pub shown_cell: Vec<u32>,
}

/// The surface to simplify.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Vertex positions.
    pub positions: &'a [Vec3],
    /// Triangles.
    pub triangles: &'a [[u32; 3]],
    /// First cell of each triangle, and the end.
    pub first_cell: &'a [u32],
    /// How densely it is cut into cells.
    pub density: &'a Density,
    /// Radius of its core, beside which errors count.
    pub radius: f32,
}

/// Numbers from which coarse things are counted: more than the surface's, which others may follow.
#[derive(Clone, Copy, Debug)]
pub struct First {
    /// Number of the first coarse triangle.
    pub triangle: u32,
    /// Number of the first coarse cell.
    pub cell: u32,
}

/// What the simplifier makes: clusters name groups, and triangles by their place in `corners`.
struct Graph {
    groups: Vec<Group>,
    clusters: Vec<Made>,
    corners: Vec<[u32; 3]>,
}

struct Group {
    bound: Bound,
    level: u32,
    /// Clusters that are simplified together.
    replaced: Vec<usize>,
    /// Those that replace them.
    made: Vec<usize>,
}

struct Made {
    group: usize,
    refined: Option<usize>,
    triangles: Vec<u32>,
}

impl Levels {
    /// Simplifies `surface`.
    pub fn new(surface: &Surface<'_>, first: First) -> Self {
        // Without seams: only positions matter.
        let welded = adjacency::welded(surface.positions, surface.triangles);
        let mut graph = Graph::new(surface.positions, &base::of(surface, &welded));
        let (triangles, errors) = graph.name_triangles(&welded, first.triangle);
        let cells = CoarseCells::new(surface, first, &triangles, &errors);
        let (shown_cell, first_cell) = (cells.shown(&graph), cells.first_cell);
        Self { clusters: graph.into_clusters(), triangles, first_cell, shown_cell }
    }
}

impl Graph {
    fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let bytes = bytemuck::cast_slice(positions);
        let vertices = VertexDataAdapter::new(bytes, size_of::<Vec3>(), 0).expect("positions are whole vertices");
        let mesh = ClodMesh::new(triangles.as_flattened(), &vertices);
        let mut graph = Self { groups: Vec::new(), clusters: Vec::new(), corners: Vec::new() };
        meshopt::clod_build(config(), &mesh, |group, clusters| graph.add(&group, clusters));
        graph.bound(positions);
        graph
    }

    /// Takes a group over; groups come level by level.
    fn add(&mut self, group: &meshopt::ClodGroup, clusters: &[meshopt::ClodCluster<'_>]) -> i32 {
        let index = self.groups.len();
        let bound = Bound { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, error: group.simplified.error };
        let replaced = (self.clusters.len()..self.clusters.len() + clusters.len()).collect();
        self.groups.push(Group { bound, level: group.depth as u32, replaced, made: Vec::new() });
        for cluster in clusters {
            let refined = usize::try_from(cluster.refined).ok();
            if let Some(finer) = refined {
                self.groups[finer].made.push(self.clusters.len());
            }
            let first = self.corners.len() as u32;
            self.corners.extend(cluster.indices.as_chunks::<3>().0);
            self.clusters.push(Made { group: index, refined, triangles: (first..self.corners.len() as u32).collect() });
        }
        index as i32
    }

    /// Boxes of all that groups stand for, and errors no less than those of what they replace.
    fn bound(&mut self, positions: &[Vec3]) {
        for index in 0..self.groups.len() {
            let mut bound = self.groups[index].bound;
            for cluster in &self.groups[index].replaced {
                let Made { refined, triangles, .. } = &self.clusters[*cluster];
                let vertices = triangles.iter().flat_map(|t| self.corners[*t as usize]);
                for p in vertices.map(|v| positions[v as usize]) {
                    (bound.low, bound.high) = (bound.low.min(p), bound.high.max(p));
                }
                if let Some(finer) = refined.map(|g| self.groups[g].bound) {
                    (bound.low, bound.high) = (bound.low.min(finer.low), bound.high.max(finer.high));
                    bound.error = bound.error.max(finer.error);
                }
            }
            self.groups[index].bound = bound;
        }
    }

    /// Gives triangles their numbers, those of `welded` that they are; returns the others, level by level, with their errors.
    fn name_triangles(&mut self, welded: &[[u32; 3]], first_coarse: u32) -> (Vec<[u32; 3]>, Vec<f32>) {
        let names = self.names(welded);
        let (mut coarse, mut errors) = (Vec::new(), Vec::new());
        for cluster in &mut self.clusters {
            for triangle in &mut cluster.triangles {
                let place = *triangle as usize;
                *triangle = names[place].unwrap_or_else(|| {
                    coarse.push(self.corners[place]);
                    errors.push(cluster.refined.map_or(0.0, |group| self.groups[group].bound.error));
                    first_coarse + coarse.len() as u32 - 1
                });
            }
        }
        (coarse, errors)
    }

    /// The number in `triangles` of each triangle of the finest clusters that is one of them, by its place: found by its corners,
    /// whichever comes first.
    fn names(&self, triangles: &[[u32; 3]]) -> Vec<Option<u32>> {
        let turned = |t: [u32; 3]| match t.iter().min() {
            Some(least) if *least == t[1] => [t[1], t[2], t[0]],
            Some(least) if *least == t[2] => [t[2], t[0], t[1]],
            _ => t,
        };
        let mut known: Vec<_> = (0_u32..).zip(triangles).map(|(name, t)| (turned(*t), name)).collect();
        let finest = self.clusters.iter().filter(|c| c.refined.is_none()).flat_map(|c| &c.triangles);
        let mut asked: Vec<_> = finest.map(|place| (turned(self.corners[*place as usize]), *place)).collect();
        known.par_sort_unstable();
        asked.par_sort_unstable();
        let mut names = vec![None; self.corners.len()];
        let mut candidates = known.into_iter().peekable();
        for (corners, place) in asked {
            while candidates.next_if(|(other, _)| *other < corners).is_some() {}
            names[place as usize] = candidates.next_if(|(other, _)| *other == corners).map(|(_, name)| name);
        }
        names
    }

    fn into_clusters(self) -> Vec<Cluster> {
        let Self { groups, clusters, .. } = self;
        let cluster = |made: Made| Cluster {
            level: groups[made.group].level,
            own: made.refined.map_or(Bound::EXACT, |g| groups[g].bound),
            coarser: groups[made.group].bound,
            triangles: made.triangles,
        };
        clusters.into_iter().map(cluster).collect()
    }
}

/// Only what keeps the surface's topology: what moves pieces onto each other shows what they hide.
fn config() -> ClodConfig {
    ClodConfig {
        // As many as triangles have corners: only triangles limit a cluster.
        max_vertices: 3 * CLUSTER,
        partition_size: GROUP,
        cluster_spatial: true,
        cluster_fill_weight: 1.0,
        optimize_clusters: false,
        simplify_permissive: false,
        simplify_fallback_sloppy: false,
        ..meshopt::clod_default_config(CLUSTER)
    }
}

fn corners(positions: &[Vec3], triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|v| positions[v as usize])
}

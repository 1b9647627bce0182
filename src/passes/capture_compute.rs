//! The fused capture: hemicubes, cubes, or hemispheres on a disc, rasterised in compute, in shared memory.
//!
//! Where a subgroup draws a face, it also sums it: E, its gradients and second derivatives, 1/R. Of what texels see only what
//! those at borders between faces see is written then, for the edges that [`super::integrate`] adds, and the sides' distances,
//! which [`super::splat`] asks for what is hidden.
//!
//! The same texels as [`super::capture`] sees, within the rasterisation rules: texels whose centre lies on an edge may fall
//! to either side, and of two surfaces whose distances differ by less than a 13,000th either may be seen. Alpha
//! masks are bits on the triangles ([`crate::scene::opacity`]): their borders are half a texel of the texture off at most,
//! or a 64th of the triangle's side.
//!
//! Outlines may be followed over the triangles' edges ([`crate::math::outline`]): the translation gradient then knows of what is
//! seen edge-on, thinner than a texel. Where a subgroup sums, it does so within its face; else [`super::integrate`] does.
//!
//! With [`super::slices`] only what is near is drawn; what is far is looked up there.

use super::cluster_tree::ClusterTree;
use super::counter::Counter;
use super::gathered::{FaceCounts, Gathered, Kinds};
use super::geometry::Geometry;
use super::slices::Slices;
use crate::math::capture::{Edge, Faces, Projection, Table, Texel};
use crate::math::slices::Grid;
use crate::scene::Scene;
use crate::vk::{
    Binding, Buffer, BufferView, Commands, ComputePipeline, DescriptorSet, Device, Error, Memory, PipelineLayout,
    Result, SetLayout, Specialisation, TexelBuffer,
    gpu_types::{FaceTexel, Frame},
    pass::Recorder,
    spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Octets that are listed at once (`LIST` of the shader).
const LISTED: u32 = 2016;
/// Triangles without levels of detail, at most, that one subgroup draws at 32² texels: at 64² half as many, for each then takes
/// about twice the rounds.
const MOST_EXACT: u64 = 3 << 16;
/// Invocations of a workgroup that is no subgroup.
const THREADS: u32 = 64;
/// Steps of a subgroup along a row of texels, at most (`LONGEST_ROW` of the shader).
const MOST_STEPS: u32 = 8;
/// Nearest depth that captures tell apart, relative to the radius of the scene's core: what records are lifted by.
const NEAREST: f32 = 1.0 / (1 << 18) as f32;
/// Middles of slices that an invocation passes, at most, before it is left with too few rounds of loops for all else: three
/// quarters of those that llvmpipe has.
const MOST_CROSSINGS: u32 = 3 << 14;
/// Values of two floats in a surface cell.
const PAIRS: u64 = 3;
const TABLES: &str = "capture tables";

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    /// Around the scene: centre, radius.
    sphere: [f32; 4],
    /// Error of coarse triangles that is allowed at distance 1.
    allowed_error: f32,
    texel_count: u32,
    /// Texels at borders between faces.
    border_count: u32,
    /// Cells from here on are coarse ones.
    first_coarse_cell: u32,
    /// Clusters of the tree.
    clusters: u32,
    /// Children of its root.
    root: u32,
    /// Lowest corner of the slices' grid, voxels in a unit of length, and voxels, along the axes.
    low: [f32; 3],
    per_length: [f32; 3],
    dims: [u32; 3],
    /// Distance within which all is drawn as it is.
    near: f32,
    /// Longest side of a voxel.
    voxel: f32,
    /// From within the scene no depths are told apart that are nearer.
    nearest: f32,
}

/// How a record looks.
pub struct Looks {
    size: u32,
    lod_error: f32,
    table: Table,
    views: ViewTable,
    /// Whether faces may be summed where they are rasterised, by the cosine.
    may_sum: bool,
    shared: bool,
    far: Option<Far>,
}

/// The views that a workgroup each draws: the first in full, the others with fewer rows of texels where a horizon cuts them.
#[derive(Clone, Copy)]
struct ViewTable {
    count: u32,
    side_rows: u32,
    is_disc: bool,
}

impl ViewTable {
    fn of(projection: Projection, size: u32) -> Self {
        let (count, side_rows) = match projection {
            Projection::Hemicube => (5, size / 2),
            Projection::Cube => (6, size),
            Projection::Hemisphere | Projection::Plane { .. } => (1, size),
        };
        Self { count, side_rows, is_disc: projection == Projection::Hemisphere }
    }
}

/// Specialisation constants of the shader, in their order.
struct Constants {
    size: u32,
    has_masks: bool,
    has_sky: bool,
    has_planes: bool,
    is_disc: bool,
    has_levels: bool,
    threads: u32,
    counts: bool,
    may_end: bool,
    has_slices: bool,
    has_outlines: bool,
    view_count: u32,
    side_rows: u32,
}

impl Constants {
    fn specialisation(&self) -> Specialisation {
        let flags = [self.has_masks, self.has_sky, self.has_planes, self.is_disc, self.has_levels].map(u32::from);
        let extras = [self.counts, self.may_end, self.has_slices, self.has_outlines].map(u32::from);
        let all = [self.size].into_iter().chain(flags).chain([self.threads]).chain(extras);
        Specialisation(all.chain([self.view_count, self.side_rows]).collect())
    }
}

/// What is far of a record, and seen as slices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Far {
    /// Of their voxels.
    pub grid: Grid,
    /// Distance within which triangles are drawn.
    pub near: f32,
}

impl Looks {
    /// By `projection`, any but a plane, with `size` texels a side; coarse triangles, where the scene has levels
    /// of detail, are wrong by `lod_error` texels at most.
    pub fn new(projection: Projection, size: u32, lod_error: f32) -> Self {
        let (table, views) = (projection.table(size), ViewTable::of(projection, size));
        let may_sum = projection == Projection::Hemicube;
        Self { size, lod_error, table, views, may_sum, shared: false, far: None }
    }

    /// The same, each view `shared` by a whole workgroup where one subgroup could draw it: no device ends its loops so soon.
    pub fn shared_by_workgroups(self, shared: bool) -> Self {
        Self { shared, ..self }
    }

    /// The same, but every texel is written, for another pass to integrate.
    pub fn without_sums(self) -> Self {
        Self { may_sum: false, ..self }
    }

    /// The same, but what is `far` as slices.
    pub fn with_slices(self, far: Option<Far>) -> Self {
        Self { far, ..self }
    }

    /// Texels of a record.
    pub fn texels(&self) -> u32 {
        self.table.texels.len() as u32
    }

    /// Of each texel of a disc, its direction and its place in the square (bits).
    fn disc(&self) -> Vec<[f32; 4]> {
        let spot = |t: &Texel| t.direction.as_vec3().extend(f32::from_bits(t.y * self.size + t.x)).to_array();
        self.table.texels.iter().map(spot).collect()
    }

    /// Of each texel what its face is summed by; then of those at borders, face by face, place in the face and number (bits).
    fn face_texels(&self, faces: &Faces) -> Vec<[f32; 4]> {
        let edge = |edge: &Option<Edge>| {
            let Some(edge) = edge else { return ([0.0; 4], [0.0; 2]) };
            let (step, bend) = (edge.step.as_vec3(), edge.bend().as_vec3());
            let closeness = self.table.between(edge).length_recip() as f32;
            ([step.x, step.y, closeness, bend.x], [bend.y, bend.z])
        };
        let texel = |(t, edges): (&Texel, &[Option<Edge>; 2])| {
            let turn = t.turn().as_vec3();
            let [(left, [a, b]), (up, [c, d])] = edges.each_ref().map(edge);
            FaceTexel { weights: [t.weight() as f32, turn.x, turn.y, 0.0], left, up, bend: [a, b, c, d] }
        };
        let texels: Vec<FaceTexel> = self.table.texels.iter().zip(&faces.inner).map(texel).collect();
        let place = |(t, number): (&Texel, &Option<u32>)| {
            number.map(|number| [t.y * self.size + t.x, number, 0, 0].map(f32::from_bits))
        };
        let places = self.table.texels.iter().zip(&faces.border).filter_map(place);
        bytemuck::cast_slice(&texels).iter().copied().chain(places).collect()
    }
}

/// The pass.
pub struct CaptureCompute {
    pipeline: ComputePipeline,
    set: DescriptorSet,
    push: Push,
    /// Frames to look from.
    pub frames: Buffer,
    views: u32,
    /// Whether whole workgroups share each view.
    shared: bool,
    /// Not 0 once the device has ended loops; none where it does not.
    ended: Option<Counter>,
    _viewed: Option<BufferView>,
    _table: Option<TexelBuffer>,
    /// What outlines are followed by ([`ClusterTree::neighbours`]).
    pub(super) neighbours: Option<TexelBuffer>,
    _layout: SetLayout,
}

impl CaptureCompute {
    /// What keeps captures by `projection` with `size` texels a side in `scene` from fitting, if something does but its tree's
    /// size ([`super::cluster_tree::TreeSize`]): a face must fit into shared memory, tables into buffers, the alpha masks into
    /// their budget.
    pub fn misfit(device: &Device, scene: &Scene, projection: Projection, size: u32) -> Option<String> {
        let most = device.capabilities.limits.max_compute_shared_memory_size;
        if shared_bytes(size) > most {
            return Some(format!("a face of {size} × {size} texels does not fit into {most} bytes of shared memory"));
        }
        if u64::from(tables(projection, size)) > Gathered::most_viewed(device, Kinds { sky: false, planes: false }) {
            return Some(format!("tables of {size} × {size} texels do not fit into a texel buffer of the device"));
        }
        scene.too_many_masked()
    }

    /// What is summed face by face, where that is done: by subgroups.
    pub fn sums(device: &Device, on: (&Geometry, &ClusterTree), looks: &Looks) -> Option<FaceCounts> {
        let most = device.capabilities.limits.max_texel_buffer_elements;
        let fits = looks.may_sum && u64::from(on.0.cell_count) * PAIRS <= u64::from(most);
        let threads = Self::subgroup(device, on, looks).filter(|_| fits)?;
        let border = Faces::of(&looks.table).border_count;
        Some(FaceCounts { texels: looks.texels(), border, parts: looks.views.count * threads })
    }

    /// Invocations of the subgroup that draws a view, if one is to: of faces alone.
    fn subgroup(device: &Device, on: (&Geometry, &ClusterTree), looks: &Looks) -> Option<u32> {
        let fits = !looks.views.is_disc && !looks.shared;
        let threads = device.capabilities.subgroup.filter(|_| fits)?;
        let crossings = looks.far.map_or(0, |far| far.grid.crossings() * looks.size * looks.size / threads);
        (crossings <= MOST_CROSSINGS && by_subgroups(device, threads, on, looks.size)).then_some(threads)
    }

    /// Captures up to `capacity` times what `looks` says, of the triangles in `tree` and of `slices` where that wants some, into
    /// `gathered`; `sky` where that keeps it. With `neighbours` ([`ClusterTree::neighbours`]) outlines are followed. What is drawn,
    /// triangles times views by octets, adds to `drawn`.
    pub fn new(
        device: &Arc<Device>,
        (geometry, tree, slices): (&Geometry, &ClusterTree, Option<&Slices>),
        neighbours: Option<TexelBuffer>,
        (gathered, sky): (&Gathered, Option<&Buffer>),
        looks: &Looks,
        capacity: u32,
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let (size, view_table) = (looks.size, looks.views);
        let frames = u64::from(capacity) * size_of::<Frame>() as u64;
        let frames = Buffer::new(device, "capture frames", frames, Memory::Device)?;
        let faces = gathered.sums.is_some().then(|| Faces::of(&looks.table));
        let table = match &faces {
            Some(faces) => Some(TexelBuffer::with_data(device, TABLES, &looks.face_texels(faces))?),
            None if view_table.is_disc => Some(TexelBuffer::with_data(device, TABLES, &looks.disc())?),
            None => None,
        };
        let summed = gathered.sums.as_ref();
        let ended = device.is_cpu().then(|| Counter::cleared(device)).transpose()?;
        let cells = &geometry.cell_radiance;
        let viewed = summed.map(|_| BufferView::of_pairs(device, cells, "surface radiance")).transpose()?;
        let bindings = [
            Binding::Storage(&frames),
            Binding::TexelBuffer(&tree.octets),
            Binding::TexelBuffer(&tree.corners),
            // What the scene does not have is never read.
            Binding::TexelBuffer(tree.masks.as_ref().unwrap_or(&tree.corners)),
            viewed.as_ref().map_or(Binding::Storage(cells), Binding::View),
            Binding::Storage(sky.unwrap_or(&geometry.first_cell)),
            Binding::Storage(gathered.buffer()),
            Binding::TexelBuffer(table.as_ref().unwrap_or(&tree.corners)),
            Binding::Storage(tree.shown_cell.as_ref().unwrap_or(&geometry.first_cell)),
            Binding::TexelBuffer(&tree.nodes),
            Binding::Storage(drawn.map_or(&frames, Counter::buffer)),
            Binding::Storage(ended.as_ref().map_or(&frames, Counter::buffer)),
            Binding::TexelBuffer(slices.map_or(&tree.corners, |slices| &slices.sides)),
        ];
        let of_sums = summed.iter().flat_map(|sums| [&sums.distances, &sums.parts].map(Binding::Storage));
        let of_outlines = summed.map(|_| Binding::TexelBuffer(neighbours.as_ref().unwrap_or(&tree.corners)));
        let bindings: Vec<_> = bindings.into_iter().chain(of_sums).chain(of_outlines).collect();
        let layout = SetLayout::of(device, &bindings)?;
        let set = DescriptorSet::new(&layout, &bindings)?;
        let pipeline_layout = PipelineLayout::new(device, &[&layout], size_of::<Push>() as u32)?;
        let far = looks.far.unwrap_or_default();
        let push = Push {
            sphere: ((geometry.bounds[0] + geometry.bounds[1]) * 0.5).extend(geometry.radius).to_array(),
            // A face is 2 wide at distance 1.
            allowed_error: looks.lod_error * 2.0 / size as f32,
            texel_count: looks.texels(),
            border_count: faces.map_or(0, |faces| faces.border_count),
            first_coarse_cell: geometry.cell_count,
            clusters: tree.clusters,
            root: tree.root.unwrap_or(0),
            low: far.grid.low.to_array(),
            per_length: far.grid.voxel.recip().to_array(),
            dims: far.grid.dims.to_array(),
            near: far.near,
            voxel: far.grid.voxel.max_element(),
            nearest: NEAREST * geometry.core.radius,
        };
        let kinds = gathered.kinds;
        let (threads, code) = match summed {
            Some(sums) => (sums.part_count / view_table.count, spirv!("capture_compute", "subgroup.comp")),
            None => match Self::subgroup(device, (geometry, tree), looks).filter(|_| !looks.may_sum) {
                Some(threads) => (threads, spirv!("capture_compute", "subgroup_gather.comp")),
                None => (THREADS, spirv!("capture_compute", "workgroup.comp")),
            },
        };
        let constants = Constants {
            size,
            has_masks: tree.masks.is_some(),
            has_sky: kinds.sky,
            has_planes: kinds.planes,
            is_disc: view_table.is_disc,
            has_levels: tree.has_levels(),
            threads,
            counts: drawn.is_some(),
            may_end: ended.is_some(),
            has_slices: looks.far.is_some(),
            has_outlines: neighbours.is_some(),
            view_count: view_table.count,
            side_rows: view_table.side_rows,
        };
        let constants = constants.specialisation();
        let pipeline = ComputePipeline::new("capture_compute", &pipeline_layout, code, &constants)?;
        Ok(Self {
            pipeline,
            set,
            push,
            frames,
            views: view_table.count,
            shared: summed.is_none(),
            ended,
            _viewed: viewed,
            _table: table,
            neighbours,
            _layout: layout,
        })
    }

    /// Captures the first `count` frames.
    pub fn record(&self, commands: &Commands, count: u32) {
        self.pipeline.bind(commands, &[&self.set]);
        self.pipeline.layout.push(commands, &self.push);
        self.pipeline.dispatch(commands, [count * self.views, 1, 1]);
    }

    /// Makes sure that all that was captured so far is whole.
    pub fn check(&self, recorder: &mut Recorder) -> Result<()> {
        let Some(ended) = &self.ended else { return Ok(()) };
        recorder.submit(|recording| {
            recording.pass("readback", |c| {
                ended.record_readback(c);
                Ok(())
            })
        })?;
        if ended.read() == 0 { Ok(()) } else { Err(Error::LoopsEnded { shared: self.shared }) }
    }
}

/// Whether a workgroup is to be one subgroup, of so many invocations: on a CPU whose vector unit runs one. A driver that has to
/// stop and go on with invocations keeps their variables in memory (llvmpipe: 1.4 times the time). But all of a view's work falls
/// to one then, and llvmpipe ends every loop of an invocation after 65,535 rounds of all its loops together: only where few
/// triangles are drawn as they are, the fewer the more texels they have. Where large ones lie
/// over each other that may still be too much, which the shader tells ([`CaptureCompute::check`]).
fn by_subgroups(device: &Device, threads: u32, (geometry, tree): (&Geometry, &ClusterTree), size: u32) -> bool {
    // Of levels of detail a view draws and visits a small part: of four million triangles twice what it does of 66,000.
    let share = |masked: bool| if tree.has_levels() && !masked { 32 } else { 1 };
    let drawn = geometry.ranges.iter().map(|r| r.triangles.len() as u64 / share(r.masked.is_some())).sum::<u64>();
    let few = drawn * u64::from(size) <= MOST_EXACT * 32;
    // Rows of texels are whole steps of a subgroup.
    let steps = size / threads <= MOST_STEPS && size.is_multiple_of(threads);
    let fits = threads >= 8 && THREADS.is_multiple_of(threads) && steps;
    few && fits && device.is_cpu()
}

/// Values of the larger table that [`super::integrate`] fetches, at most: three for each of two edges a texel.
fn tables(projection: Projection, size: u32) -> u32 {
    let squares = match projection {
        Projection::Hemicube => 3,
        Projection::Cube => 6,
        Projection::Plane { .. } | Projection::Hemisphere => 1,
    };
    3 * 2 * squares * size * size
}

/// Shared memory of a workgroup: keys, octets, clusters, the walk's stack, and two words for counting.
fn shared_bytes(size: u32) -> u32 {
    4 * (size * size + LISTED + 2 * THREADS + 10 * THREADS + 2)
}
